//! Radiance under spheres against sums over texels, closed forms, and the rules of who blocks whom.

mod meshes;

use glam::Vec3;
use meshes::{NEVER, ball, by};
use relume_formats::basis::cap::Bitmap;
use relume_formats::basis::diffuse::{self, NODES, blend, grid_normal};
use relume_formats::basis::haar::{forward_cube, inverse_cube};
use relume_formats::basis::{EquirectMap, cubemap};
use relume_formats::evaluate::sphere_shadows::{
    Casters, Function, Levels, Own, Receiver, Spheres, blocked, light, lobe, neighbours, radiance,
};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::HaarTable;
use std::sync::LazyLock;

const TEXELS: usize = 6 * 32 * 32;

static TABLE: LazyLock<HaarTable> = LazyLock::new(HaarTable::bake);
/// Coefficients of the lobes of all nodes, and behind them that of +Y.
static LOBES: LazyLock<Vec<Vec<f32>>> =
    LazyLock::new(|| (0..NODES).map(grid_normal).chain([Vec3::Y]).map(diffuse::lobe).collect());
/// The row of +Y.
const UP: [(u32, f32); 4] = [(NODES as u32, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];

/// A reproducible stream of numbers in 0..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// Texels of a sky that differ by a hundredfold.
fn sky(random: &mut Random) -> [Vec<f32>; 3] {
    std::array::from_fn(|_| (0..TEXELS).map(|_| 10.0f32.powf(random.next() * 2.0 - 1.0)).collect())
}

fn lit(mut texels: [Vec<f32>; 3], terms: Option<usize>) -> [Function; 3] {
    texels.iter_mut().for_each(|channel| forward_cube(channel, 32));
    light(texels, terms)
}

fn lobes(terms: Option<usize>) -> Vec<Function> {
    LOBES.iter().map(|coefficients| lobe(coefficients.clone(), terms)).collect()
}

fn spheres(now: Vec<[f32; 4]>) -> Spheres {
    Spheres { neighbours: neighbours(&now), now }
}

fn only_spheres(spheres: Vec<Spheres>) -> Casters {
    Casters { spheres, triangles: Vec::new() }
}

fn scene(random: &mut Random) -> Casters {
    let mut sphere = |_| {
        let centre = random.vector() * 2.0;
        [centre.x, centre.y, centre.z, 0.05 + 0.4 * random.next()]
    };
    only_spheres([12, 7].map(|count| spheres((0..count).map(&mut sphere).collect())).into())
}

fn receivers(random: &mut Random, count: usize) -> Vec<Receiver> {
    (0..count)
        .map(|k| {
            let normal = random.vector().normalize();
            let own = (k % 3 == 0).then_some(Own { set: k as u32 / 3 % 2, sphere: k as u32 % 7 });
            Receiver {
                position: random.vector() * 2.0,
                normal,
                lobes: blend(normal),
                object: k as u32 % 3,
                own,
            }
        })
        .collect()
}

fn up(position: Vec3) -> Receiver {
    Receiver { position, normal: Vec3::Y, lobes: UP, object: 0, own: None }
}

fn is_blocked(bitmap: &Bitmap, texel: usize) -> bool {
    bitmap[texel / 32] >> (texel % 32) & 1 == 1
}

/// Σ L·ρ̃ over the texels that are not blocked, in f64.
fn pixel_sum(receiver: &Receiver, casters: &Casters, sky: &[Vec<f32>; 3]) -> [f64; 3] {
    let bitmap = blocked(receiver, casters);
    let mut rho = vec![0.0f64; TEXELS];
    for (row, weight) in receiver.lobes {
        rho.iter_mut()
            .zip(&LOBES[row as usize])
            .for_each(|(sum, c)| *sum += f64::from(weight) * f64::from(*c));
    }
    inverse_cube(&mut rho, 32);
    let visible = |texel: &usize| !is_blocked(&bitmap, *texel);
    std::array::from_fn(|c| (0..TEXELS).filter(visible).map(|i| f64::from(sky[c][i]) * rho[i]).sum())
}

#[test]
fn with_everything_kept_it_is_the_sum_over_texels() {
    let mut random = Random(3);
    let (sky, sets) = (sky(&mut random), scene(&mut random));
    let receivers = receivers(&mut random, 40);
    let ours = radiance(&receivers, &sets, &lobes(None), &lit(sky.clone(), None), Levels::All, &TABLE);
    let mut dark = 0;
    for (receiver, ours) in receivers.iter().zip(ours) {
        let (truth, open) =
            (pixel_sum(receiver, &sets, &sky), pixel_sum(receiver, &Casters::default(), &sky));
        dark += usize::from(truth[0] < 0.9 * open[0]);
        for c in 0..3 {
            // A few thousand terms in f32, of either sign, against what they would sum to without blockers.
            assert!(
                (f64::from(ours[c]) - truth[c]).abs() < 1e-5 * open[c],
                "{} {} {}",
                ours[c],
                truth[c],
                open[c]
            );
        }
    }
    assert!(dark > 10, "spheres block: {dark}");
}

#[test]
fn fewer_terms_and_levels_are_near_and_more_are_nearer() {
    let mut random = Random(8);
    // Light such as maps have: smooth, with one strong window.
    let window = Vec3::new(0.3, 0.8, 0.5).normalize();
    let texel = |i: usize| {
        let d = cubemap::direction(i / 1024, 32, (i % 32) as f64 + 0.5, (i / 32 % 32) as f64 + 0.5).as_vec3();
        0.5 + 0.3 * d.y + if d.dot(window) > 0.97 { 30.0 } else { 0.0 }
    };
    let sky: [Vec<f32>; 3] =
        std::array::from_fn(|c| (0..TEXELS).map(|i| texel(i) * (1.0 + 0.2 * c as f32)).collect());
    let (sets, receivers) = (scene(&mut random), receivers(&mut random, 60));
    let error = |terms: Option<usize>, levels: Levels| {
        let ours = radiance(&receivers, &sets, &lobes(terms), &lit(sky.clone(), terms), levels, &TABLE);
        let (mut off, mut norm) = (0.0, 0.0);
        for (receiver, ours) in receivers.iter().zip(ours) {
            let truth = pixel_sum(receiver, &sets, &sky);
            off += (0..3).map(|c| (f64::from(ours[c]) - truth[c]).powi(2)).sum::<f64>();
            norm += truth.iter().map(|t| t * t).sum::<f64>();
        }
        (off / norm).sqrt()
    };
    let figures: Vec<[f64; 3]> = [Some(50), Some(100), Some(200), None]
        .map(|terms| [Levels::One, Levels::Two, Levels::All].map(|levels| error(terms, levels)))
        .into();
    println!("relative L2, 50/100/200/all terms x I/II/All: {figures:.4?}");
    assert!(figures[2][1] < figures[0][1], "terms help");
    assert!(figures[3][1] < figures[3][0] && figures[3][2] < 1e-5, "levels help");
    assert!(figures[2][1] < 0.06);
}

#[test]
fn without_spheres_there_is_no_shadow() {
    let mut random = Random(5);
    let sky = sky(&mut random);
    let receivers = receivers(&mut random, 12);
    for levels in [Levels::One, Levels::Two, Levels::All] {
        // V is its scaling function alone, which all levels have.
        let ours =
            radiance(&receivers, &Casters::default(), &lobes(None), &lit(sky.clone(), None), levels, &TABLE);
        for (receiver, ours) in receivers.iter().zip(ours) {
            let truth = pixel_sum(receiver, &Casters::default(), &sky);
            assert!((0..3).all(|c| (f64::from(ours[c]) / truth[c] - 1.0).abs() < 1e-5));
        }
    }
}

/// A cap of half angle α at θ from the zenith, all above the horizon, takes sin²α·cos θ of a white sky.
#[test]
fn a_sphere_takes_its_share_of_a_white_sky() {
    let white = lit(std::array::from_fn(|_| vec![1.0; TEXELS]), None);
    let lobes = lobes(None);
    let at = Vec3::new(1.0, 2.0, -2.0);
    let open = |sine: f32, theta: f32, phi: f32| {
        let v = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        let sets = only_spheres(vec![spheres(vec![(at + 5.0 * v).extend(5.0 * sine).to_array()])]);
        radiance(&[up(at)], &sets, &lobes, &white, Levels::All, &TABLE)[0][0]
            - (1.0 - sine * sine * theta.cos())
    };
    let mut random = Random(21);
    for sine in [0.1f32, 0.2, 0.35, 0.5, 0.7, 0.9, 0.99] {
        // Texels, 1/16 wide at the zenith, are whole or not at all: wrong are those within half a diagonal of
        // the rim, which is 2·sin α·cos α of the sky long.
        let rim = 2.0 * sine * (1.0 - sine * sine).sqrt() / 16.0;
        let zenith = open(sine, 0.0, 0.0);
        assert!(
            zenith.abs() < std::f32::consts::FRAC_1_SQRT_2 * rim + 1e-5,
            "sin α = {sine}: {zenith}, rim {rim}"
        );
        // In the mean over many places they cancel.
        let room = (0.5 * std::f32::consts::PI - sine.asin()).min(0.3);
        let mean = (0..200)
            .map(|_| open(sine, room * random.next(), std::f32::consts::TAU * random.next()))
            .sum::<f32>()
            / 200.0;
        println!("sin α = {sine}: at the zenith {zenith}, mean {mean}, rim {rim}");
        assert!(mean.abs() < 0.03 * rim + 1e-5, "sin α = {sine}: {mean}, rim {rim}");
    }
}

#[test]
fn who_blocks_whom() {
    let full = [u32::MAX; 192];
    let ball = |x: f32, r: f32| [x, 1.0, 0.0, r];
    // Three in a row: the first two overlap, the third stands alone.
    let row = spheres(vec![ball(0.0, 0.6), ball(1.0, 0.6), ball(3.0, 0.6)]);
    assert_eq!(row.neighbours, [vec![0, 1], vec![0, 1], vec![2]]);
    let at = |position: Vec3, own: Option<(u32, u32)>| Receiver {
        own: own.map(|(set, sphere)| Own { set, sphere }),
        ..up(position)
    };
    let only = |which: &[usize], position| {
        let now = which.iter().map(|k| row.now[*k]).collect();
        blocked(&at(position, None), &only_spheres(vec![Spheres { now, neighbours: vec![] }]))
    };
    let sets = only_spheres(vec![row.clone()]);
    let below = Vec3::new(0.0, 0.0, 0.0);
    assert_eq!(blocked(&at(below, None), &sets), only(&[0, 1, 2], below));
    assert_eq!(
        blocked(&at(below, Some((0, 0))), &sets),
        only(&[2], below),
        "its own and the one that overlaps it"
    );
    assert_eq!(blocked(&at(below, Some((0, 2))), &sets), only(&[0, 1], below));
    assert_eq!(blocked(&at(below, Some((1, 0))), &sets), only(&[0, 1, 2], below), "of another object");
    let inside = Vec3::new(0.0, 1.2, 0.0);
    assert_eq!(blocked(&at(inside, None), &sets), full, "inside a sphere of another object");
    assert_eq!(
        blocked(&at(inside, Some((0, 2))), &sets),
        only(&[1], inside),
        "its own object's sphere that holds it is left out"
    );
    let dark = radiance(
        &[at(inside, None)],
        &sets,
        &lobes(None),
        &lit(sky(&mut Random(1)), None),
        Levels::All,
        &TABLE,
    );
    assert_eq!(dark, [[0.0; 3]]);
    // Neighbours are those of rest, wherever the spheres are now.
    let moved =
        only_spheres(vec![Spheres { now: vec![ball(0.0, 0.6), ball(5.0, 0.6), ball(0.5, 0.6)], ..row }]);
    assert_eq!(
        blocked(&at(below, Some((0, 0))), &moved),
        blocked(&at(below, None), &only_spheres(vec![spheres(vec![ball(0.5, 0.6)])]))
    );
}

#[test]
fn spheres_below_the_horizon_do_not_count() {
    let low = only_spheres(vec![spheres(vec![[0.3, -0.5, 0.0, 0.499]])]);
    assert_eq!(blocked(&up(Vec3::ZERO), &low), [0; 192]);
    let higher = only_spheres(vec![spheres(vec![[0.3, -0.5, 0.0, 0.501]])]);
    assert_ne!(blocked(&up(Vec3::ZERO), &higher), [0; 192]);
}

#[test]
fn neither_order_nor_repetition_of_spheres_matters() {
    let mut random = Random(11);
    let sets = scene(&mut random);
    let reversed = sets
        .spheres
        .iter()
        .rev()
        .map(|set| Spheres { now: set.now.iter().rev().copied().collect(), neighbours: vec![] })
        .collect();
    let twice = sets
        .spheres
        .iter()
        .map(|set| Spheres { now: [&set.now[..], &set.now[..]].concat(), neighbours: vec![] })
        .collect();
    let [reversed, twice] = [only_spheres(reversed), only_spheres(twice)];
    for receiver in receivers(&mut random, 50) {
        let receiver = Receiver { own: None, ..receiver };
        let bitmap = blocked(&receiver, &sets);
        assert_eq!(bitmap, blocked(&receiver, &reversed));
        assert_eq!(bitmap, blocked(&receiver, &twice));
    }
}

/// A small light that turns over an edge of the cube: the cosine at which an open receiver sees it is the
/// right one, and changes little per step.
#[test]
fn a_small_light_moves_smoothly_over_the_edges_of_the_cube() {
    let (width, height) = (256, 128);
    let mut map = EquirectMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize] };
    // 2 × 2 texels above the middle.
    (0..4).for_each(|k| map.texels[((60 + k / 2) * width + 100 + k % 2) as usize] = [1000.0; 3]);
    let normal = Vec3::new(-0.6, 0.64, -0.48);
    let receiver = Receiver { position: Vec3::ZERO, normal, lobes: blend(normal), object: 0, own: None };
    let (lobes, solid_angles) = (lobes(None), cubemap::solid_angles(32));
    let cosine = |turn: f32| {
        let texels = cubemap::from_equirect(&map, turn.to_degrees(), 32);
        let power: f64 =
            texels.iter().zip(solid_angles.iter().cycle()).map(|(t, w)| f64::from(t[0]) * w).sum();
        let planes = std::array::from_fn(|c| texels.iter().map(|t| t[c]).collect());
        radiance(&[receiver], &Casters::default(), &lobes, &lit(planes, None), Levels::Two, &TABLE)[0][0]
            * std::f32::consts::PI
            / power as f32
    };
    let truth = |turn: f32| {
        let (phi, theta) =
            (std::f32::consts::TAU * (101.0 / 256.0 - 0.5) - turn, std::f32::consts::PI * 61.0 / 128.0);
        normal.dot(Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()))
    };
    let step = 0.5f32.to_radians();
    // 60° cross one edge, where the light passes from −X to −Z or back.
    let cosines: Vec<f32> = (0..120).map(|k| cosine(k as f32 * step)).collect();
    let off = (0..120).map(|k| (cosines[k] - truth(k as f32 * step)).abs()).fold(0.0, f32::max);
    let jump = cosines.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    println!("off by up to {off}, steps up to {jump}");
    // A texel's own cosine is used for all of it: half a texel, 1/32 of the cosine at most where it changes
    // fastest.
    assert!(off < 0.025, "{off}");
    // The light, as wide as two texels of the map and their interpolation, 2.8°, leaves a texel over at least
    // half of its width; texels differ by 1/16.
    assert!(jump < 0.5 / 1.4 / 16.0, "{jump}");
}

