//! Receivers, spheres and shapes: what of a pose is computed on the CPU. That is where joints are and spheres that
//! follow; vertices and normals only if it computes the radiance, too.

use relume_formats::basis::diffuse::blend;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::sphere_shadows::{
    CasterMeshes, CasterTriangle, Casters, Receiver, Spheres, neighbours, receivers,
};
use relume_formats::kinds::sphere_shadows::{Casts, ShadowObject};
use relume_formats::kinds::{SphereSet, SphereShadows, StoredScene};
use relume_formats::shape::{DeformingMesh, Pose, Rims, ShadingNormals};
use relume_formats::state::Posed;
use relume_formats::{Error, Place, Result};
use std::collections::BTreeMap;
use std::ops::Range;

/// Sphere sets, by the name of their object.
pub(super) type Sets = BTreeMap<String, SphereSet>;
/// Meshes that deform, by the name of their object.
pub(super) type Shapes = BTreeMap<String, DeformingMesh>;

/// The vertices of a scene, what blocks their view, and what moves them.
pub(super) struct Receivers {
    now: Vec<Receiver>,
    /// Of the vertices whose light they receive, metres in world space.
    positions: Vec<[f32; 3]>,
    rims: Rims,
    /// Whether `now` and `positions` are to follow the poses.
    on_cpu: bool,
    meshes: CasterMeshes,
    casters: Casters,
    moving: Vec<Moving>,
}

/// An object that deforms.
pub(super) struct Moving {
    name: String,
    /// Its vertices among those of the scene.
    pub(super) vertices: Range<usize>,
    pub(super) mesh: DeformingMesh,
    pub(super) normals: ShadingNormals,
    /// Number of its set among those that cast, if it is there, and what its spheres follow.
    follower: Option<(usize, Follower)>,
    /// What it shows; `None` before the first pose.
    shown: Option<Option<Posed>>,
    /// Positions and normals, kept for their memory.
    scratch: [Vec<[f32; 3]>; 2],
}

impl Moving {
    /// One that no spheres follow, before its first pose.
    pub(super) fn new(
        name: String,
        vertices: Range<usize>,
        mesh: DeformingMesh,
        normals: ShadingNormals,
    ) -> Self {
        Self { name, vertices, mesh, normals, follower: None, shown: None, scratch: Default::default() }
    }
}

impl Receivers {
    /// Those of `scene` as the main file `bake` at `place` has them, at rest; all that is there is known to
    /// fit the scene. `on_cpu` says whether the CPU brings vertices and normals to their pose.
    ///
    /// # Errors
    /// If a shape is missing.
    pub(super) fn new(
        scene: &StoredScene,
        bake: &SphereShadows,
        mut sets: Sets,
        mut shapes: Shapes,
        on_cpu: bool,
        place: &Place,
    ) -> Result<Self> {
        let meshes = CasterMeshes::new(bake, &scene.positions);
        let mut found = Self {
            now: Vec::new(),
            positions: scene.positions.clone(),
            rims: Rims::new(scene.positions.len(), &scene.triangles),
            on_cpu,
            meshes,
            casters: Casters::default(),
            moving: Vec::new(),
        };
        let (mut own_sets, mut end) = (Vec::new(), 0);
        for (object, stored) in bake.meta.objects.iter().zip(&scene.meta.objects) {
            // A bundle has the spheres of what casts by its mesh too.
            let set = sets.remove(&object.name).filter(|_| object.casts == Casts::Spheres);
            found.casters.spheres.extend(
                set.as_ref()
                    .map(|set| Spheres { now: set.spheres.clone(), neighbours: neighbours(&set.spheres) }),
            );
            let triangles = end..end + stored.triangles as usize;
            end = triangles.end;
            if object.deforms {
                let Some(mesh) = shapes.remove(&object.name) else {
                    let reason = format!(
                        "needs the shape of object `{}` before it; bake the whole bundle again",
                        object.name
                    );
                    return Err(Error::invalid(place, reason));
                };
                found.add_moving(scene, object, triangles, mesh, set.as_ref());
            }
            own_sets.extend(set);
        }
        found.now = receivers(bake, &own_sets, &found.rims.received(&scene.positions), &scene.normals);
        Ok(found)
    }

