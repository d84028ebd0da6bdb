//! Collects parts in world space and cleans them: finite positions, legal indices, no degenerate triangles, a
//! unit normal per vertex.

use super::MAX_ELEMENTS;
use super::normals::{self, DEFAULT_CREASE_DEG, Smoothing};
use crate::scene::Mesh;
use crate::transform::{is_mirroring, normal_map};
use glam::{DAffine3, DVec3, Vec3};
use relume_formats::counts::counted;
use relume_formats::state::MAX_COORDINATE;
use relume_formats::{Error, Place, Result};

/// Geometry in a space of its own, not yet checked.
#[derive(Default)]
pub(crate) struct Part {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// One per vertex, of any length; zero where there is none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one per vertex, or none at all.
    pub uvs: Vec<[f32; 2]>,
    /// How many of `uvs` only fill a gap.
    pub without_uv: usize,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// How each triangle is shaded where it has no normals; one per triangle, or none: then all are by angle.
    pub smoothing: Vec<Smoothing>,
}

/// See the module.
#[derive(Default)]
pub(crate) struct MeshBuilder {
    mesh: Mesh,
    /// One per triangle.
    smoothing: Vec<Smoothing>,
    /// See [`MeshBuilder::with_crease`].
    crease_deg: Option<f64>,
    /// Vertices appended without texture coordinates.
    vertices_without_uv: usize,
    /// Texture coordinates that were no finite numbers.
    broken_uvs: usize,
    /// What the readers noticed, one line each.
    pub notes: Vec<String>,
}

impl MeshBuilder {
    /// For faces without normals, those that meet at less than `crease_deg` degrees are smooth, whatever the
    /// file says; none leaves it to the file.
    pub fn with_crease(crease_deg: Option<f64>) -> Self {
        Self { crease_deg, ..Self::default() }
    }

    /// True if the file says how faces without normals are shaded.
    pub fn leaves_shading_to_file(&self) -> bool {
        self.crease_deg.is_none()
    }

    /// Fails, before anything is allocated, if so many more vertices and triangles would be too many.
    pub fn expect_room(&self, vertices: usize, triangles: usize, place: &Place) -> Result<()> {
        let total = |have: usize, more: usize| have.saturating_add(more);
        if total(self.mesh.positions.len(), vertices).max(total(self.mesh.triangles.len(), triangles))
            > MAX_ELEMENTS
        {
            return Err(Error::invalid(
                place,
                format!("more than {MAX_ELEMENTS} vertices or triangles in one object; split or simplify it"),
            ));
        }
        Ok(())
    }

    /// True if nothing was added yet.
    pub fn is_empty(&self) -> bool {
        self.mesh.positions.is_empty()
    }

    /// True if any vertex has texture coordinates.
    pub fn has_uvs(&self) -> bool {
        !self.mesh.uvs.is_empty()
    }

    /// True if any triangle has an area, so that [`MeshBuilder::finish`] has something to give.
    pub fn has_area(&self) -> bool {
        self.mesh
            .triangles
            .iter()
            .any(|triangle| !is_degenerate(triangle.map(|v| self.mesh.positions[v as usize])))
    }

    /// Adds `part`; fronts stay fronts even if `world_from_part` mirrors. `place` names the part in messages.
    pub fn append(&mut self, part: &Part, world_from_part: &DAffine3, place: &Place) -> Result<()> {
        self.expect_room(part.positions.len(), part.triangles.len(), place)?;
        let offset = self.mesh.positions.len() as u32;
        let world = |position: &[f32; 3]| {
            world_from_part.transform_point3(Vec3::from(*position).as_dvec3()).as_vec3()
        };
        // Adding 0 turns −0 into +0, so that equal positions have equal bits.
        self.mesh.positions.extend(part.positions.iter().map(|position| (world(position) + 0.0).to_array()));
        self.expect_finite(part, offset, place)?;
        let world_from_normal = normal_map(world_from_part);
        let world_normal = |n: &[f32; 3]| unit_or_zero(world_from_normal * Vec3::from(*n).as_dvec3());
        self.mesh.normals.extend(part.normals.iter().map(world_normal));
        self.mesh.normals.resize(self.mesh.positions.len(), [0.0; 3]);
        self.append_uvs(part);
        let flip = is_mirroring(world_from_part);
        for (index, triangle) in part.triangles.iter().enumerate() {
            if let Some(vertex) = triangle.iter().find(|v| **v as usize >= part.positions.len()) {
                let reason = format!(
                    "triangle {index} names vertex {vertex} of {}; mend the mesh",
                    part.positions.len()
                );
                return Err(Error::invalid(place, reason));
            }
            let [a, b, c] = triangle.map(|v| v + offset);
            self.mesh.triangles.push(if flip { [a, c, b] } else { [a, b, c] });
        }
        self.smoothing.extend_from_slice(&part.smoothing);
        self.smoothing.resize(self.mesh.triangles.len(), Smoothing::ByAngle);
        Ok(())
    }

