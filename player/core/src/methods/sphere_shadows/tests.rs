//! The GPU, and the fast CPU path, against the meaning.

use super::*;
use crate::Error;
use crate::support::shadows::{Bundle, cast_by_meshes};
use crate::testing::{arrivals, gpu, playlist, read_radiance, read_values};
use relume_formats::basis::suns::split;
use relume_formats::evaluate::sparse_transfer;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::sphere_shadows::{
    CasterMeshes, Casters, Levels, Receiver, Spheres, light, neighbours, radiance, receivers,
};
use relume_formats::kinds::HaarTable;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::sphere_shadows::Casts;
use relume_formats::shape::{Rims, ShadingNormals};
use relume_formats::state::Posed;
use std::ops::Range;
use std::sync::LazyLock;

mod poses;

static TABLE: LazyLock<HaarTable> = LazyLock::new(HaarTable::bake);

/// Two devices: one computes on the GPU, one on the CPU, if that is built in.
fn gpus() -> Option<[Gpu; 2]> {
    let (one, mut other) = (gpu()?, gpu()?);
    other.radiance_on_cpu = METHOD.on_cpu;
    Some([one, other])
}

fn load(gpu: &Gpu, bundle: &Bundle) -> Result<SphereShadows> {
    let setup =
        Setup { scene: bundle.scene.clone(), settings: playlist(bundle.folder(), None).settings, size: None };
    let mut method = SphereShadows::new(gpu, setup)?;
    arrivals(bundle.folder()).into_iter().try_for_each(|arrival| method.section_arrived(gpu, arrival))?;
    Ok(method)
}

fn look(bundle: &Bundle, map: &str, rotation_deg: f32, gain: Rgb, pose: Option<(&str, f32)>) -> Look {
    let mut look = Look::default_of(&bundle.scene.meta);
    look.environment = Some(EnvironmentLook { map: map.to_owned(), gain, rotation_deg });
    look.shapes
        .extend(pose.map(|(clip, time_s)| ("worm".to_owned(), Posed { clip: clip.to_owned(), time_s })));
    look
}

fn draw(gpu: &Gpu, method: &mut SphereShadows, look: &Look) -> Vec<Rgb> {
    method.update(gpu, look).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut passes = Passes::new(&mut encoder, None, 0);
    method.encode(&mut passes);
    passes.finish();
    gpu.queue.submit([encoder.finish()]);
    let (buffer, gain) = method.vertex_radiance().unwrap();
    read_radiance(gpu, [buffer]).into_iter().map(|rgb| std::array::from_fn(|k| rgb[k] * gain[k])).collect()
}

/// Positions and normals of all vertices.
type Vertices = [Vec<[f32; 3]>; 2];

/// Where `look` has the vertices.
fn posed(bundle: &Bundle, look: &Look) -> Vertices {
    let [mut positions, mut normals] = [&bundle.scene.positions, &bundle.scene.normals].map(Vec::clone);
    let triangles =
        bundle.scene.triangles.iter().filter(|t| t[0] >= 96).map(|t| t.map(|v| v - 96)).collect::<Vec<_>>();
    let shading = ShadingNormals::new(&positions[96..], &normals[96..], &triangles);
    let (mut posed, mut turned) = (Vec::new(), Vec::new());
    bundle.shape.positions(&bundle.shape.pose_of(look.shapes.get("worm")), &mut posed);
    shading.at(&posed, &mut turned);
    positions.splice(96.., posed);
    normals.splice(96.., turned);
    [positions, normals]
}

/// Where they are drawn.
fn drawn(gpu: &Gpu, method: &SphereShadows) -> Vertices {
    let picture = &method.stage.as_ref().unwrap().picture;
    [picture.positions(), picture.normals()].map(|buffer| read_values(gpu, buffer))
}

