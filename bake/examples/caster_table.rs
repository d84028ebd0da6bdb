//! What each object of a scene could cast shadows by: for each option its cost, and its error, median and worst
//! over poses and held-out lights. `cargo run --release --example caster_table -- SCENE`.

#![allow(missing_docs, reason = "a program")]

use relume_bake::error::Result;
use relume_bake::job::{Job, ProgressMode};
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::sphere_shadows::Asked;
use relume_bake::methods::sphere_shadows::casters::options;
use relume_bake::methods::sphere_shadows::rows;

fn main() -> Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "knot-twist".to_owned());
    let scene = relume_scenes::load(&relume_scenes::resolve(&name)?)?;
    let job = Job::new(ProgressMode::None);
    let options = options(&scene, &rows::bake(&scene), &environments(&scene), None, Asked::Error(0.0), &job)?;
    for (object, options) in scene.objects.iter().zip(options) {
        println!(
            "\n`{}`, {} triangles\n\n| casts by | ns | median % | worst % |\n|---|---|---|---|",
            object.name,
            object.mesh.triangles.len()
        );
        for option in options {
            let mut errors: Vec<f64> = option.squares.iter().map(|square| 100.0 * square.sqrt()).collect();
            errors.sort_by(f64::total_cmp);
            let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
            println!("| {} | {:.0} | {median:.2} | {worst:.2} |", option.by.words(), option.by.cost());
        }
    }
    Ok(())
}
