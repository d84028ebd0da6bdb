//! The GPU against the CPU.

mod changes;
mod surface;

use super::*;
use crate::Error;
use crate::support::largest_difference;
use crate::support::tensors::{self, Bundle};
use crate::testing::{arrivals, gpu, playlist, read_radiance, read_values};
use glam::Vec3;
use relume_formats::evaluate::transfer_tensor::{Lights, widths};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::transfer_tensor::TransferTensor as Tensors;
use relume_formats::state::{BlinnPhong, Brdf, Camera, CookTorrance, Ggx};

/// The method, and the sections of its files after the first `pieces` pieces.
fn load(gpu: &Gpu, bundle: &Bundle, pieces: usize) -> (TransferTensor, Vec<Arrival>) {
    let setup =
        Setup { scene: bundle.scene.clone(), settings: playlist(bundle.folder(), None).settings, size: None };
    let (mut method, mut later) = (TransferTensor::new(gpu, setup).unwrap(), Vec::new());
    for arrival in arrivals(bundle.folder()) {
        if method.pieces().arrived() == pieces && method.maps.is_some() {
            later.push(arrival);
        } else {
            method.section_arrived(gpu, arrival).unwrap();
        }
    }
    (method, later)
}

fn load_all(gpu: &Gpu, bundle: &Bundle) -> TransferTensor {
    load(gpu, bundle, usize::MAX).0
}

fn environment(map: &str, rotation_deg: f32, gain: Rgb) -> EnvironmentLook {
    EnvironmentLook { map: map.to_owned(), gain, rotation_deg }
}

/// A state: what shines, materials a, b and c, where the eye is.
struct State {
    environment: EnvironmentLook,
    brdfs: [Brdf; 3],
    eye: [f32; 3],
}

fn defaults() -> [Brdf; 3] {
    let materials = tensors::materials();
    [0, 1, 2].map(|index| materials[index].brdf)
}

fn edited() -> [Brdf; 3] {
    [
        Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [0.1, 0.8, 1.0], shininess: 199.0 }),
        Brdf::Ggx(Ggx { base_color: [0.2, 0.9, 0.9], metallic: 0.0, roughness: 0.9 }),
        Brdf::CookTorrance(CookTorrance { kd: [0.5; 3], ks: [0.0, 0.5, 0.2], fresnel: 0.9, roughness: 0.11 }),
    ]
}

fn states() -> Vec<State> {
    let state = |environment, brdfs, eye| State { environment, brdfs, eye };
    vec![
        state(environment("noise", 0.0, [1.0; 3]), defaults(), [0.0, 0.0, 3.0]),
        state(environment("noise", 33.3, [0.5, 2.0, 0.0]), edited(), [2.0, 1.0, 0.3]),
        state(environment("sun", -90.0, [1.0; 3]), defaults(), [-0.3, -0.2, 0.4]),
        state(environment("sun", 180.0, [1e-3, 1.0, 7.0]), edited(), [0.0, 5.0, -1.0]),
        state(environment("even", 5.0, [1.0; 3]), defaults(), [1e3, -1e3, 2e3]),
        state(environment("black", 0.0, [1.0; 3]), defaults(), [0.0, 0.0, 3.0]),
    ]
}

impl State {
    fn look(&self, bundle: &Bundle) -> Look {
        let mut look = Look::default_of(&bundle.scene.meta);
        look.environment = Some(self.environment.clone());
        ["a", "b", "c"].into_iter().zip(self.brdfs).for_each(|(name, brdf)| look.materials.set(name, brdf));
        look.camera = Camera { position: self.eye, ..look.camera };
        look
    }

    fn lights(&self, bundle: &Bundle) -> Lights {
        let map = bundle.maps.iter().find(|map| map.name == self.environment.map).unwrap();
        Lights::new(&map.map, &self.environment, &widths(&bundle.spaces))
    }

    /// What the CPU says that vertices show.
    fn expected(&self, bundle: &Bundle, transfer: &Tensors) -> Vertices {
        let brdfs: Vec<Brdf> = self.brdfs.into_iter().chain([tensors::materials()[3].brdf]).collect();
        let (parts, lights) = (bundle.parts(transfer), self.lights(bundle));
        let shown = parts.shown(&parts.received(&lights, &brdfs), &lights, &brdfs, self.eye);
        let visible = shown
            .iter()
            .map(|shown| std::array::from_fn(|cone| shown.seen.get(cone).copied().unwrap_or_default()));
        Vertices {
            visible: visible.collect(),
            diffuse: shown.iter().map(|shown| shown.diffuse).collect(),
            glossy: shown.iter().map(|shown| shown.glossy).collect(),
        }
    }
}