    /// Refuses triangles with corners at no finite place, or where no bundle holds them. Scanners write
    /// vertices that no triangle uses so.
    fn expect_finite(&self, part: &Part, offset: u32, place: &Place) -> Result<()> {
        let is_stray = |vertex: &&u32| {
            let index = offset as usize + **vertex as usize;
            self.mesh.positions.get(index).is_some_and(|p| !p.iter().all(|x| x.abs() <= MAX_COORDINATE))
        };
        match part
            .triangles
            .as_flattened()
            .iter()
            .find(is_stray)
            .and_then(|vertex| Some((vertex, part.positions.get(*vertex as usize)?)))
        {
            Some((index, at)) if at.iter().all(|x| x.is_finite()) => {
                let reason = format!(
                    "vertex {index} at {at:?} comes to lie farther from the origin than {MAX_COORDINATE:e} m; lower its"
                );
                Err(Error::invalid(place, format!("{reason} scale or translation, or mend the mesh")))
            }
            Some((index, at)) => Err(Error::invalid(
                place,
                format!("vertex {index} at {at:?} is not a finite position; mend the mesh"),
            )),
            None => Ok(()),
        }
    }

    /// One pair per vertex as soon as any part has some. They place a texture and nothing else, so that
    /// broken ones are mended, not refused.
    fn append_uvs(&mut self, part: &Part) {
        self.vertices_without_uv += part.positions.len().saturating_sub(part.uvs.len()) + part.without_uv;
        if part.uvs.is_empty() && self.mesh.uvs.is_empty() {
            return;
        }
        let vertices = self.mesh.positions.len();
        self.mesh.uvs.resize(vertices - part.positions.len(), [0.0; 2]);
        for uv in part.uvs.iter().take(part.positions.len()) {
            let finite = uv.iter().all(|x| x.is_finite());
            self.broken_uvs += usize::from(!finite);
            self.mesh.uvs.push(if finite { *uv } else { [0.0; 2] });
        }
        self.mesh.uvs.resize(vertices, [0.0; 2]);
    }

    /// The clean mesh. Adds what was mended to `warnings`.
    pub fn finish(self, place: &Place, warnings: &mut Vec<String>) -> Result<Mesh> {
        Ok(self.finish_and_tell(place, warnings)?.0)
    }

