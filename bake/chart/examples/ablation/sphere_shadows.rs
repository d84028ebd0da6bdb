//! sphere-shadows: suns, texels, lobes, casters, terms, levels.

use crate::steps::{Drawing, Film, Steps, at_states, bundle_folder, exact, library, played, quiet};
use crate::suns::{Parted, sum};
use rayon::prelude::*;
use relume_bake::bundle;
use relume_bake::error::Result;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::sphere_shadows::errors::{Posed, lobes, shown_in};
use relume_bake::methods::sphere_shadows::{METHOD, NAME};
use relume_bake::trace::receivers;
use relume_bake::trace::spans::{Eye, TexelRays, TexelSet};
use relume_bake::trace::world::World;
use relume_bake::unfinished::Leftover;
use relume_formats::basis::cap::Bitmap;
use relume_formats::basis::diffuse;
use relume_formats::basis::haar::inverse_cube;
use relume_formats::basis::two_level::SIDE;
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::light as coefficients_of;
use relume_formats::evaluate::sphere_shadows::{Detail, Levels, Receiver, light};
use relume_formats::fast::sphere_shadows::{Shading, bitmaps};
use relume_formats::kinds::manifest::sphere_set_file;
use relume_formats::kinds::sphere_shadows::{Casts, ShadowObject};
use relume_formats::kinds::{SphereSet, SphereShadows};
use relume_formats::state::Rgb;
use relume_scenes::Scene;

/// A scene in a state, and what the bundle makes of it.
struct InState {
    scene: Scene,
    posed: Posed,
    light: Parted,
    /// Of the light without suns.
    planes: [Vec<f32>; 3],
    texels: [Vec<f32>; 3],
    /// By vertex, the texels that the meshes block.
    by_mesh: Vec<Bitmap>,
}

/// How a receiver reflects.
#[derive(Clone, Copy)]
enum Lobe {
    /// As its normal says.
    Exact,
    /// Blended from the grid of normals, as the product has it.
    Blended,
}

impl InState {
    /// `sets` are those of the objects that cast by them, `rest` is the scene at rest.
    fn new(rest: &Scene, scene: Scene, shadows: &SphereShadows, sets: &[SphereSet]) -> Result<Self> {
        let all: Vec<usize> = (0..shadows.rows.len()).collect();
        let posed = shown_in((rest, &scene), &all, shadows, sets)?;
        let light = Parted::new(&scene)?;
        let planes = coefficients_of(&light.rest, &light.look, SIDE);
        let mut texels = planes.clone();
        texels.iter_mut().for_each(|plane| inverse_cube(plane, SIDE));
        let (world, tracing) = (World::new(&scene), receivers::receivers(&scene));
        let centres = TexelRays::centres(SIDE);
        let of = |(receiver, tracing): (&Receiver, &receivers::Receiver)| {
            let lobes = [Lobe::Exact, Lobe::Blended].map(|lobe| lobe.of(receiver, shadows));
            let mut seen = TexelSet::of(SIDE, |texel| lobes.iter().any(|lobe| lobe[texel] != 0.0));
            let eye = Eye { origin: tracing.origin, horizon: None, rays: &centres, within: None };
            world.see(eye, &mut seen);
            let blocked = |row: usize, x: usize| u32::from(!seen.has(row, x)) << x;
            std::array::from_fn(|row| (0..SIDE).fold(0, |bits, x| bits | blocked(row, x)))
        };
        let by_mesh = posed.receivers.par_iter().zip(&tracing).map(of).collect();
        Ok(Self { posed, light, planes, texels, by_mesh, scene })
    }

    /// Σ L·ρ̃ over the texels that are not blocked.
    fn sum(&self, lobe: Lobe, shadows: &SphereShadows, blocked: &[Bitmap]) -> Vec<Rgb> {
        let of = |(receiver, blocked): (&Receiver, &Bitmap)| {
            let mut sums = [0.0f64; 3];
            let open = |texel: usize| blocked[texel / 32] >> (texel % 32) & 1 == 0;
            for (texel, rho) in lobe
                .of(receiver, shadows)
                .iter()
                .enumerate()
                .filter(|(texel, rho)| **rho != 0.0 && open(*texel))
            {
                (0..3).for_each(|c| sums[c] += f64::from(self.texels[c][texel]) * f64::from(*rho));
            }
            sums.map(|sum| sum as f32)
        };
        self.posed.receivers.par_iter().zip(blocked).map(of).collect()
    }
}

impl Lobe {
    /// ρ̃ by texels.
    fn of(self, receiver: &Receiver, shadows: &SphereShadows) -> Vec<f32> {
        let mut rho = match self {
            Self::Exact => diffuse::lobe(receiver.normal),
            Self::Blended => {
                let mut rho = vec![0.0; shadows.lobe(0).len()];
                for (row, weight) in receiver.lobes.iter().filter(|(_, weight)| *weight != 0.0) {
                    rho.iter_mut().zip(shadows.lobe(*row as usize)).for_each(|(sum, c)| *sum += weight * c);
                }
                rho
            }
        };
        inverse_cube(&mut rho, SIDE);
        // What the inverse leaves of zeros.
        rho.iter_mut().filter(|r| r.abs() < 1e-8).for_each(|r| *r = 0.0);
        rho
    }
}