/// What vertices show, the gain included.
#[derive(Debug, Clone, PartialEq)]
struct Vertices {
    diffuse: Vec<Rgb>,
    glossy: Vec<Rgb>,
    /// The visible parts of cones.
    visible: Vec<[f32; 16]>,
}

/// Submits a frame.
fn draw(gpu: &Gpu, method: &mut TransferTensor, look: &Look) {
    method.update(gpu, look).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut passes = Passes::new(&mut encoder, None, 0);
    method.encode(&mut passes);
    passes.finish();
    gpu.queue.submit([encoder.finish()]);
}

fn vertices(gpu: &Gpu, method: &TransferTensor) -> Vertices {
    let (_, gain) = method.vertex_radiance().unwrap();
    let shown = method.stage.as_ref().unwrap().shown();
    let [diffuse, glossy] = [&shown.radiance, &shown.glossy].map(|buffer| {
        let before = read_radiance(gpu, [buffer]);
        before.into_iter().map(|rgb| std::array::from_fn(|c| rgb[c] * gain[c])).collect()
    });
    Vertices { diffuse, glossy, visible: read_values(gpu, &shown.visible) }
}

/// Fails unless all parts are the CPU's, to single precision of what they are sums of.
#[track_caller]
fn expect_shown(gpu: &Gpu, method: &TransferTensor, expected: &Vertices, what: &str) {
    let ours = vertices(gpu, method);
    for (part, ours, theirs) in
        [("diffuse", &ours.diffuse, &expected.diffuse), ("glossy", &ours.glossy, &expected.glossy)]
    {
        if theirs.iter().flatten().all(|value| *value == 0.0) {
            assert_eq!(ours, theirs, "{what}: {part}");
        } else {
            let difference = largest_difference(ours, theirs);
            println!("{what}: {part} differs by {difference}");
            assert!(difference <= 3e-5, "{what}: {part} differs by {difference}");
        }
    }
    for (vertex, (ours, theirs)) in ours.visible.iter().zip(&expected.visible).enumerate() {
        for (cone, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
            // A place in the hemisphere is off by some 1e-6 of its side, of 24 texels as different as can be; about
            // the normal the CPU's is off by 1e-4.
            assert!(
                (ours - theirs).abs() < 3e-3,
                "{what}: cone {cone} of vertex {vertex}: {ours}, not {theirs}"
            );
        }
    }
    let off = ours.visible.as_flattened().iter().zip(expected.visible.as_flattened());
    let mean = off.map(|(a, b)| (a - b).abs()).sum::<f32>() / (16 * ours.visible.len()) as f32;
    assert!(mean < 1e-4, "{what}: visible parts differ by {mean} in the mean");
}

#[test]
fn vertices_show_what_they_do_on_the_cpu_in_any_state() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write();
    let mut method = load_all(&gpu, &bundle);
    assert!(method.pieces().missing.is_empty() && method.pieces().expected == 5);
    for (number, state) in states().iter().enumerate() {
        draw(&gpu, &mut method, &state.look(&bundle));
        let expected = state.expected(&bundle, &bundle.transfer);
        assert_eq!(number == 5, expected.glossy.iter().flatten().all(|value| *value == 0.0));
        expect_shown(&gpu, &method, &expected, &format!("state {number}"));
    }
}

/// The first `pieces` pieces of tensors: blocks, then light reflected once and twice.
fn prefix(tensors: &Tensors, pieces: usize) -> Tensors {
    let blocks = tensors.blocks.len();
    let mut prefix = tensors.clone();
    prefix.blocks.truncate(pieces);
    if pieces <= blocks {
        prefix.once = None;
    }
    if pieces <= blocks + 1 {
        prefix.twice = None;
    }
    prefix
}

