//! What each object of a scene could cast shadows by: for each option its cost, and its error, median and worst
//! over poses and held-out lights. `cargo run --release --example caster_table -- SCENE`; with `tight` after it,
//! spheres that are fitted more and less tightly, for the objects that have some.

#![allow(missing_docs, reason = "a program")]

use relume_bake::error::Result;
use relume_bake::job::{Job, ProgressMode};
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::sphere_shadows::Asked;
use relume_bake::methods::sphere_shadows::casters::{CasterOption, options};
use relume_bake::methods::sphere_shadows::rows;
use relume_bake::spheres::fit::{Settings, fit};
use relume_bake::spheres::motion::poses;
use relume_formats::Place;
use relume_formats::kinds::SphereSet;
use relume_scenes::Scene;

/// Spheres of an object.
const SPHERES: [usize; 3] = [16, 64, 128];
/// How far outside every sphere a point may lie, in parts of the bounding box's diagonal.
const TIGHT: [f64; 5] = [0.0, 0.0005, 0.002, 0.005, 0.02];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "knot-twist".to_owned());
    let scene = relume_scenes::load(&relume_scenes::resolve(&name)?)?;
    let job = Job::new(ProgressMode::None);
    if arguments.next().is_some_and(|what| what == "tight") {
        return by_tightness(&scene, &job);
    }
    let options = options(&scene, &rows::bake(&scene), &environments(&scene), None, Asked::Error(0.0), &job)?;
    for (object, options) in scene.objects.iter().zip(options) {
        println!(
            "\n`{}`, {} triangles\n\n| casts by | ns | median % | worst % |\n|---|---|---|---|",
            object.name,
            object.mesh.triangles.len()
        );
        for option in options {
            let (median, worst) = median_and_worst(&option);
            println!("| {} | {:.0} | {median:.2} | {worst:.2} |", option.by.words(), option.by.cost());
        }
    }
    Ok(())
}

/// Errors of an option in percent.
fn median_and_worst(option: &CasterOption) -> (f64, f64) {
    let mut errors: Vec<f64> = option.squares.iter().map(|square| 100.0 * square.sqrt()).collect();
    errors.sort_by(f64::total_cmp);
    (errors[errors.len() / 2], errors[errors.len() - 1])
}

fn by_tightness(scene: &Scene, job: &Job) -> Result<()> {
    let (rows, maps) = (rows::bake(scene), environments(scene));
    println!("| object | spheres | tight | median % | worst % |\n|---|---|---|---|---|");
    for (spheres, tight) in SPHERES.into_iter().flat_map(|n| TIGHT.map(|tight| (n, tight))) {
        let settings = Settings { spheres, seed: 0, iterations: 200, tight };
        let with_some = || scene.objects.iter().filter(|object| object.spheres.is_some());
        let fitted = with_some().map(|object| {
            let poses = object.shape.as_deref().map(poses).unwrap_or_default();
            let place = Place::file(&scene.file).part(&object.name);
            Ok(fit(&object.mesh, &poses, &object.name, &place, &settings, job)?.set)
        });
        let sets = fitted.collect::<Result<Vec<SphereSet>>>()?;
        let options = options(scene, &rows, &maps, Some(&sets), Asked::Spheres, job)?;
        for (object, options) in scene.objects.iter().zip(&options).filter(|(o, _)| o.spheres.is_some()) {
            for option in options {
                let (median, worst) = median_and_worst(option);
                println!("| {} | {spheres} | {tight} | {median:.2} | {worst:.2} |", object.name);
            }
        }
    }
    Ok(())
}
