//! What transfer-tensor shows in the middles of triangles against the path tracer:
//!
//! `cargo run --release --example tensor_truth -- SCENE BUNDLE [states] [paths]`
//!
//! SCENE is a `scene.toml`, or the name of a scene of the library, and BUNDLE the folder that `bake run` made
//! of it. Every state has random materials, another turn of the scene's map without its suns, whose light a
//! player draws by itself, and the eye in another place. Errors are relative L2 over triangles that the eye
//! sees, in per cent, with the noise of the paths taken off, for 1, 2 and 3 reflections: below 0 where noise
//! hides them.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use relume_bake::methods::spread::spread;
use relume_bake::methods::transfer_images::held_out::random_state;
use relume_bake::trace::lights::Lights as TracedLights;
use relume_bake::trace::path::PathTracer;
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::world::World;
use relume_formats::basis::EquirectMap;
use relume_formats::basis::suns::split;
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_tensor::{Lights, Parts, Received, Shown, widths};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{BrdfBasis, BrdfTensor, StoredScene, TransferTensor};
use relume_formats::state::Brdf;
use relume_scenes::Scene;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

/// Triangles whose middles are looked at.
const TRIANGLES: usize = 800;
/// How near to it a path begins, in parts of the scene's extent.
const NEAR: f32 = 1e-3;

struct Bundle {
    scene: StoredScene,
    spaces: Vec<BrdfTensor>,
    bases: Vec<BrdfBasis>,
    transfer: TransferTensor,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (scene, bundle) =
        (arguments.next().ok_or("SCENE is missing")?, arguments.next().ok_or("BUNDLE is missing")?);
    let states: u64 = arguments.next().map_or(Ok(4), |n| n.parse())?;
    let paths: u32 = arguments.next().map_or(Ok(256), |n| n.parse())?;
    let path = relume_scenes::resolve(&scene)?;
    let bundle = read(Path::new(&bundle))?;
    println!("| state | reflections | error | noise | by material |\n|---|---|---|---|---|");
    for state in 0..states {
        let mut scene = relume_scenes::load(&path)?;
        set(&mut scene, state);
        for reflections in 1..=scene.reflections {
            let (all, noise, of_materials) = errors(&scene, &bundle, (state, reflections, paths));
            println!("| {state} | {reflections} | {all:.2} | {noise:.2} | {of_materials} |");
        }
    }
    Ok(())
}

fn read(folder: &Path) -> Result<Bundle, Box<dyn Error>> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    names.sort();
    let of = |start: &str| {
        let starts = |path: &&std::path::PathBuf| {
            path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(start))
        };
        names.iter().filter(starts).cloned().collect::<Vec<_>>()
    };
    Ok(Bundle {
        scene: StoredScene::read_file(&folder.join("scene.relume"))?,
        spaces: of("brdf-tensor").iter().map(|path| BrdfTensor::read_file(path)).collect::<Result<_, _>>()?,
        bases: of("brdf-functions")
            .iter()
            .map(|path| BrdfBasis::read_file(path))
            .collect::<Result<_, _>>()?,
        transfer: TransferTensor::read_file(&folder.join("transfer-tensor.relume"))?,
    })
}

/// Materials, light and eye of a state; number 0 has the materials of the scene.
fn set(scene: &mut Scene, state: u64) {
    if let Some(environment) = &mut scene.environment {
        let rest = split(&environment.map.map).rest.into_owned();
        environment.map.map = Arc::new(rest);
        environment.rotation_deg += 222.5 * state as f32;
    }
    if state > 0 {
        let random = random_state(state as u32, scene);
        for (material, brdf) in scene.vary.materials.clone().into_iter().zip(random) {
            scene.materials[material].brdf = brdf;
        }
    }
    let (target, position) = (Vec3::from(scene.camera.target), Vec3::from(scene.camera.position));
    let turn = glam::Quat::from_rotation_y(0.35 * ((state as f32 * 2.4).sin()));
    scene.camera.position =
        (target + turn * (position - target) + Vec3::Y * 0.2 * state as f32 * 0.5).to_array();
}

