//! The plane under a bunny or a knot, whose spheres are fitted in several numbers, and the lights that it is looked
//! at under; shared with the example `exponentiation`.

use rayon::prelude::*;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, ProgressMode};
use relume_bake::methods::sphere_shadows::casters::{By, put};
use relume_bake::methods::sphere_shadows::errors::{Posed, shown_in};
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
use relume_formats::evaluate::sphere_shadows::Receiver;
use relume_formats::kinds::{SphereSet, SphereShadows};
use relume_formats::state::{Rgb, ShapeState, State};
use relume_scenes::{NamedMap, Scene};

/// Receivers along a side of the plane.
pub const SIDE: usize = 128;
/// Numbers of spheres.
pub const SPHERES: [u32; 4] = [32, 64, 96, 128];

/// A light as texels, and as coefficients.
pub struct Lit {
    /// Of its map.
    pub name: String,
    /// Of each channel, [6·32·32].
    pub texels: [Vec<f32>; 3],
    /// Their Haar coefficients.
    pub planes: [Vec<f32>; 3],
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
    pub fn sum(&self, rho: &[f32], blocked: &Bitmap) -> Rgb {
        let mut sums = [0.0f64; 3];
        for (texel, rho) in rho.iter().enumerate().filter(|(_, rho)| **rho != 0.0) {
            if blocked[texel / 32] >> (texel % 32) & 1 == 0 {
                (0..3).for_each(|c| sums[c] += f64::from(self.texels[c][texel]) * f64::from(*rho));
            }
        }
        sums.map(|sum| sum as f32)
    }
}

/// Relative L2 in per cent.
pub fn percent(x: &[Rgb], reference: &[Rgb]) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for (a, b) in x.as_flattened().iter().zip(reference.as_flattened()) {
        off += f64::from(a - b).powi(2);
        norm += f64::from(*b).powi(2);
    }
    100.0 * (off / norm).sqrt()
}

/// Mean FLIP of two images of the plane, shown so that without blockers it would be at 80 % of white
/// (luminance).
pub fn flip(x: &[Rgb], reference: &[Rgb], open: Rgb) -> f64 {
    let gain = 0.8 / (0.2126 * open[0] + 0.7152 * open[1] + 0.0722 * open[2]);
    mean_flip(&displayed(x, gain), &displayed(reference, gain), [SIDE as u32; 2])
}

/// The texels that the mesh of the scene blocks for each vertex in `vertices`, by a ray to the centre of each
/// that has a value in its lobe.
pub fn blocked_by_mesh(
    scene: &Scene,
    vertices: &[usize],
    rho: impl Fn(usize) -> Vec<f32> + Sync,
) -> Vec<Bitmap> {
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
pub struct Prepared {
    /// What to call it.
    pub title: String,
    /// The scene, an object and the plane.
    pub scene: Scene,
    /// Vertices of the plane, behind those of the object.
    pub plane: Vec<usize>,
    /// Lobes, and that the object casts by spheres and the plane not at all.
    pub shadows: SphereShadows,
    /// The object's, one of each of [`SPHERES`].
    sets: Vec<SphereSet>,
}

fn prepare(name: &str, title: &str, state: &State) -> Result<Prepared> {
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
    Ok(Prepared { title: title.to_owned(), shadows, scene, plane, sets })
}

impl Prepared {
    /// A receiver's lobe by texels, blended as the product has it.
    pub fn rho(&self, receiver: &Receiver) -> Vec<f32> {
        let mut rho = vec![0.0; 6144];
        for (row, weight) in receiver.lobes.iter().filter(|(_, weight)| *weight != 0.0) {
            rho.iter_mut().zip(self.shadows.lobe(*row as usize)).for_each(|(sum, c)| *sum += weight * c);
        }
        inverse_cube(&mut rho, 32);
        // What the inverse leaves of zeros.
        rho.iter_mut().filter(|r| r.abs() < 1e-8).for_each(|r| *r = 0.0);
        rho
    }

    /// `vertices` of the scene with the spheres of set `number`.
    ///
    /// # Errors
    /// If a sphere cannot follow.
    pub fn posed(&self, number: usize, vertices: &[usize]) -> Result<Posed> {
        shown_in(
            (&self.scene, &self.scene),
            vertices,
            &self.shadows,
            std::slice::from_ref(&self.sets[number]),
        )
    }
}

/// The scene called `name`, if it is one of the two, and its lights.
///
/// # Errors
/// If it is not, or is not there.
pub fn prepared(name: Option<&str>) -> Result<(Prepared, Vec<Lit>)> {
    match name {
        Some("bunny-shadow") => bunny(),
        Some("knot-twist") => knot(),
        _ => Err(BakeError::invalid(&Place::file("SCENE"), "give bunny-shadow or knot-twist")),
    }
}

fn bunny() -> Result<(Prepared, Vec<Lit>)> {
    let prepared = prepare("bunny-shadow", "bunny-shadow", &State::default())?;
    let maps: Vec<&NamedMap> =
        prepared.scene.environment.iter().flat_map(|e| [&e.map].into_iter().chain(&e.others)).collect();
    let named = |name: &str| maps.iter().find(|m| m.name.ends_with(name)).map(|m| Lit::new(name, &m.map));
    let lights = ["city.exr", "studio.exr", "sky.exr"].into_iter().filter_map(named).collect();
    Ok((prepared, lights))
}

fn knot() -> Result<(Prepared, Vec<Lit>)> {
    let twisted = State {
        shapes: [("knot".to_owned(), ShapeState { time_s: Some(1.3), ..ShapeState::default() })].into(),
        ..State::default()
    };
    let prepared = prepare("knot-twist", "knot-twist at 1.3 s", &twisted)?;
    let height = |y: u32| (0.5 - (y as f32 + 0.5) / 64.0).to_radians() * 180.0;
    let smooth = |i: u32| {
        let (elevation, azimuth) = (height(i / 128), std::f32::consts::TAU * (i % 128) as f32 / 128.0);
        let brighter = 0.6 + 0.4 * elevation.cos() * azimuth.cos();
        [brighter, brighter * (0.9 + 0.1 * elevation.sin()), 0.8 + 0.2 * elevation.sin()]
    };
    let smooth = EquirectMap { width: 128, height: 64, texels: (0..128 * 64).map(smooth).collect() };
    let sun = prepared.scene.environment.iter().map(|e| Lit::new("clear-sky, with a sun", &e.map.map));
    let lights = [Lit::new("a smooth sky", &smooth)].into_iter().chain(sun).collect();
    Ok((prepared, lights))
}