#[test]
fn every_prefix_plays() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write();
    let state = &states()[1];
    let (mut method, later) = load(&gpu, &bundle, 1);
    let mut later = later.into_iter();
    let mut before: Option<Vertices> = None;
    for pieces in 1..=5 {
        while method.pieces().arrived() < pieces {
            method.section_arrived(&gpu, later.next().unwrap()).unwrap();
        }
        assert_eq!(method.pieces().missing, (pieces..5).collect::<Vec<_>>());
        draw(&gpu, &mut method, &state.look(&bundle));
        let expected = state.expected(&bundle, &prefix(&bundle.transfer, pieces));
        expect_shown(&gpu, &method, &expected, &format!("{pieces} pieces"));
        if let Some(before) = before.replace(expected.clone()) {
            let added = [
                largest_difference(&expected.diffuse, &before.diffuse),
                largest_difference(&expected.glossy, &before.glossy),
            ];
            assert!(added.iter().all(|added| *added > 0.02), "piece {pieces} adds {added:?}");
        }
    }
    assert!(later.next().is_none());
}

#[test]
fn bakes_of_fewer_reflections_play() {
    let Some(gpu) = gpu() else { return };
    let state = &states()[1];
    for reflections in [1, 2] {
        let mut transfer = prefix(&tensors::transfer(150), 2 + reflections as usize);
        transfer.meta.reflections = reflections;
        transfer.meta.vectors = 0;
        if reflections == 1 {
            (transfer.meta.sources, transfer.meta.clusters, transfer.meta.ranks) = (Vec::new(), 0, [0; 2]);
        }
        let parts = (tensors::spaces(), tensors::bases());
        let bundle = Bundle::of(tensors::scene(150), crate::support::sparse::maps(), parts, transfer);
        let mut method = load_all(&gpu, &bundle);
        assert!(method.pieces().missing.is_empty());
        draw(&gpu, &mut method, &state.look(&bundle));
        let expected = state.expected(&bundle, &bundle.transfer);
        expect_shown(&gpu, &method, &expected, &format!("{reflections} reflections"));
    }
}

#[test]
fn small_bands_and_dispatches_give_the_identical_picture() {
    let Some(mut gpu) = gpu() else { return };
    let bundle = Bundle::write();
    let state = &states()[3];
    let mut whole = load_all(&gpu, &bundle);
    draw(&gpu, &mut whole, &state.look(&bundle));
    // Two tiles a band, one cluster a batch, one workgroup a row.
    (gpu.binding_bytes, gpu.workgroups_per_dimension) = (2 * 64 * 576, 1);
    let mut method = load_all(&gpu, &bundle);
    draw(&gpu, &mut method, &state.look(&bundle));
    assert_eq!(vertices(&gpu, &method), vertices(&gpu, &whole));
    let film = |method: &TransferTensor| read_radiance(&gpu, &method.film().unwrap().bands);
    assert_eq!(film(&method), film(&whole));
}

#[test]
fn what_is_more_than_the_gpu_binds_is_refused() {
    let Some(mut gpu) = gpu() else { return };
    gpu.binding_bytes = 64 * 576 - 1;
    let message = refusal(&gpu, &Bundle::write());
    assert!(
        message.contains("needs 36864 bytes in one piece") && message.contains("use a coarser mesh"),
        "{message}"
    );
}

#[test]
fn a_map_from_elsewhere_shines() {
    let Some(gpu) = gpu() else { return };
    let mut bundle = Bundle::write();
    let mut method = load_all(&gpu, &bundle);
    let state = State { environment: environment("other", 50.0, [1.0; 3]), ..states().remove(0) };
    draw(&gpu, &mut method, &states()[0].look(&bundle));
    // First new, then in the place of that.
    for name in ["sun", "noise"] {
        let map = bundle.maps.iter().find(|map| map.name == name).unwrap().map.clone();
        let other = Environment { name: "other".to_owned(), map };
        method.add_map(&gpu, &other);
        draw(&gpu, &mut method, &state.look(&bundle));
        bundle.maps.retain(|map| map.name != "other");
        bundle.maps.push(other);
        expect_shown(&gpu, &method, &state.expected(&bundle, &bundle.transfer), name);
    }
}

