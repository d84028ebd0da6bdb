//! Poses on the GPU against those of the CPU, which works in double precision.

use super::super::gpu_data::Lobes;
use super::super::poses::Poses;
use super::super::receivers::Moving;
use super::*;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use relume_formats::basis::diffuse::blend;
use relume_formats::shape::{
    DeformingMesh, Influences, Joint, MorphTarget, Node, Pose, Surrounded, Transform,
};
use std::f64::consts::PI;

/// Half a step of a number of size 1 in single precision.
const U: f64 = 1.0 / (1 << 24) as f64;
const RINGS: u32 = 41;
/// The last lies where the first does, along a seam.
const SPOKES: u32 = 14;
const JOINTS: u32 = 9;
/// Vertices of the scene before and between shapes.
const OTHERS: usize = 5;

fn random(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
}

/// A tube of 2 m about +Y at `place` with a bulge, smooth normals and a seam, that follows a chain of joints, up to
/// four a vertex, and three morph targets that overlap.
fn tube(place: DVec3) -> (DeformingMesh, Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut state = 3;
    let at = |ring: u32, spoke: u32| {
        let h = f64::from(ring) / f64::from(RINGS - 1);
        let (sin, cos) = (2.0 * PI * f64::from(spoke % (SPOKES - 1)) / f64::from(SPOKES - 1)).sin_cos();
        let (radius, slope) = (0.2 + 0.15 * (7.0 * h).sin(), 0.15 * 7.0 * (7.0 * h).cos() / 2.0);
        let position = place + DVec3::new(radius * cos, 2.0 * h, radius * sin);
        (position.as_vec3().to_array(), DVec3::new(cos, -slope, sin).normalize().as_vec3().to_array())
    };
    let all = (0..RINGS * SPOKES).map(|k| at(k / SPOKES, k % SPOKES));
    let (positions, normals): (Vec<_>, Vec<_>) = all.unzip();
    let quad = |k: u32| [[k, k + SPOKES, k + 1], [k + 1, k + SPOKES, k + SPOKES + 1]];
    let triangles = (0..(RINGS - 1) * SPOKES).filter(|k| k % SPOKES < SPOKES - 1).flat_map(quad).collect();
    let influences = |k: u32| {
        let along = f64::from(k / SPOKES) / f64::from(RINGS - 1) * f64::from(JOINTS - 1);
        let mut near: Vec<u32> = (0..JOINTS).collect();
        near.sort_by(|a, b| (f64::from(*a) - along).abs().total_cmp(&(f64::from(*b) - along).abs()));
        let share = |joint: u32| (2.0 - (f64::from(joint) - along).abs()).max(0.0) as f32;
        let joints: [u32; 4] = std::array::from_fn(|i| near[i]);
        let sum: f32 = joints.iter().map(|joint| share(*joint)).sum();
        // The copies of the seam name them the other way around.
        let turn = |mut list: [_; 4]| {
            if k.is_multiple_of(SPOKES) {
                list
            } else {
                list.reverse();
                list
            }
        };
        let weights = joints.map(|joint| (joint, share(joint) / sum));
        let listed = turn(weights);
        Influences { joints: listed.map(|(joint, _)| joint), weights: listed.map(|(_, weight)| weight) }
    };
    let node = |joint: u32| {
        let step = if joint == 0 { place } else { DVec3::new(0.0, 2.0 / f64::from(JOINTS - 1), 0.0) };
        let (translation, rotation) = (step.as_vec3().to_array(), [0.0, 0.0, 0.0, 1.0]);
        Node {
            parent: joint.checked_sub(1),
            rest: Transform::Parts { translation, rotation, scale: [1.0; 3] },
        }
    };
    let nodes: Vec<Node> = (0..JOINTS).map(node).collect();
    let joint = |node: u32| {
        let height = 2.0 / f64::from(JOINTS - 1) * f64::from(node);
        Joint { node, node_from_mesh: DAffine3::from_translation(-place - DVec3::new(0.0, height, 0.0)) }
    };
    let morph = |k: u32| {
        let moves = |v: &u32| v / SPOKES >= 8 * k && v / SPOKES < 8 * k + 20;
        let vertices: Vec<u32> = (0..RINGS * SPOKES).filter(moves).collect();
        let mut deltas: Vec<[f32; 3]> =
            vertices.iter().map(|_| std::array::from_fn(|_| 0.02 * random(&mut state))).collect();
        for ring in deltas.chunks_exact_mut(SPOKES as usize) {
            ring[SPOKES as usize - 1] = ring[0];
        }
        MorphTarget { rest_weight: 0.0, vertices, deltas }
    };
    let mesh = DeformingMesh {
        influences: (0..RINGS * SPOKES).map(influences).collect(),
        joints: (0..JOINTS).map(joint).collect(),
        morph_targets: (0..3).map(morph).collect(),
        clips: Vec::new(),
        positions,
        nodes,
    };
    mesh.validate(&Place::file("tube")).unwrap();
    (mesh, normals, triangles)
}

