//! transfer-images: paths, bases, rounding.

use crate::steps::{SAMPLES, SIZE, STATES, at_states, bundle_folder, library, percent, played, quiet};
use glam::DVec3;
use rayon::prelude::*;
use relume_bake::brdf;
use relume_bake::bundle;
use relume_bake::compress::statistics::median;
use relume_bake::error::Result;
use relume_bake::guided;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::transfer_images::held_out::{
    OnBases, SPACING, editable_coefficients, one_pixel_in,
};
use relume_bake::methods::transfer_images::{METHOD, NAME, space_for};
use relume_bake::trace::gather::{Gather, GatherPath};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::path::PathTracer;
use relume_bake::trace::reference::radiance_of;
use relume_bake::trace::world::World;
use relume_bake::unfinished::Leftover;
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;

/// Numbers of bases that are tried on the bundle's paths, besides its own.
const BASES: [usize; 8] = [2, 3, 4, 5, 6, 8, 12, 16];
/// Samples a pixel of bakes, and of the truth.
const BAKES: [u32; 3] = [64, 256, 1024];
const TRUTH: u32 = 1024;

/// Images at some pixels, by state.
type Images = Vec<Vec<Rgb>>;

/// Some pixels of the states of a scene.
struct Film<'a> {
    scene: &'a Scene,
    world: World,
    states: Vec<Scene>,
    pixels: Vec<u32>,
}

impl Film<'_> {
    /// The path tracer's images.
    fn traced(&self, seed: u64, reflections: u32) -> Images {
        let image = |state: &Scene| {
            let lights = Lights::new(state, &self.world);
            let tracer = PathTracer::new(state, &self.world, &lights, SIZE, reflections, seed);
            let pixel = |pixel: &u32| {
                let mut sum = DVec3::ZERO;
                tracer.pixel(*pixel, TRUTH, |radiance| sum += radiance.as_dvec3());
                (sum / f64::from(TRUTH)).as_vec3().to_array()
            };
            self.pixels.par_iter().map(pixel).collect()
        };
        self.states.iter().map(image).collect()
    }

    /// Means of what `radiance` makes of the paths of a bake of so many samples, in each state.
    fn gathered(
        &self,
        samples: u32,
        radiance: impl Fn(usize, &GatherPath) -> DVec3 + Sync,
    ) -> Result<Images> {
        let lights = Lights::new(self.scene, &self.world);
        let reflections = self.scene.reflections;
        let paths = guided::Settings { size: SIZE, samples, reflections, seed: 0, target: None };
        let gather = guided::gather(self.scene, &self.world, &lights, &paths, &quiet())?;
        let pixel = |pixel: &u32| {
            let mut sums = vec![DVec3::ZERO; self.states.len()];
            gather.pixel(*pixel, samples, |path| {
                sums.iter_mut().enumerate().for_each(|(state, sum)| *sum += radiance(state, path))
            });
            sums.into_iter().map(|sum| (sum / f64::from(samples)).as_vec3().to_array()).collect()
        };
        let pixels: Vec<Vec<Rgb>> = self.pixels.par_iter().map(pixel).collect();
        let image = |state: usize| pixels.iter().map(|pixel| pixel[state]).collect();
        Ok((0..self.states.len()).map(image).collect())
    }

    fn materials(&self) -> Vec<Vec<Brdf>> {
        self.states.iter().map(|state| state.materials.iter().map(|m| m.brdf).collect()).collect()
    }

    /// With the analytic BRDF.
    fn analytic(&self, samples: u32) -> Result<Images> {
        let materials = self.materials();
        self.gathered(samples, |state, path| {
            radiance_of(path, |spot, angles| {
                brdf::evaluate(&materials[state][spot.material as usize], spot.albedo, angles)
            })
            .as_dvec3()
        })
    }

    /// With the first `bases` of `basis`.
    fn on_bases(&self, samples: u32, basis: &BrdfBasis, bases: usize) -> Result<Images> {
        let materials = self.materials();
        let coefficients: Vec<_> =
            materials.iter().map(|materials| editable_coefficients(self.scene, basis, materials)).collect();
        self.gathered(samples, |state, path| {
            let on = OnBases { basis, materials: &materials[state], coefficients: &coefficients[state] };
            radiance_of(path, |spot, angles| on.evaluate(bases, spot, angles)).as_dvec3()
        })
    }

    /// Of whole images.
    fn some(&self, images: Vec<Vec<Rgb>>) -> Images {
        images
            .into_iter()
            .map(|image| self.pixels.iter().map(|pixel| image[*pixel as usize]).collect())
            .collect()
    }

    /// Prints the errors of `images` to `truth`, state by state.
    fn print(&self, name: &str, images: &Images, truth: &Images) {
        let all = vec![true; self.pixels.len()];
        let errors: Vec<f64> =
            images.iter().zip(truth).map(|(image, truth)| percent(image, truth, &all)).collect();
        let cells: String = errors.iter().map(|error| format!(" {error:.3} |")).collect();
        println!("| {name} |{cells} {:.3} |", median(&errors));
    }
}

