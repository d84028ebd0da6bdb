//! The ladder of docs/notes/SPHERE-SHADOWS.md: from rays against the true mesh to sparse terms and one level
//! of visibility, each step against the one before and against the first. It takes some minutes, and
//! bunny-shadow needs the assets (`make assets`):
//!
//! `cargo run --release --example ladder -- bunny-shadow|knot-twist`

mod table_caps;

use rayon::prelude::*;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, ProgressMode};
use relume_bake::methods::sphere_shadows::casters::{By, put};
use relume_bake::methods::sphere_shadows::errors::{Posed, lobes, shown_in};
use relume_bake::methods::sphere_shadows::rows;
use relume_bake::methods::sphere_shadows::truth::centre;
use relume_bake::spheres::fit::{DEFAULT_ITERATIONS, Settings, fit};
use relume_bake::spheres::motion::poses;
use relume_bake::trace::receivers;
use relume_bake::trace::world::World;
use relume_chart::metrics::{displayed, mean_flip};
use relume_formats::Place;
use relume_formats::basis::cap::{Bitmap, ROWS};
use relume_formats::basis::haar::{forward_cube, inverse_cube};
use relume_formats::basis::{EquirectMap, cubemap};
use relume_formats::evaluate::sphere_shadows::{Levels, Receiver, blocked, light, radiance};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::{SphereSet, SphereShadows, VisibilityTable};
use relume_formats::state::{Rgb, ShapeState, State};
use relume_scenes::Scene;
use std::process::ExitCode;
use std::time::Instant;
use table_caps::blocked_by_table;

/// Receivers along a side of the plane.
const SIDE: usize = 128;
const SPHERES: [u32; 4] = [32, 64, 96, 128];
const TERMS: [usize; 3] = [200, 100, 50];

/// A light as texels, and as coefficients.
struct Lit {
    name: String,
    texels: [Vec<f32>; 3],
    planes: [Vec<f32>; 3],
}

impl Lit {
    fn new(name: &str, map: &EquirectMap) -> Self {
        let cube = cubemap::from_equirect(map, 0.0, 32);
        let texels: [Vec<f32>; 3] = std::array::from_fn(|c| cube.iter().map(|t| t[c]).collect());
        let mut planes = texels.clone();
        planes.iter_mut().for_each(|plane| forward_cube(plane, 32));
        Self { name: name.to_owned(), texels, planes }
    }

    /// Σ L·ρ̃ over the texels that are not blocked, ρ̃ by texels.
    fn sum(&self, rho: &[f32], blocked: &Bitmap) -> Rgb {
        let mut sums = [0.0f64; 3];
        for (texel, rho) in rho.iter().enumerate().filter(|(_, rho)| **rho != 0.0) {
            if blocked[texel / 32] >> (texel % 32) & 1 == 0 {
                (0..3).for_each(|c| sums[c] += f64::from(self.texels[c][texel]) * f64::from(*rho));
            }
        }
        sums.map(|sum| sum as f32)
    }
}

/// A step of the ladder: its name and its image under each light.
struct Step {
    name: String,
    /// The step that it is compared with besides the first.
    before: usize,
    images: Vec<Vec<Rgb>>,
}

fn percent(x: &[Rgb], reference: &[Rgb]) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for (a, b) in x.as_flattened().iter().zip(reference.as_flattened()) {
        off += f64::from(a - b).powi(2);
        norm += f64::from(*b).powi(2);
    }
    100.0 * (off / norm).sqrt()
}

/// Mean FLIP of two images of the plane, shown so that without blockers it would be at 80 % of white
/// (luminance).
fn flip(x: &[Rgb], reference: &[Rgb], open: Rgb) -> f64 {
    let gain = 0.8 / (0.2126 * open[0] + 0.7152 * open[1] + 0.0722 * open[2]);
    mean_flip(&displayed(x, gain), &displayed(reference, gain), [SIDE as u32; 2])
}