/// Every joint turned about `axis` against the one before, and grown.
fn bent(mesh: &DeformingMesh, axis: DVec3, step_deg: f64, grow: f64, morph_weights: [f32; 3]) -> Pose {
    let mut world = DAffine3::IDENTITY;
    let turn = DQuat::from_axis_angle(axis.normalize(), step_deg.to_radians());
    let maps = mesh.nodes.iter().zip(&mesh.joints).map(|(node, joint)| {
        let own = DAffine3::from_scale_rotation_translation(DVec3::new(1.0, grow, 1.0), turn, DVec3::ZERO);
        world = world * node.rest.parent_from_node() * own;
        world * joint.node_from_mesh
    });
    Pose { world_from_mesh: maps.collect(), morph_weights: morph_weights.to_vec() }
}

/// All of it turned about `axis` through the origin.
fn turned(mesh: &DeformingMesh, axis: DVec3, angle_deg: f64) -> Pose {
    let turn = DAffine3::from_quat(DQuat::from_axis_angle(axis, angle_deg.to_radians()));
    Pose { world_from_mesh: vec![turn; mesh.joints.len()], morph_weights: vec![0.0; 3] }
}

/// What single precision may miss of the place of every vertex, along each axis: a rounding for each operation that
/// a number goes through, in parts of the sizes of what is added.
fn bounds(mesh: &DeformingMesh, pose: &Pose) -> Vec<[f64; 3]> {
    let size = |v: &[f32; 3]| v.map(|x| f64::from(x.abs()));
    let mut sizes: Vec<[f64; 3]> = mesh.positions.iter().map(size).collect();
    for (target, weight) in mesh.morph_targets.iter().zip(&pose.morph_weights) {
        for (vertex, delta) in target.vertices.iter().zip(&target.deltas) {
            let (sum, delta) = (&mut sizes[*vertex as usize], size(delta));
            (0..3).for_each(|k| sum[k] += f64::from(weight.abs()) * delta[k]);
        }
    }
    // Map to f32, times weight, four sums; times position, four sums; and to f32 on the CPU. Both morph: a product
    // and a sum for each target.
    let roundings = (1 + 1 + 4 + 1 + 4 + 1 + 2 * 2 * mesh.morph_targets.len()) as f64;
    let of = |(influences, size): (&Influences, &[f64; 3])| {
        std::array::from_fn(|row| {
            let along = |(joint, weight): (u32, f32)| {
                let map = &pose.world_from_mesh[joint as usize];
                let linear: f64 = (0..3).map(|c| map.matrix3.col(c)[row].abs() * size[c]).sum();
                f64::from(weight) * (linear + map.translation[row].abs())
            };
            roundings * U * influences.active().map(along).sum::<f64>()
        })
    };
    mesh.influences.iter().zip(&sizes).map(of).collect()
}