/// A sheet that is the same everywhere, from so far away that the eye is, too: every point shows the diffuse part
/// of its vertices, what of their glossy part is left, and what its cones have of the map.
#[test]
fn points_show_what_vertices_do_and_the_map_in_cones() {
    let Some(gpu) = gpu() else { return };
    let mut scene = tensors::scene(150);
    let normal = Vec3::new(0.48, -0.6, 0.64);
    scene.positions.iter_mut().for_each(|place| place[2] = 0.0);
    scene.normals = vec![normal.to_array(); 150];
    // In the middle.
    let vertex = 67;
    let target = scene.positions[vertex];
    let eye = 20_000.0 * Vec3::new(0.1, 0.3, 1.0);
    let mut brightest = [0.0_f32; 2];
    for (material, state) in [0, 1, 2].into_iter().zip(states()).chain([1, 2].into_iter().zip(states())) {
        scene.meta.objects.iter_mut().for_each(|object| object.material = material);
        let parts = (tensors::spaces(), tensors::bases());
        let maps = crate::support::sparse::maps();
        let bundle = Bundle::of(scene.clone(), maps, parts, tensors::even_transfer(150));
        let mut method = load_all(&gpu, &bundle);
        let state = State { eye: eye.to_array(), ..state };
        let camera = Camera { position: state.eye, target, fov_deg: 1e-3, exposure_ev: 0.0 };
        draw(&gpu, &mut method, &Look { camera, ..state.look(&bundle) });
        let Vertices { diffuse, glossy, visible } = state.expected(&bundle, &bundle.transfer);
        let brdf = state.brdfs[material as usize];
        let mirrored = bundle.parts(&bundle.transfer).mirrored(
            &state.lights(&bundle),
            &brdf,
            normal,
            eye.normalize(),
            &visible[vertex],
        );
        let albedo = brdf.diffuse_albedo();
        // The map's suns are not among it; none is before this side of the sheet.
        let expected: Rgb = std::array::from_fn(|c| {
            albedo[c] * diffuse[vertex][c] + (glossy[vertex][c] + mirrored[c]).max(0.0)
        });
        let largest = expected.iter().fold(0.0_f32, |most, value| most.max(*value));
        for (most, part) in brightest.iter_mut().zip([mirrored, glossy[vertex]]) {
            let size = part.iter().fold(0.0_f32, |size, value| size.max(value.abs()));
            *most = most.max(size / largest);
        }
        for pixel in read_radiance(&gpu, &method.film().unwrap().bands) {
            // What is in the picture is seen from directions that are 1e-5 apart, and tables turn by 20 a radian.
            let near =
                pixel.iter().zip(expected).all(|(ours, theirs)| (ours - theirs).abs() < 1e-3 * largest);
            assert!(near, "{pixel:?} where {brdf:?} shows {expected:?} in {:?}", state.environment);
        }
    }
    assert!(brightest.iter().all(|part| *part > 0.05), "parts of what is seen: {brightest:?}");
}

/// What is said of files that do not belong together.
fn refusal(gpu: &Gpu, bundle: &Bundle) -> String {
    let setup =
        Setup { scene: bundle.scene.clone(), settings: playlist(bundle.folder(), None).settings, size: None };
    let mut method = TransferTensor::new(gpu, setup).unwrap();
    let refused =
        arrivals(bundle.folder()).into_iter().find_map(|arrival| method.section_arrived(gpu, arrival).err());
    match refused.expect("something is refused") {
        Error::Format(error) if error.is_bad_input() => error.to_string(),
        other => panic!("{other}"),
    }
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let Some(gpu) = gpu() else { return };
    let of = |scene, spaces, bases, transfer| {
        let bundle = Bundle::of(scene, crate::support::sparse::maps(), (spaces, bases), transfer);
        refusal(&gpu, &bundle)
    };
    let (scene, spaces, bases) = (|| tensors::scene(150), tensors::spaces, tensors::bases);
    let transfer = || tensors::transfer(150);
    let twice = [spaces(), spaces()].concat();
    let two = |mut all: Vec<_>| {
        all.truncate(2);
        all
    };
    let mut narrow = transfer();
    narrow.meta.columns -= 1;
    for block in &mut narrow.blocks {
        block.scales.truncate(150 * 8);
        block.steps.truncate(block.indices.len() * 8);
    }
    let mut fixed = scene();
    fixed.meta.materials[1].varies = false;
    for (message, part) in [
        (
            of(tensors::scene(160), spaces(), bases(), transfer()),
            "tensors for 150 vertices of a scene of 160",
        ),
        (of(scene(), twice, bases(), transfer()), "has two BRDF tensors of cook-torrance"),
        (
            of(scene(), two(spaces()), bases(), transfer()),
            "has no BRDF tensor of ggx before it, which material `b`",
        ),
        (of(scene(), spaces(), bases(), narrow), "has 8 columns, a BRDF tensor before it needs 9"),
        (of(fixed, spaces(), bases(), transfer()), "functions of material `b`, which does not vary"),
        (of(scene(), spaces(), Vec::new(), transfer()), "function 0 of material `a`, whose BRDF basis has 0"),
    ] {
        assert!(message.contains(part), "{message}");
    }
}