/// The texels that the mesh of the scene blocks for each vertex in `vertices`, by a ray to the centre of each
/// that has a value in its lobe.
fn blocked_by_mesh(scene: &Scene, vertices: &[usize], rho: impl Fn(usize) -> Vec<f32> + Sync) -> Vec<Bitmap> {
    let (world, receivers) = (World::new(scene), receivers::receivers(scene));
    let of = |vertex: &usize| {
        let receiver = &receivers[*vertex];
        let mut bitmap = [0; ROWS];
        for (texel, _) in rho(*vertex).iter().enumerate().filter(|(_, rho)| **rho != 0.0) {
            bitmap[texel / 32] |=
                u32::from(world.occluded(receiver.origin, centre(texel), f32::INFINITY)) << (texel % 32);
        }
        bitmap
    };
    vertices.par_iter().map(of).collect()
}

/// A scene in a pose, its spheres fitted in all numbers.
struct Prepared {
    scene: Scene,
    plane: Vec<usize>,
    object: Vec<usize>,
    shadows: SphereShadows,
    sets: Vec<SphereSet>,
}

fn prepare(name: &str, state: &State) -> Result<Prepared> {
    let rest = relume_scenes::load(&relume_scenes::resolve(name)?)?;
    let object = &rest.objects[0];
    let poses = object.shape.as_deref().map(poses).unwrap_or_default();
    let set = |spheres: &u32| {
        let settings =
            Settings { spheres: *spheres as usize, seed: 0, iterations: DEFAULT_ITERATIONS, tight: 0.0 };
        let place = Place::file(&rest.file);
        Ok(fit(&object.mesh, &poses, &object.name, &place, &settings, &Job::new(ProgressMode::None))?.set)
    };
    let sets = SPHERES.iter().map(set).collect::<Result<Vec<_>>>()?;
    let vertices = rest.objects.iter().map(|o| o.mesh.positions.len()).collect::<Vec<_>>();
    assert_eq!(vertices[1], SIDE * SIDE);
    let plane = (vertices[0]..vertices[0] + vertices[1]).collect();
    let scene = rest.with_state(state, &Place::file(name))?;
    let mut shadows = rows::bake(&scene);
    let by = rest.objects.iter().map(|o| o.spheres.map_or(By::Nothing, By::Spheres)).collect::<Vec<By>>();
    put(&mut shadows, &by);
    Ok(Prepared { shadows, scene, plane, object: (0..vertices[0]).collect(), sets })
}

impl Prepared {
    /// A receiver's lobe by texels, blended as the product has it.
    fn rho(&self, receiver: &Receiver) -> Vec<f32> {
        let mut rho = vec![0.0; 6144];
        for (row, weight) in receiver.lobes.iter().filter(|(_, weight)| *weight != 0.0) {
            rho.iter_mut().zip(self.shadows.lobe(*row as usize)).for_each(|(sum, c)| *sum += weight * c);
        }
        inverse_cube(&mut rho, 32);
        // What the inverse leaves of zeros.
        rho.iter_mut().filter(|r| r.abs() < 1e-8).for_each(|r| *r = 0.0);
        rho
    }

    fn print(&self, title: &str, lights: &[Lit]) -> Result<()> {
        let sets = |number: usize| std::slice::from_ref(&self.sets[number]);
        let posed = |number: usize, vertices: &[usize]| {
            shown_in((&self.scene, &self.scene), vertices, &self.shadows, sets(number))
        };
        let first = posed(0, &self.plane)?;
        let rho = self.rho(&first.receivers[0]);
        let start = Instant::now();
        let by_mesh = blocked_by_mesh(&self.scene, &self.plane, |_| rho.clone());
        println!("\n{title}: rays in {:.1} s", start.elapsed().as_secs_f64());
        let table = VisibilityTable::bake();
        let steps = |number: usize| {
            ladder(&posed(number, &self.plane)?, &self.shadows, &rho, &by_mesh, &table, lights)
        };
        let ladders = (0..SPHERES.len()).map(steps).collect::<Result<Vec<Vec<Step>>>>()?;
        for (at, lit) in lights.iter().enumerate() {
            println!(
                "\n**{title}, {}**\n\n| step | {} |\n|---|---|---|---|---|",
                lit.name,
                SPHERES.map(|n| format!("n_s = {n}")).join(" | ")
            );
            let open = lit.sum(&rho, &[0; ROWS]);
            for step in 1..ladders[0].len() {
                let cell = |steps: &Vec<Step>| {
                    let Step { before, images, .. } = &steps[step];
                    let (ours, before, truth) =
                        (&images[at], &steps[*before].images[at], &steps[0].images[at]);
                    let [l2, l2_first] = [before, truth].map(|r| percent(ours, r));
                    let [flip, flip_first] = [before, truth].map(|r| flip(ours, r, open));
                    format!("{l2:.3} / {l2_first:.2}, {flip:.4} / {flip_first:.4}")
                };
                println!(
                    "| {} | {} |",
                    ladders[0][step].name,
                    ladders.iter().map(cell).collect::<Vec<_>>().join(" | ")
                );
            }
        }
        self.print_object(title, lights)
    }