/// The scene as `look` has it, put together anew with its vertices where they are drawn.
fn placed(bundle: &Bundle, look: &Look, [positions, normals]: &Vertices) -> (Vec<Receiver>, Casters) {
    let casting = bundle.bake.meta.objects.iter().filter(|object| object.casts == Casts::Spheres);
    let sets = casting.filter_map(|object| bundle.sets.get_key_value(&object.name));
    let spheres = sets.clone().map(|(name, set)| {
        let mut now = set.spheres.clone();
        if name == "worm" {
            Follower::new(set).follow(&posed(bundle, look)[0][96..], &mut now).unwrap();
        }
        Spheres { now, neighbours: neighbours(&set.spheres) }
    });
    let mut casters = Casters { spheres: spheres.collect(), triangles: Vec::new() };
    let meshes = CasterMeshes::new(&bundle.bake, &bundle.scene.positions);
    meshes.place(positions, normals, &mut casters.triangles);
    let own_sets: Vec<_> = sets.map(|(_, set)| set.clone()).collect();
    let places = Rims::new(positions.len(), &bundle.scene.triangles).received(positions);
    (receivers(&bundle.bake, &own_sets, &places, normals), casters)
}

fn look_at_noise(bundle: &Bundle) -> Look {
    look(bundle, "noise", 0.0, [1.0; 3], None)
}

/// What should come out, and what would without casters.
fn expected(bundle: &Bundle, look: &Look, vertices: &Vertices, detail: Detail) -> [Vec<Rgb>; 2] {
    let environment = look.environment.as_ref().unwrap();
    let map = &bundle.maps.iter().find(|map| map.name == environment.map).unwrap().map;
    let light = light(sparse_transfer::light(&split(map).rest, environment, SIDE), detail.terms);
    let lobes: Vec<_> = (0..bundle.bake.normals.len())
        .map(|row| lobe(bundle.bake.lobe(row).to_vec(), detail.terms))
        .collect();
    let (receivers, casters) = placed(bundle, look, vertices);
    [casters, Casters::default()]
        .map(|casters| radiance(&receivers, &casters, &lobes, &light, detail.levels, &TABLE))
}

/// Largest difference in parts of the largest radiance without spheres.
#[track_caller]
fn expect_near(ours: &[Rgb], [theirs, open]: &[Vec<Rgb>; 2], bound: f32, what: &str) {
    let largest = open.iter().flatten().fold(0.0f32, |m, v| m.max(v.abs()));
    assert_eq!(ours.len(), theirs.len());
    let off =
        ours.iter().flatten().zip(theirs.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0f32, f32::max);
    println!("{what}: {}", off / largest);
    assert!(
        off <= bound * largest && ours.iter().flatten().all(|v| v.is_finite()),
        "{what}: {off} of {largest}"
    );
}

/// Cube and Haar coefficients are within 1e-5 of the CPU's, and the largest radiance is made of a few of
/// them.
const BOUND: f32 = 2e-5;

#[test]
fn radiance_equals_the_meaning_at_every_setting() {
    let Some(gpus) = gpus() else { return };
    for (terms, second_level) in
        [50, 100, 200].into_iter().flat_map(|terms| [false, true].map(|second_level| (terms, second_level)))
    {
        let bundle = Bundle::with(
            |bake| {
                (bake.meta.terms, bake.meta.second_level) = (terms, second_level);
                if second_level {
                    cast_by_meshes(bake);
                }
            },
            true,
        );
        let detail = Detail::of(&bundle.bake.meta);
        for gpu in &gpus {
            let mut method = load(gpu, &bundle).unwrap();
            for (map, rotation_deg, gain, pose) in [
                ("noise", 0.0, [1.0; 3], None),
                ("noise", 33.0, [0.5, 2.0, 0.0], Some(("Turn", 0.7))),
                ("sun", 100.0, [1.0; 3], Some(("Swell", 0.8))),
                ("even", 10.0, [3.0; 3], Some(("Turn", 0.2))),
            ] {
                let look = look(&bundle, map, rotation_deg, gain, pose);
                let ours = draw(gpu, &mut method, &look);
                let what = format!("{} {detail:?} {map} {pose:?}", gpu.name);
                let vertices = drawn(gpu, &method);
                assert!(!gpu.radiance_on_cpu || vertices == posed(&bundle, &look));
                expect_near(&ours, &expected(&bundle, &look, &vertices, detail), BOUND, &what);
            }
        }
    }
}