/// The same of its normal, given where the vertices are. The mean of triangles is known to some roundings in parts of
/// the products of their sides; what of the normal at rest is not along their mean turns as the half of both means
/// does, which is short where they oppose.
fn normal_bound(vertex: &Surrounded, triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> (f64, f64) {
    let at = |v: u32| Vec3::from(positions[v as usize]).as_dvec3();
    let own = &triangles[vertex.triangles.start as usize..vertex.triangles.end as usize];
    let sides = |[a, b, c]: &[u32; 3]| (at(*b) - at(*a), at(*c) - at(*a));
    let sum: DVec3 = own.iter().map(sides).map(|(b, c)| b.cross(c)).sum();
    let sizes: f64 = own.iter().map(sides).map(|(b, c)| b.length() * c.length()).sum();
    let of_mean = U * (20.0 + (10.0 + own.len() as f64) * sizes / sum.length());
    let [mean, normal] = [vertex.mean, vertex.normal].map(|v| Vec3::from(v).as_dvec3());
    let (half, aside) = ((mean + sum.normalize()).length(), normal.distance(mean));
    // Where both means oppose to roundings, either side may turn the normal around.
    let bound =
        if half > 3e-6 { (20.0 * U + of_mean) * (1.0 + 4.0 * aside / half) } else { 4e-6 + 2.1 * aside };
    (bound, half)
}

/// What is posed, and the buffers of its scene.
struct Scene {
    shapes: Vec<Moving>,
    normals: Vec<[f32; 3]>,
    buffers: [wgpu::Buffer; 3],
    poses: Poses,
}

fn scene(gpu: &Gpu) -> Scene {
    let (mut positions, mut normals) = (vec![[9.0; 3]; OTHERS], vec![[0.0; 3]; OTHERS]);
    let mut shapes = Vec::new();
    for place in [DVec3::new(0.3, -1.0, 0.1), DVec3::new(41.0, 3.0, -25.0)] {
        let (mesh, own, triangles) = tube(place);
        let shading = ShadingNormals::new(&mesh.positions, &own, &triangles);
        let vertices = positions.len()..positions.len() + own.len();
        positions.extend(&mesh.positions);
        normals.extend(own);
        shapes.push(Moving::new("tube".to_owned(), vertices, mesh, shading));
        positions.extend([[9.0; 3]; OTHERS]);
        normals.extend([[0.0; 3]; OTHERS]);
    }
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let buffer = |bytes: &[u8]| {
        let buffer = gpu.buffer("vertices", bytes.len() as u64, usage);
        gpu.write(&buffer, 0, bytes);
        buffer
    };
    let lobes = vec![0; positions.len() * size_of::<Lobes>()];
    let buffers = [bytemuck::cast_slice(&positions), bytemuck::cast_slice(&normals), &lobes].map(buffer);
    let poses = Poses::new(gpu, &shapes, buffers.each_ref(), &Place::file("main")).unwrap().unwrap();
    Scene { shapes, normals, buffers, poses }
}

impl Scene {
    fn pose(&self, gpu: &Gpu, poses: &[(usize, Pose)]) -> (Vertices, Vec<Lobes>) {
        poses.iter().for_each(|(shape, pose)| self.poses.set(gpu, *shape, pose));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut passes = Passes::new(&mut encoder, None, 0);
        self.poses.encode(&mut passes);
        passes.finish();
        gpu.queue.submit([encoder.finish()]);
        let [positions, normals, lobes] = &self.buffers;
        ([positions, normals].map(|buffer| read_values(gpu, buffer)), read_values(gpu, lobes))
    }
}

/// Largest share of what is allowed by which positions and normals differ, and the shortest half of means.
fn expect_posed(shape: &Moving, pose: &Pose, [positions, normals]: [&[[f32; 3]]; 2]) -> [f64; 3] {
    let (mut expected, mut turned) = (Vec::new(), Vec::new());
    shape.mesh.positions(pose, &mut expected);
    let [mut of_positions, mut of_normals, mut shortest] = [0.0f64, 0.0, 2.0];
    for ((ours, theirs), bound) in positions.iter().zip(&expected).zip(bounds(&shape.mesh, pose)) {
        for k in 0..3 {
            of_positions = of_positions.max((f64::from(ours[k]) - f64::from(theirs[k])).abs() / bound[k]);
        }
    }
    shape.normals.at(positions, &mut turned);
    let (surrounded, triangles) = shape.normals.by_vertex();
    for ((ours, theirs), vertex) in normals.iter().zip(&turned).zip(&surrounded) {
        let (bound, half) = normal_bound(vertex, &triangles, positions);
        let off = Vec3::from(*ours).as_dvec3().distance(Vec3::from(*theirs).as_dvec3());
        (of_normals, shortest) = (of_normals.max(off / bound), shortest.min(half));
    }
    [of_positions, of_normals, shortest]
}

fn expect_blended(normal: [f32; 3], lobes: &Lobes) {
    let weight = |list: &[(u32, f32)], row: u32| {
        list.iter().filter(|(other, _)| *other == row).map(|(_, weight)| weight).sum::<f32>()
    };
    let theirs = blend(normal.into());
    let ours: [(u32, f32); 4] = std::array::from_fn(|k| (lobes.rows[k], lobes.weights[k]));
    for (row, _) in theirs.iter().chain(&ours) {
        // Places on a face are known to some roundings, and a cell is a seventh of it.
        let off = (weight(&ours, *row) - weight(&theirs, *row)).abs();
        assert!(off < 4e-6, "{normal:?}: {ours:?} {theirs:?}");
    }
}

#[test]
fn skins_and_morphs_are_those_of_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    for workgroups in [65535, 3] {
        gpu.workgroups_per_dimension = workgroups;
        let scene = scene(&gpu);
        let mesh = |shape: usize| &scene.shapes[shape].mesh;
        let (y, across) = (DVec3::Y, DVec3::new(1.0, 0.2, -0.5));
        // The mean normals at one place turn right around.
        let mean = Vec3::from(scene.shapes[0].normals.by_vertex().0[200].mean).as_dvec3();
        let aside = mean.any_orthonormal_vector();
        let mut opposed = 0;
        for (name, poses) in [
            ("rest", vec![(0, mesh(0).rest_pose()), (1, mesh(1).rest_pose())]),
            ("walk", vec![(0, bent(mesh(0), across, 13.0, 0.95, [0.7, 0.0, -0.4]))]),
            ("twist", vec![(1, bent(mesh(1), y, 67.5, 1.0, [0.0; 3]))]),
            ("around", vec![(0, bent(mesh(0), across, 20.0, 1.0, [0.0; 3]))]),
            ("nearly opposite", vec![(0, turned(mesh(0), aside, 179.99))]),
            ("opposite", vec![(0, turned(mesh(0), aside, 180.0))]),
            (
                "both",
                vec![
                    (0, bent(mesh(0), y, -67.5, 1.1, [1.0, 1.0, 1.0])),
                    (1, bent(mesh(1), across, 29.0, 1.02, [0.1, -0.9, 0.3])),
                ],
            ),
        ] {
            let ([positions, normals], lobes) = scene.pose(&gpu, &poses);
            for (number, pose) in &poses {
                let range = scene.shapes[*number].vertices.clone();
                let own = [&positions[range.clone()], &normals[range.clone()]];
                let [of_positions, of_normals, shortest] = expect_posed(&scene.shapes[*number], pose, own);
                println!(
                    "{name} {number}: {of_positions:.3} {of_normals:.3} of what is allowed, {shortest:.1e}"
                );
                assert!(of_positions <= 1.0 && of_normals <= 1.0, "{name} {number}");
                opposed += usize::from(shortest < 1e-3);
                range.clone().for_each(|v| expect_blended(normals[v], &lobes[v]));
                // The seam stays closed, and has one normal.
                for ring in range.clone().step_by(SPOKES as usize) {
                    let last = ring + SPOKES as usize - 1;
                    assert_eq!((positions[ring], normals[ring]), (positions[last], normals[last]), "{name}");
                }
            }
            let is_other = |v: &usize| scene.shapes.iter().all(|shape| !shape.vertices.contains(v));
            for other in (0..positions.len()).filter(is_other) {
                assert_eq!((positions[other], normals[other]), ([9.0; 3], scene.normals[other]), "untouched");
            }
            assert_eq!(scene.pose(&gpu, &poses).0, [positions, normals], "frames repeat");
        }
        assert_eq!(opposed, 2, "normals that turn right around");
    }
}

#[test]
fn shapes_that_no_binding_holds_are_refused() {
    let Some(mut gpu) = gpu() else { return };
    let Scene { shapes, buffers, .. } = scene(&gpu);
    for (bytes, what) in [(1000, "morph targets"), (30_000, "vertices that deform"), (74_000, "triangles at")]
    {
        gpu.binding_bytes = bytes;
        let refused = Poses::new(&gpu, &shapes, buffers.each_ref(), &Place::file("main")).err().unwrap();
        assert!(refused.to_string().contains(&format!("bytes of {what}")), "{refused}");
    }
}