/// Bakes the library's scene `name`, or goes on with what is there, and prints its tables.
pub fn ablation(name: &str) -> Result<()> {
    let scene = library(name)?;
    let folder = bundle_folder(name);
    let method = (METHOD.new)(&Asked::of_scene(&scene), &scene);
    bundle::run(&scene, &[method], scene.size, &folder, Leftover::Resume, 0, &quiet())?;
    let shadows = SphereShadows::read_file(&folder.join("sphere-shadows.relume"))?;
    let casting = shadows.meta.objects.iter().filter(|object| object.casts == Casts::Spheres);
    let read = |object: &ShadowObject| SphereSet::read_file(&folder.join(sphere_set_file(&object.name)));
    let sets = casting.map(read).collect::<relume_formats::Result<Vec<SphereSet>>>()?;
    let states = at_states(&scene)?
        .into_iter()
        .map(|state| InState::new(&scene, state, &shadows, &sets))
        .collect::<Result<Vec<_>>>()?;
    let drawings: Vec<Drawing> =
        states.iter().map(|state| Drawing::new(&state.scene, Film::Reference)).collect();
    let suns: Vec<Vec<Rgb>> =
        states.iter().map(|state| state.light.of_suns(&state.scene, Film::Reference)).collect();
    let drawn = |radiance: &dyn Fn(&InState) -> Vec<Rgb>| {
        let of = |(drawing, state): (&Drawing, &InState)| drawing.draw(&radiance(state));
        let rest = drawings.iter().zip(&states).map(of);
        rest.zip(&suns).map(|(rest, suns)| sum(&rest, suns)).collect::<Vec<_>>()
    };
    let scenes: Vec<Scene> = states.iter().map(|state| state.scene.clone()).collect();
    let mut steps = Steps::new(&scenes)?;
    let at_vertices =
        drawings.iter().zip(&scenes).map(|(drawing, scene)| drawing.draw(&exact(scene))).collect();
    let vertices = steps.push("exact radiance at vertices, drawn by the mesh", None, at_vertices);
    let apart = steps.push(
        "suns at every sample, only the rest at vertices",
        vertices,
        drawn(&|state| exact(&state.light.without_suns(&state.scene))),
    );
    let texels = steps.push(
        "light and visibility of 6 × 32 × 32 texels",
        apart,
        drawn(&|state| state.sum(Lobe::Exact, &shadows, &state.by_mesh)),
    );
    let grid = steps.push(
        "lobes from the grid of normals",
        texels,
        drawn(&|state| state.sum(Lobe::Blended, &shadows, &state.by_mesh)),
    );
    let by_casters = |state: &InState| {
        state.sum(Lobe::Blended, &shadows, &bitmaps(&state.posed.receivers, &state.posed.casters))
    };
    let casters = steps.push("what the bake casts by instead of whole meshes", grid, drawn(&by_casters));
    let whole = lobes(&shadows, None);
    let all_terms = |state: &InState| {
        state.posed.under(&Shading::new(&whole, &light(state.planes.clone(), None), Levels::All))
    };
    let wavelets = steps.push("wavelets, all terms", casters, drawn(&all_terms));
    let Detail { terms, levels } = Detail::of(&shadows.meta);
    let kept = lobes(&shadows, terms);
    let shown = |state: &InState| {
        state.posed.under(&Shading::new(&kept, &light(state.planes.clone(), terms), levels))
    };
    let as_baked =
        steps.push(&format!("{} terms, level {levels:?}", shadows.meta.terms), wavelets, drawn(&shown));
    let by_quarters = |state: &InState| {
        let rest = Drawing::new(&state.scene, Film::Quarters).draw(&shown(state));
        sum(&rest, &state.light.of_suns(&state.scene, Film::Quarters))
    };
    let quarters = steps.push("four samples a pixel", as_baked, states.iter().map(by_quarters).collect());
    steps.push("the player, suns by shadow maps", quarters, played(&scene, NAME, &folder)?);
    print(&steps, name, &scene, &drawings);
    Ok(())
}

/// Prints the table of all surfaces and that of each object.
fn print(steps: &Steps, name: &str, scene: &Scene, drawings: &[Drawing]) {
    let masks: Vec<&[bool]> = drawings.iter().map(|drawing| &drawing.shows_surface[..]).collect();
    steps.print(&format!("sphere-shadows, {name}, all surfaces"), &masks);
    let mut first = 0;
    for object in &scene.objects {
        let vertices = first..first + object.mesh.positions.len() as u32;
        first = vertices.end;
        let masks: Vec<Vec<bool>> = drawings.iter().map(|drawing| drawing.shows(vertices.clone())).collect();
        steps.print(
            &format!("sphere-shadows, {name}, `{}`", object.name),
            &masks.iter().map(|mask| &mask[..]).collect::<Vec<_>>(),
        );
    }
}