#[test]
fn spheres_cast_shadows_and_others_hold_receivers() {
    let Some(gpus) = gpus() else { return };
    let bundle = Bundle::write(true);
    // The worm is put into the ball's spheres.
    let look = look(&bundle, "even", 0.0, [1.0; 3], Some(("Turn", 0.999)));
    let (receivers, casters) = placed(&bundle, &look, &posed(&bundle, &look));
    let sets = &casters.spheres;
    let holds = |r: &Receiver| {
        sets[0].now.iter().any(|[x, y, z, radius]| r.position.distance([*x, *y, *z].into()) < *radius)
    };
    let held: Vec<usize> = (96..150).filter(|v| holds(&receivers[*v])).collect();
    let fine = Detail::of(&bundle.bake.meta);
    let of = |look: &Look, detail| expected(&bundle, look, &posed(&bundle, look), detail);
    let [theirs, open] = of(&look, fine);
    let coarse = of(&look_at_noise(&bundle), Detail { levels: Levels::One, ..fine });
    let fine = of(&look_at_noise(&bundle), fine);
    let differs = coarse[0].iter().zip(&fine[0]).any(|(a, b)| (a[0] - b[0]).abs() > 1e-3 * b[0]);
    assert!(differs, "the second level counts somewhere");
    let shaded = theirs.iter().zip(&open).take(42).filter(|(a, b)| a[1] < 0.95 * b[1]).count();
    assert!(!held.is_empty() && shaded > 5, "{} held, {shaded} shaded", held.len());
    for gpu in &gpus {
        let ours = draw(gpu, &mut load(gpu, &bundle).unwrap(), &look);
        let facing = |v: &&usize| {
            sets[0].now.iter().any(|[x, y, z, radius]| {
                let offset = glam::Vec3::new(*x, *y, *z) - receivers[**v].position;
                offset.length() < 0.99 * radius && receivers[**v].normal.dot(offset) > -radius
            })
        };
        assert!(
            held.iter().filter(facing).all(|v| ours[*v].iter().all(|c| c.abs() < 1e-5)),
            "all is blocked inside"
        );
    }
}

#[test]
fn meshes_cast_shadows_and_the_ground_darkens_what_is_above_it() {
    let Some(gpus) = gpus() else { return };
    let bundle = Bundle::with(cast_by_meshes, true);
    let look = look(&bundle, "even", 0.0, [1.0; 3], Some(("Turn", 0.3)));
    let detail = Detail::of(&bundle.bake.meta);
    let [theirs, open] = expected(&bundle, &look, &posed(&bundle, &look), detail);
    let darker =
        |range: Range<usize>, share: f32| range.filter(|v| theirs[*v][1] < share * open[*v][1]).count();
    assert!(darker(0..42, 0.97) > 5, "the floor under the worm");
    assert!(darker(42..96, 0.8) > 10, "the ball, whose underside sees the floor");
    for gpu in &gpus {
        let mut method = load(gpu, &bundle).unwrap();
        let ours = draw(gpu, &mut method, &look);
        expect_near(&ours, &expected(&bundle, &look, &drawn(gpu, &method), detail), BOUND, &gpu.name);
    }
}

#[test]
fn without_spheres_there_is_no_shadow() {
    let Some(gpus) = gpus() else { return };
    let bundle = Bundle::write(false);
    for gpu in &gpus {
        let mut method = load(gpu, &bundle).unwrap();
        let look = look(&bundle, "sun", 40.0, [1.0; 3], Some(("Turn", 0.5)));
        let ours = draw(gpu, &mut method, &look);
        let expected = expected(&bundle, &look, &drawn(gpu, &method), Detail::of(&bundle.bake.meta));
        assert_eq!(expected[0], expected[1]);
        expect_near(&ours, &expected, BOUND, &gpu.name);
    }
}