/// The vector code at every setting, on groups that are full and one that is not.
#[test]
fn the_fast_path_equals_the_meaning() {
    let mut random = Random(77);
    for round in 0..4 {
        let (sky, mut sets) = (sky(&mut random), scene(&mut random));
        sets.triangles = ball(Vec3::new(0.3, 0.2, -0.5), 0.4, by(0.0, NEVER));
        let mut receivers = receivers(&mut random, 55);
        receivers[50].position = Vec3::from_slice(&sets.spheres[1].now[2]);
        (0..20).for_each(|k| receivers[k] = Receiver { own: receivers[k].own, ..up(receivers[k].position) });
        for terms in [Some(50), Some(200), None] {
            let (lobes, light) = (lobes(terms), lit(sky.clone(), terms));
            let open = radiance(&receivers, &Casters::default(), &lobes, &light, Levels::All, &TABLE);
            for levels in [Levels::One, Levels::Two, Levels::All] {
                let truth = radiance(&receivers, &sets, &lobes, &light, levels, &TABLE);
                let mut ours = vec![[f32::NAN; 3]; receivers.len()];
                Shading::new(&lobes, &light, levels).radiance(&receivers, &sets, &TABLE, &mut ours);
                for (k, c) in (0..receivers.len()).flat_map(|k| (0..3).map(move |c| (k, c))) {
                    // The same sums in another order: a few thousand roundings.
                    let off = (ours[k][c] - truth[k][c]).abs() / open[k][c];
                    assert!(
                        off < 1e-5,
                        "{round} {terms:?} {levels:?} receiver {k}: {} {}",
                        ours[k][c],
                        truth[k][c]
                    );
                }
            }
        }
    }
}