/// The pixels of `some` that show no light.
fn without_lights(scene: &Scene, world: &World, some: Vec<u32>) -> Vec<u32> {
    let lights = Lights::new(scene, world);
    let gather = Gather::new(scene, world, &lights, SIZE, 1, 0);
    let shows_none = |pixel: &u32| {
        let mut shows_none = true;
        gather.pixel(*pixel, SAMPLES, |path| shows_none &= !path.shows_light());
        shows_none
    };
    some.into_par_iter().filter(shows_none).collect()
}

/// Bakes the library's scene `name` with two reflections, which is what bases know, or goes on with what is
/// there, and prints its table.
pub fn ablation(name: &str) -> Result<()> {
    let scene = Scene { reflections: 2, ..library(name)? };
    let folder = bundle_folder(name);
    let asked = Asked::of_scene(&scene);
    bundle::run(&scene, &[(METHOD.new)(&asked, &scene)], SIZE, &folder, Leftover::Resume, 0, &quiet())?;
    let images = TransferImages::read_file(&folder.join("transfer-images.relume"))?;
    let stored_basis = BrdfBasis::read_file(&folder.join("brdf-basis.relume"))?;
    let (bases, samples) = (images.head.meta.bases as usize, images.head.meta.samples);

    let states = at_states(&scene)?;
    let world = World::new(&scene);
    let pixels = without_lights(&scene, &world, one_pixel_in(SPACING, SIZE));
    let film = Film { scene: &scene, world, states, pixels };
    println!("\n**transfer-images, {name}**: relative L2, %\n");
    println!(
        "| what is compared |{} median |",
        (0..STATES).map(|state| format!(" state {state} |")).collect::<String>()
    );
    println!("|---|{}", "---|".repeat(STATES as usize + 1));
    let (two, unlimited) = (film.traced(1, scene.reflections), film.traced(1, u32::MAX));
    film.print("noise of the truth: 1024 samples, other seeds", &film.traced(2, scene.reflections), &two);
    film.print("two reflections instead of all", &two, &unlimited);
    for samples in BAKES {
        film.print(&format!("paths: {samples} samples, to the path tracer"), &film.analytic(samples)?, &two);
    }
    let analytic = film.analytic(samples)?;
    let space = space_for(&scene, BASES[BASES.len() - 1])?;
    let basis = space.whole();
    for bases in BASES {
        film.print(
            &format!("{bases} bases, on the same paths"),
            &film.on_bases(samples, basis, bases)?,
            &analytic,
        );
    }
    let unrounded = film.on_bases(samples, &stored_basis, bases)?;
    let on_bases = |state: &Scene| -> Vec<Vec<Rgb>> {
        scene
            .vary
            .materials
            .iter()
            .filter_map(|m| stored_basis.coefficients_of(&state.materials[*m].brdf))
            .collect()
    };
    let stored = film.states.iter().map(|state| evaluate(&images, &on_bases(state))).collect();
    let stored = film.some(stored);
    film.print(&format!("rounded to halves, {bases} bases"), &stored, &unrounded);
    let shown = film.some(played(&scene, NAME, &folder)?);
    film.print("the player, to its meaning", &shown, &stored);
    film.print("the player, to the path tracer with two reflections", &shown, &two);
    film.print("the player, to the path tracer with all", &shown, &unlimited);
    Ok(())
}