    /// The clean mesh, and for every vertex of it which of those appended it is. Adds what was mended to
    /// `warnings`.
    pub fn finish_and_tell(mut self, place: &Place, warnings: &mut Vec<String>) -> Result<(Mesh, Vec<u32>)> {
        self.note_mended_uvs();
        let Self { mut mesh, mut smoothing, notes, crease_deg, .. } = self;
        let given = mesh.triangles.len();
        if given == 0 {
            let why = if notes.is_empty() { String::new() } else { format!(": {}", notes.join(", ")) };
            return Err(Error::invalid(place, format!("has no faces{why}; export it as a mesh")));
        }
        warnings.extend(notes.into_iter().map(|note| format!("{place}: {note}")));
        let kept: Vec<bool> =
            mesh.triangles.iter().map(|t| !is_degenerate(t.map(|v| mesh.positions[v as usize]))).collect();
        keep_used(&mut mesh.triangles, &kept);
        keep_used(&mut smoothing, &kept);
        let dropped = given - mesh.triangles.len();
        if mesh.triangles.is_empty() {
            return Err(Error::invalid(
                place,
                format!("no usable triangle ({dropped} degenerate); check the mesh and its scale"),
            ));
        }
        if dropped > 0 {
            warnings.push(format!(
                "{place}: dropped {dropped} degenerate of {} (zero area)",
                counted(given, "triangle", "triangles")
            ));
        }
        let mut origins = drop_unused_vertices(&mut mesh);
        let filled = normals::fill_missing(&mut mesh, &smoothing, crease_deg);
        origins.extend(filled.copied.iter().map(|vertex| origins[*vertex as usize]).collect::<Vec<_>>());
        if mesh.positions.len() > MAX_ELEMENTS {
            return Err(Error::invalid(
                place,
                format!("more than {MAX_ELEMENTS} vertices where edges are hard; split or simplify it"),
            ));
        }
        if filled.by_angle > 0 {
            let (made, parted, crease) =
                (filled.by_angle, filled.copied.len(), crease_deg.unwrap_or(DEFAULT_CREASE_DEG));
            let vertices = mesh.positions.len() - parted;
            let now = if parted > 0 {
                format!(", {} now as hard edges part them", mesh.positions.len())
            } else {
                String::new()
            };
            warnings.push(format!(
                "{place}: made normals for {made} of {}{now}, as none or zero were there: smooth where faces meet at less than {crease} degrees \
                 (`crease_deg`)",
                counted(vertices, "vertex", "vertices")
            ));
        } else if crease_deg.is_some() {
            warnings.push(format!(
                "{place}: has normals of its own everywhere, which `crease_deg` leaves as they are"
            ));
        }
        Ok((mesh, origins))
    }

    fn note_mended_uvs(&mut self) {
        let (vertices, without, broken) = (
            counted(self.mesh.positions.len(), "vertex", "vertices"),
            self.vertices_without_uv,
            self.broken_uvs,
        );
        if !self.mesh.uvs.is_empty() && without > 0 {
            self.notes.push(format!(
                "gave the texture coordinates (0, 0) to {without} of {vertices}, which had none"
            ));
        }
        if broken > 0 {
            self.notes.push(format!("gave the texture coordinates (0, 0) to {broken} of {vertices} in place of what was not finite"));
        }
    }
}

/// The unit vector along `v`, or zero if it has no direction.
pub(super) fn unit_or_zero(v: DVec3) -> [f32; 3] {
    v.try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array()
}

/// Twice the area of a triangle times its unit normal.
pub(super) fn area_vector(corners: [[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a)
}

/// True if a triangle has no area as far as single precision can tell.
fn is_degenerate(corners: [[f32; 3]; 3]) -> bool {
    // Below a square nanometre the tracer's single precision underflows.
    is_sliver(corners) || area_vector(corners).length() <= 1e-18
}

/// True if the corners lie on a line: a height of less than 1e-7 of the longest side is the rounding error of
/// the corners, and gives no normal.
pub(super) fn is_sliver(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    let longest_squared =
        (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    area_vector(corners).length() <= 1e-7 * longest_squared
}

/// Returns which vertices were used.
fn drop_unused_vertices(mesh: &mut Mesh) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|v| used[*v as usize] = true);
    let kept_before =
        used.iter().scan(0, |kept, used| Some(std::mem::replace(kept, *kept + u32::from(*used))));
    let new_index: Vec<u32> = kept_before.collect();
    keep_used(&mut mesh.positions, &used);
    keep_used(&mut mesh.normals, &used);
    keep_used(&mut mesh.uvs, &used);
    mesh.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = new_index[*v as usize]);
    (0..).zip(used).filter_map(|(vertex, used)| used.then_some(vertex)).collect()
}

fn keep_used<T>(values: &mut Vec<T>, used: &[bool]) {
    let mut used = used.iter();
    values.retain(|_| used.next().copied().unwrap_or(false));
}
