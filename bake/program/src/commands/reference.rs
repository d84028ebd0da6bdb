//! `bake reference`.

use super::common::{load, start_threads, warn, warn_of_per_cent};
use crate::cli::ReferenceArgs;
use relume_bake::brdf::blinn_phong::glossy_albedo;
use relume_bake::error::{BakeError, Result};
use relume_bake::exr_file::write_exr;
use relume_bake::filter::pictures;
use relume_bake::job::{Job, say, watch_signals};
use relume_bake::noise_target::NoiseTarget;
use relume_bake::output::expect_writable;
use relume_bake::paintings::paintings;
use relume_bake::trace::gather::MAX_REFLECTIONS;
use relume_bake::trace::reference::{self, Estimate, Paths};
use relume_chart::picture;
use relume_formats::Place;
use relume_formats::container::replace_file;
use relume_formats::display::Display;
use relume_formats::state::{BlinnPhong, Brdf, Paint, State, with_line};
use relume_scenes::{ALL_REFLECTIONS, Scene};
use std::path::{Path, PathBuf};

/// `bake reference`.
pub fn reference(args: &ReferenceArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let base = load(&args.scene)?;
    let states = if args.state.is_empty() { vec![base.clone()] } else { states(&base, &args.state)? };
    let files = output_files(&args.output, states.len())?;
    if args.noise.is_some() && args.paths != Paths::Gather {
        let reason = "is for --paths gather; add that, or set the noise by --spp";
        return Err(BakeError::invalid(&Place::file("--noise"), reason));
    }
    args.noise.into_iter().for_each(|noise| warn_of_per_cent("noise", noise));
    let settings = reference::Settings {
        size: args.size.unwrap_or(base.size),
        samples: args.spp,
        seed: args.seed,
        reflections: reflections(args, &base)?,
        paths: args.paths,
        target: args.noise.map(|noise| NoiseTarget { noise, filter: args.filter }),
    };
    states.iter().for_each(|state| warn_of_gain(state, settings.reflections));
    let job = Job::new(args.progress);
    files.iter().try_for_each(|file| expect_writable(file))?;
    let paintings = if states.iter().any(is_painted) { paintings(&base, &job)? } else { Vec::new() };
    // States of the same light, view and shape share one set of gather paths; the others need their own, and
    // the sooner each is written the better.
    let mut from = 0;
    while from < states.len() {
        let alike = |s: &&Scene| args.paths == Paths::Gather && differ_in_materials_only(s, &states[from]);
        let to = from + states[from..].iter().take_while(alike).count().max(1);
        // Directions follow the base's materials, whatever the states say.
        let base = Scene { materials: base.materials.clone(), ..states[from].clone() };
        let (filtered, states_alike) = (args.filter && args.paths == Paths::Gather, &states[from..to]);
        // Filters mix what is alike but for its textures.
        let images = if filtered && !states_alike.iter().any(is_painted) {
            pictures::render(&base, states_alike, &settings, &job)
        } else {
            reference::render(&base, states_alike, &paintings, &settings, &job)
        }?;
        for ((image, state), file) in images.iter().zip(&states[from..to]).zip(&files[from..to]) {
            match file.extension().is_some_and(|ending| ending == "png") {
                true => write_shown(image, state, settings.size, file)?,
                false => write_estimate(image, settings.size, file)?,
            }
        }
        from = to;
    }
    Ok(files.iter().map(|f| format!("{}\n", f.display())).collect())
}

fn states(base: &Scene, files: &[PathBuf]) -> Result<Vec<Scene>> {
    let state = |file: &PathBuf| {
        let state = base.with_state(&State::read_file(file)?, &Place::file(file)).map_err(with_line)?;
        warn(state.warnings.get(base.warnings.len()..).unwrap_or_default());
        Ok(state)
    };
    files.iter().map(state).collect()
}

fn is_painted(state: &Scene) -> bool {
    state.materials.iter().any(|material| material.paint.is_some())
}

fn reflections(args: &ReferenceArgs, scene: &Scene) -> Result<u32> {
    match (args.paths, args.reflections) {
        (Paths::Best, n) => Ok(n.unwrap_or(ALL_REFLECTIONS)),
        (Paths::Gather, None) if scene.reflections == ALL_REFLECTIONS => Ok(ALL_REFLECTIONS),
        (Paths::Gather, None) => Ok(scene.reflections.min(MAX_REFLECTIONS)),
        (Paths::Gather, Some(n)) if n <= MAX_REFLECTIONS => Ok(n),
        (Paths::Gather, Some(n)) => {
            let place = Place::file("--reflections");
            Err(BakeError::invalid(
                &place,
                format!(
                    "{n} with --paths gather, which traces at most {MAX_REFLECTIONS}, or what the scene says if that is \"all\"; use --paths best"
                ),
            ))
        }
    }
}