    fn add_moving(
        &mut self,
        scene: &StoredScene,
        object: &ShadowObject,
        triangles: Range<usize>,
        mesh: DeformingMesh,
        set: Option<&SphereSet>,
    ) {
        let vertices = range(object);
        // What is not of the object wraps around to what no object has.
        let local = |triangle: &[u32; 3]| triangle.map(|vertex| vertex.wrapping_sub(object.first_vertex));
        let triangles: Vec<[u32; 3]> = scene.triangles[triangles].iter().map(local).collect();
        let (positions, normals) = (&scene.positions[vertices.clone()], &scene.normals[vertices.clone()]);
        let normals = ShadingNormals::new(positions, normals, &triangles);
        let follower = set.map(|set| (self.casters.spheres.len() - 1, Follower::new(set)));
        self.moving.push(Moving { follower, ..Moving::new(object.name.clone(), vertices, mesh, normals) });
    }

    /// Brings everything to what `shapes` show. Returns which shapes moved, by number, and their poses.
    ///
    /// # Errors
    /// If a mesh would reach beyond what numbers hold.
    pub(super) fn pose(&mut self, shapes: &BTreeMap<String, Posed>) -> Result<Vec<(usize, Pose)>> {
        let mut moved = Vec::new();
        for (number, moving) in self.moving.iter_mut().enumerate() {
            let shows = shapes.get(&moving.name);
            if moving.shown.as_ref().is_some_and(|shown| shown.as_ref() == shows) {
                continue;
            }
            let pose = moving.mesh.pose_of(shows);
            let [positions, normals] = &mut moving.scratch;
            if self.on_cpu || moving.follower.is_some() {
                moving.mesh.positions(&pose, positions);
            }
            if let Some((set, follower)) = &moving.follower {
                follower.follow(positions, &mut self.casters.spheres[*set].now)?;
            }
            if self.on_cpu {
                moving.normals.at(positions, normals);
                let all = self.positions.iter_mut().zip(&mut self.now).skip(moving.vertices.start);
                for ((place, receiver), (position, normal)) in all.zip(positions.iter().zip(normals)) {
                    *place = *position;
                    (receiver.normal, receiver.lobes) = ((*normal).into(), blend((*normal).into()));
                }
            }
            moving.shown = Some(shows.cloned());
            moved.push((number, pose));
        }
        if self.on_cpu && !moved.is_empty() {
            for (receiver, place) in self.now.iter_mut().zip(self.rims.received(&self.positions)) {
                receiver.position = place.into();
            }
        }
        Ok(moved)
    }

    /// All of them, in the order of the scene's vertices: where they are now if the CPU brings them there, else
    /// at rest.
    pub(super) fn now(&self) -> &[Receiver] {
        &self.now
    }

    /// Of the vertices whose light they receive, likewise.
    pub(super) fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Which of them receive it beside their vertices.
    pub(super) fn rims(&self) -> &Rims {
        &self.rims
    }

    /// The objects that deform.
    pub(super) fn moving(&self) -> &[Moving] {
        &self.moving
    }

    /// Where all vertices are now, metres in world space, if there are objects that deform.
    pub(super) fn moving_positions(&self) -> Option<Vec<[f32; 3]>> {
        if self.moving.is_empty() {
            return None;
        }
        let mut all = self.positions.clone();
        let mut posed = Vec::new();
        for Moving { vertices, mesh, shown, .. } in &self.moving {
            mesh.positions(&mesh.pose_of(shown.as_ref().and_then(Option::as_ref)), &mut posed);
            all.iter_mut().skip(vertices.start).zip(&posed).for_each(|(position, now)| *position = *now);
        }
        Some(all)
    }

    /// The spheres of the objects that cast by them.
    pub(super) fn spheres(&self) -> &[Spheres] {
        &self.casters.spheres
    }

    /// The triangles that cast shadows.
    pub(super) fn casters(&self) -> &[CasterTriangle] {
        self.meshes.triangles()
    }

    /// All that casts shadows, where it is now.
    #[cfg(feature = "cpu")]
    pub(super) fn placed(&mut self) -> &Casters {
        let normals: Vec<[f32; 3]> = self.now.iter().map(|receiver| receiver.normal.to_array()).collect();
        self.meshes.place(&self.positions, &normals, &mut self.casters.triangles);
        &self.casters
    }
}

fn range(object: &ShadowObject) -> Range<usize> {
    object.first_vertex as usize..(object.first_vertex + object.vertices) as usize
}