    /// The vertices of the object itself: with the rule of self-shadowing, with its whole own set left out,
    /// and as shown.
    fn print_object(&self, title: &str, lights: &[Lit]) -> Result<()> {
        let posed = self.sets.iter().map(|set| {
            shown_in((&self.scene, &self.scene), &self.object, &self.shadows, std::slice::from_ref(set))
        });
        let posed = posed.collect::<Result<Vec<Posed>>>()?;
        let exact: Vec<Vec<f32>> = posed[0].receivers.iter().map(|receiver| self.rho(receiver)).collect();
        let by_mesh = blocked_by_mesh(&self.scene, &self.object, |vertex| exact[vertex].clone());
        println!(
            "\n**{title}, the object's own vertices: relative L2, %**\n\n| light | step | {} |\n|---|---|---|---|---|---|",
            SPHERES.map(|n| format!("n_s = {n}")).join(" | ")
        );
        for lit in lights {
            let image = |of: &dyn Fn(usize) -> Bitmap| {
                exact.iter().enumerate().map(|(at, rho)| lit.sum(rho, &of(at))).collect::<Vec<_>>()
            };
            let truth = image(&|at| by_mesh[at]);
            let rule =
                posed.iter().map(|p| percent(&image(&|at| blocked(&p.receivers[at], &p.casters)), &truth));
            let none = posed.iter().map(|_| percent(&image(&|_| [0; ROWS]), &truth));
            let kept = Some(TERMS[0]);
            let shown = posed.iter().map(|p| {
                percent(
                    &p.under(&Shading::new(
                        &lobes(&self.shadows, kept),
                        &light(lit.planes.clone(), kept),
                        Levels::Two,
                    )),
                    &truth,
                )
            });
            let row = |name: &str, cells: Vec<f64>| {
                println!(
                    "| {} | {name} | {} |",
                    lit.name,
                    cells.iter().map(|c| format!("{c:.2}")).collect::<Vec<_>>().join(" | ")
                );
            };
            row("exact caps, by the rule", rule.collect());
            row("its own spheres left out altogether", none.collect());
            row("200 terms, level II", shown.collect());
        }
        Ok(())
    }
}