fn errors(
    scene: &Scene,
    bundle: &Bundle,
    (state, reflections, paths): (u64, u32, u32),
) -> (f64, f64, String) {
    let world = World::new(scene);
    let lights = TracedLights::new(scene, &world);
    let tracer = PathTracer::new(scene, &world, &lights, [1, 1], reflections, state);
    let eye = scene.camera.position;
    let brdfs: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    let (lights_of_map, shown) = shown(scene, bundle, &brdfs, reflections);
    let parts = bundle.parts();
    let materials = bundle.scene.materials_of_vertices();
    let of_triangle = |number: usize| {
        let corners = bundle.scene.triangles[number].map(|vertex| vertex as usize);
        let mean = |of: &dyn Fn(usize) -> Vec3| corners.into_iter().map(of).sum::<Vec3>() / 3.0;
        let position = mean(&|v| Vec3::from(bundle.scene.positions[v]));
        let normal = mean(&|v| Vec3::from(bundle.scene.normals[v]));
        let outgoing = (Vec3::from(eye) - position).normalize();
        // What is hidden from the eye is not looked at, nor what is seen along the surface.
        let origin = Vec3A::from(position + NEAR * world.radius * outgoing);
        if normal.dot(outgoing) < 0.1
            || world.occluded(origin, outgoing.into(), position.distance(eye.into()))
        {
            return None;
        }
        let textured = world.meet(origin, -Vec3A::from(outgoing))?.albedo;
        let halves = [0, 1].map(|half| {
            let sampler = PixelSampler::new(2 * state + half, number as u32);
            let path = |index| tracer.radiance(origin, -Vec3A::from(outgoing), &sampler.sample(index));
            (0..paths / 2).map(path).sum::<Vec3A>() / (paths / 2) as f32
        });
        let brdf = &brdfs[materials[corners[0]] as usize];
        let albedo = Vec3::from(brdf.diffuse_albedo()) * Vec3::from(textured);
        let of_vertices = mean(&|v| albedo * Vec3::from(shown[v].diffuse) + Vec3::from(shown[v].glossy));
        let seen = |cone: usize| corners.into_iter().map(|v| shown[v].seen[cone]).sum::<f32>() / 3.0;
        let seen: Vec<f32> = (0..shown[corners[0]].seen.len()).map(seen).collect();
        let mirrored = parts.mirrored(&lights_of_map, brdf, normal.normalize(), outgoing, &seen);
        let found = of_vertices + Vec3::from(mirrored);
        Some((materials[corners[0]] as usize, Vec3A::from(found), halves))
    };
    let some = spread(TRIANGLES, bundle.scene.triangles.len());
    let all: Vec<_> = some.into_par_iter().filter_map(of_triangle).collect();
    // The product of the differences from both halves has no noise of either in its mean.
    let sum = |of: &dyn Fn(usize) -> bool| {
        let (mut off, mut norm, mut noise) = (0.0f64, 0.0f64, 0.0f64);
        for (_, found, [a, b]) in all.iter().filter(|(material, ..)| of(*material)) {
            off += f64::from((*found - *a).dot(*found - *b));
            norm += f64::from(a.dot(*b));
            noise += f64::from((*a - *b).length_squared()) / 4.0;
        }
        [off, noise].map(|squares| 100.0 * squares.signum() * (squares.abs() / norm).sqrt())
    };
    let [all, noise] = sum(&|_| true);
    let of_materials = (0..scene.materials.len())
        .map(|m| format!("{} {:.1}", scene.materials[m].name, sum(&|of| of == m)[0]));
    (all, noise, of_materials.collect::<Vec<_>>().join(", "))
}

impl Bundle {
    fn parts(&self) -> Parts<'_> {
        Parts { scene: &self.scene, spaces: &self.spaces, bases: &self.bases, transfer: &self.transfer }
    }
}

fn shown(scene: &Scene, bundle: &Bundle, brdfs: &[Brdf], reflections: u32) -> (Lights, Vec<Shown>) {
    let parts = bundle.parts();
    let environment = scene.environment.as_ref();
    let look = EnvironmentLook {
        map: String::new(),
        gain: environment.map_or([0.0; 3], |e| e.gain),
        rotation_deg: environment.map_or(0.0, |e| e.rotation_deg),
    };
    let dark = EquirectMap { width: 2, height: 1, texels: vec![[0.0; 3]; 2] };
    let map = environment.map_or(&dark, |e| &e.map.map);
    let lights = Lights::new(map, &look, &widths(&bundle.spaces));
    let mut received: Received = parts.received(&lights, brdfs);
    if reflections < 2 {
        received.once.fill([[0.0; 3]; 16]);
    }
    if reflections < 3 {
        received.twice.fill([0.0; 3]);
    }
    let shown = parts.shown(&received, &lights, brdfs, scene.camera.position);
    (lights, shown)
}