/// Sums over many reflections need not converge if a material sends back more than it gets.
fn warn_of_gain(scene: &Scene, reflections: u32) {
    for material in scene.materials.iter().filter(|_| reflections > MAX_REFLECTIONS) {
        let albedo = material.paint.as_deref().map_or_else(|| most_reflected(&material.brdf), most_of_paint);
        if albedo > 1.0 {
            let name = &material.name;
            say(&format!(
                "warning: material `{name}` reflects up to {albedo:.2} times what it receives; many reflections may not converge, add --reflections 2 or lower ks"
            ));
        }
    }
}

/// Of what arrives, in the channel that reflects most.
fn most_reflected(brdf: &Brdf) -> f32 {
    // The other models never reflect more than they receive.
    let Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) = brdf else { return 0.0 };
    kd.iter().zip(ks).map(|(kd, ks)| kd + ks * glossy_albedo(*shininess)).fold(0.0, f32::max)
}

fn most_of_paint(paint: &Paint) -> f32 {
    let of_texel = |texel| paint.brdf.channels(texel).iter().map(most_reflected).fold(0.0, f32::max);
    paint.texels.iter().map(of_texel).fold(0.0, f32::max)
}

fn differ_in_materials_only(a: &Scene, b: &Scene) -> bool {
    let environment = |s: &Scene| {
        s.environment.as_ref().map(|e| (e.gain, e.rotation_deg, std::sync::Arc::as_ptr(&e.map.map)))
    };
    let camera = |s: &Scene| (s.camera.position, s.camera.target, s.camera.fov_deg);
    let meshes =
        |s: &Scene| s.objects.iter().map(|object| std::sync::Arc::as_ptr(&object.mesh)).collect::<Vec<_>>();
    meshes(a) == meshes(b)
        && camera(a) == camera(b)
        && a.lights == b.lights
        && environment(a) == environment(b)
}

/// The file for each of `count` images: the name itself for one, else the pattern with its number filled in.
fn output_files(pattern: &str, count: usize) -> Result<Vec<PathBuf>> {
    let place = Place::file(pattern);
    let refuse = |reason: &str| Err(BakeError::invalid(&place, reason));
    let ending = Path::new(pattern).extension().unwrap_or_default();
    if ending != "exr" && ending != "png" {
        return refuse("references are written as .exr, or to look at as .png; end the name so");
    }
    let Some((before, rest)) = pattern.split_once('%') else {
        return if count == 1 {
            Ok(vec![pattern.into()])
        } else {
            refuse("many states need a pattern such as 'OUT/%04d.exr'")
        };
    };
    let Some((digits, after)) = rest
        .split_once('d')
        .filter(|(d, after)| d.chars().all(|c| c.is_ascii_digit()) && !after.contains('%'))
    else {
        return refuse("a pattern has one number such as %d or %04d");
    };
    let width: usize = digits.parse().unwrap_or(1).min(20);
    Ok((0..count).map(|i| format!("{before}{i:0width$}{after}").into()).collect())
}

/// As the player shows it.
fn write_shown(image: &Estimate, state: &Scene, size: [u32; 2], file: &Path) -> Result<()> {
    let display = Display { exposure_ev: state.camera.exposure_ev, tonemap: state.tonemap };
    let shown: Vec<_> = image.radiance.iter().map(|radiance| display.shown(*radiance)).collect();
    Ok(replace_file(file, &picture::alone(&shown, size, 0.0)?)?)
}

fn write_estimate(image: &Estimate, [width, height]: [u32; 2], file: &Path) -> Result<()> {
    let plane =
        |pixels: &[[f32; 3]], channel: usize| -> Vec<f32> { pixels.iter().map(|p| p[channel]).collect() };
    let [r, g, b] = [0, 1, 2].map(|c| plane(&image.radiance, c));
    let [vr, vg, vb] = [0, 1, 2].map(|c| plane(&image.variance, c));
    let channels =
        [("R", &r[..]), ("G", &g), ("B", &b), ("variance.R", &vr), ("variance.G", &vg), ("variance.B", &vb)];
    Ok(write_exr(file, width as usize, height as usize, &channels)?)
}