/// All steps for one number of spheres.
///
/// # Errors
/// If wavelets with all terms are not what the pixel basis is.
fn ladder(
    posed: &Posed,
    shadows: &SphereShadows,
    rho: &[f32],
    by_mesh: &[Bitmap],
    table: &VisibilityTable,
    lights: &[Lit],
) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    let mut push = |name: String, before: usize, images: Vec<Vec<Rgb>>| {
        steps.push(Step { name, before, images });
        steps.len() - 1
    };
    let pixels = |bitmaps: &[Bitmap]| {
        lights.iter().map(|lit| bitmaps.par_iter().map(|b| lit.sum(rho, b)).collect()).collect()
    };
    let truth = push("mesh".to_owned(), 0, pixels(by_mesh));
    let timed = |of: &(dyn Fn(&Receiver) -> Bitmap + Sync)| {
        let start = Instant::now();
        let bitmaps: Vec<Bitmap> = posed.receivers.iter().map(of).collect();
        (bitmaps, start.elapsed().as_secs_f64() * 1e6 / posed.receivers.len() as f64)
    };
    let (exact, exact_us) = timed(&|receiver| blocked(receiver, &posed.casters));
    let (rounded, rounded_us) = timed(&|receiver| blocked_by_table(receiver, &posed.casters.spheres, table));
    println!(
        "{} spheres: exact caps {exact_us:.1} µs a receiver, table {rounded_us:.1} µs",
        posed.casters.spheres[0].now.len()
    );
    let spheres = push("spheres, exact caps".to_owned(), truth, pixels(&exact));
    push("spheres, table".to_owned(), spheres, pixels(&rounded));
    let whole = lobes(shadows, None);
    let meaning = |lit: &Lit| {
        let light = light(lit.planes.clone(), None);
        let chunk = |receivers: &[Receiver]| {
            radiance(receivers, &posed.casters, &whole, &light, Levels::All, &posed.table)
        };
        posed.receivers.par_chunks(64).flat_map_iter(chunk).collect::<Vec<Rgb>>()
    };
    let wavelets = push("wavelets, all terms".to_owned(), spheres, lights.iter().map(meaning).collect());
    for terms in TERMS {
        let lobes = lobes(shadows, Some(terms));
        let mut before = wavelets;
        for (name, levels) in [("all levels", Levels::All), ("II", Levels::Two), ("I", Levels::One)] {
            let image = |lit: &Lit| {
                posed.under(&Shading::new(&lobes, &light(lit.planes.clone(), Some(terms)), levels))
            };
            before = push(format!("{terms} terms, {name}"), before, lights.iter().map(image).collect());
        }
    }
    let off = (0..lights.len())
        .map(|at| percent(&steps[wavelets].images[at], &steps[spheres].images[at]))
        .fold(0.0, f64::max);
    if off >= 0.01 {
        let reason = format!("wavelets with all terms equal the pixel basis to 1e-4, here {off} %");
        return Err(BakeError::invalid(&Place::file("sphere-shadows"), reason));
    }
    Ok(steps)
}

fn bunny() -> Result<()> {
    let prepared = prepare("bunny-shadow", &State::default())?;
    let maps = prepared.scene.environment.iter().flat_map(|e| [&e.map].into_iter().chain(&e.others));
    let lights = ["city.exr", "studio.exr", "sky.exr"]
        .map(|name| maps.clone().find(|m| m.name.ends_with(name)).map(|m| Lit::new(name, &m.map)));
    prepared.print("bunny-shadow", &lights.into_iter().flatten().collect::<Vec<_>>())
}

fn knot() -> Result<()> {
    let twisted = State {
        shapes: [("knot".to_owned(), ShapeState { time_s: Some(1.3), ..ShapeState::default() })].into(),
        ..State::default()
    };
    let prepared = prepare("knot-twist", &twisted)?;
    let height = |y: u32| (0.5 - (y as f32 + 0.5) / 64.0).to_radians() * 180.0;
    let smooth = |i: u32| {
        let (elevation, azimuth) = (height(i / 128), std::f32::consts::TAU * (i % 128) as f32 / 128.0);
        let brighter = 0.6 + 0.4 * elevation.cos() * azimuth.cos();
        [brighter, brighter * (0.9 + 0.1 * elevation.sin()), 0.8 + 0.2 * elevation.sin()]
    };
    let smooth = EquirectMap { width: 128, height: 64, texels: (0..128 * 64).map(smooth).collect() };
    let sun = prepared.scene.environment.iter().map(|e| Lit::new("clear-sky, with a sun", &e.map.map));
    prepared.print(
        "knot-twist at 1.3 s",
        &[Lit::new("a smooth sky", &smooth)].into_iter().chain(sun).collect::<Vec<_>>(),
    )
}

fn main() -> ExitCode {
    let printed = match std::env::args().nth(1).as_deref() {
        Some("bunny-shadow") => bunny(),
        Some("knot-twist") => knot(),
        _ => Err(BakeError::invalid(&Place::file("SCENE"), "give bunny-shadow or knot-twist")),
    };
    let Err(error) = printed else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