#[test]
fn batches_give_the_identical_sum() {
    let Some([mut gpu, _]) = gpus() else { return };
    let bundle = Bundle::with(cast_by_meshes, true);
    let look = look(&bundle, "noise", 20.0, [1.0; 3], Some(("Swell", 0.4)));
    let whole = draw(&gpu, &mut load(&gpu, &bundle).unwrap(), &look);
    (gpu.binding_bytes, gpu.workgroups_per_dimension) = (768 * 70, 30);
    assert_eq!(draw(&gpu, &mut load(&gpu, &bundle).unwrap(), &look), whole, "batches of 70, 70 and 10");
    gpu.binding_bytes = 16;
    let refused = load(&gpu, &bundle).err().unwrap();
    assert!(
        refused.to_string().contains("bake with fewer spheres") && matches!(refused, Error::Format(_)),
        "{refused}"
    );
}

#[test]
fn no_more_is_computed_than_has_changed() {
    let Some([gpu, _]) = gpus() else { return };
    let bundle = Bundle::write(true);
    let mut method = load(&gpu, &bundle).unwrap();
    let mut changes = |look: &Look| {
        method.update(&gpu, look).unwrap();
        let Changed { light, terms, shapes } = method.stage.as_ref().unwrap().changed;
        draw(&gpu, &mut method, look);
        [light, terms, shapes]
    };
    let first = look(&bundle, "noise", 0.0, [1.0; 3], None);
    assert_eq!(changes(&first), [true; 3]);
    assert_eq!(changes(&first), [false; 3]);
    let mut elsewhere = first.clone();
    elsewhere.camera.position[0] += 1.0;
    assert_eq!(changes(&elsewhere), [false; 3]);
    assert_eq!(
        changes(&look(&bundle, "noise", 0.0, [1.0, 2.0, 1.0], None)),
        [false, true, false],
        "the gain decides what is kept"
    );
    assert_eq!(changes(&look(&bundle, "noise", 5.0, [1.0, 2.0, 1.0], None)), [true, true, false]);
    assert_eq!(
        changes(&look(&bundle, "noise", 5.0, [1.0, 2.0, 1.0], Some(("Turn", 0.1)))),
        [false, false, true]
    );
    assert_eq!(changes(&look(&bundle, "noise", 5.0, [1.0, 2.0, 1.0], Some(("Turn", 0.1)))), [false; 3]);
    assert_eq!(
        changes(&look(&bundle, "noise", 5.0, [1.0, 2.0, 1.0], None)),
        [false, false, true],
        "back at rest"
    );
    method.resize(&gpu, [31, 7]).unwrap();
    method.update(&gpu, &look(&bundle, "noise", 5.0, [1.0, 2.0, 1.0], None)).unwrap();
    let Changed { light, terms, shapes } = method.stage.as_ref().unwrap().changed;
    assert_eq!([light, terms, shapes], [false; 3], "another size");
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let Some([gpu, _]) = gpus() else { return };
    let refusal = |change: fn(&mut Bake)| {
        let error = load(&gpu, &Bundle::with(change, true)).err().unwrap();
        assert!(matches!(&error, Error::Format(error) if error.is_bad_input()), "{error}");
        error.to_string()
    };
    for (message, part) in [
        (
            refusal(|bake| bake.meta.objects[1].name = "box".to_owned()),
            "its objects are not those of the scene, in their order",
        ),
        (
            refusal(|bake| bake.meta.objects[0].sphere_set = true),
            "object `grid` has a sphere set here or in the manifest, but not in both",
        ),
        (
            refusal(|bake| bake.meta.objects[2].deforms = false),
            "object `worm` deforms here or in the scene, but not in both",
        ),
        (
            refusal(|bake| {
                bake.meta.objects[1].vertices -= 1;
                bake.meta.objects[2].first_vertex -= 1;
                bake.meta.objects[2].vertices += 1;
            }),
            "object `ball` has other vertices than in the scene",
        ),
        (
            refusal(|bake| {
                bake.meta.objects[2].vertices += 1;
                bake.rows.push(u32::MAX);
            }),
            "has lobes for 151 vertices of a scene of 150",
        ),
    ] {
        assert!(message.contains(part), "{message}");
    }
}
