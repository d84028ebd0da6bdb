//! sphere-shadows, of spheres that are given: receivers on spheres, spheres of no size and of all sizes, many
//! and none, small and bright lights that move. Receivers inside spheres, a light on the cube's edges and who
//! blocks whom are in formats/tests/sphere_shadows.rs.

use crate::support::relative_l2;
use glam::Vec3;
use relume_formats::basis::diffuse::{self, NODES, blend, grid_normal};
use relume_formats::basis::{EquirectMap, cubemap, haar};
use relume_formats::evaluate::sphere_shadows::{
    Casters, Function, Levels, Own, Receiver, Spheres, light, lobe, neighbours, radiance,
};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::HaarTable;
use std::sync::LazyLock;

const TEXELS: usize = 6 * 32 * 32;

static TABLE: LazyLock<HaarTable> = LazyLock::new(HaarTable::bake);

/// The lobes of all nodes; those that no receiver needs are empty, which saves most of the time.
fn lobes(receivers: &[Receiver], terms: Option<usize>) -> Vec<Function> {
    let is_used = |node: usize| {
        receivers.iter().flat_map(|r| r.lobes).any(|(k, weight)| weight != 0.0 && k as usize == node)
    };
    (0..NODES)
        .map(|node| {
            if is_used(node) {
                lobe(diffuse::lobe(grid_normal(node)), terms)
            } else {
                lobe(vec![0.0; TEXELS], Some(6))
            }
        })
        .collect()
}

fn white() -> [Function; 3] {
    let mut plane = vec![1.0; TEXELS];
    haar::forward_cube(&mut plane, 32);
    light([plane.clone(), plane.clone(), plane], None)
}

fn receiver(position: Vec3, normal: Vec3) -> Receiver {
    Receiver { position, normal, lobes: blend(normal), object: 0, own: None }
}

fn spheres(now: Vec<[f32; 4]>) -> Casters {
    Casters { spheres: vec![Spheres { neighbours: neighbours(&now), now }], triangles: Vec::new() }
}

/// Radiance with everything kept, in parts of what there is without spheres.
fn open_share(receiver: Receiver, now: Vec<[f32; 4]>) -> f32 {
    let lobes = lobes(&[receiver], None);
    let at = |casters: &Casters| radiance(&[receiver], casters, &lobes, &white(), Levels::All, &TABLE)[0][0];
    at(&spheres(now)) / at(&Casters::default())
}

/// A reproducible stream of vectors in −1..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

/// Directions through the middle of faces, edges and corners of the cube, and some others.
fn directions() -> Vec<Vec3> {
    let signs = [-1.0, 0.0, 1.0];
    let all = signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(|z| Vec3::new(*x, *y, z))));
    all.filter(|v| *v != Vec3::ZERO)
        .chain([Vec3::new(0.3, -0.5, 0.8), Vec3::new(-0.97, 0.98, 0.2)])
        .map(Vec3::normalize)
        .collect()
}

/// Spheres that almost touch a receiver, from 10 cm down to nothing: behind it no shadow, before it the cone
/// that is left. On the very surface rounding decides.
#[test]
fn on_the_surface_of_a_sphere_of_another_object() {
    let radius = 0.7;
    for normal in directions() {
        for step in [1e-1, 1e-2, 1e-3, 1e-5, 1e-6, 0.0] {
            let at = |distance: f32| (normal * distance).extend(radius).to_array();
            // The sphere's pole touches the receiver from behind: all of it is below the horizon. On the very
            // surface rounding decides whether the receiver is inside, where all is dark.
            let away = open_share(receiver(Vec3::ZERO, normal), vec![at(-radius * (1.0 + step))]);
            assert!(away > 0.999 || (step == 0.0 && away.abs() < 1e-5), "{normal} {step}: {away}");
            // And from the front: what is left is the sine of a cone that closes, √(2·step), and texels at
            // its rim.
            let towards = open_share(receiver(Vec3::ZERO, normal), vec![at(radius * (1.0 + step))]);
            let expected = 1.0 - 1.0 / (1.0 + step).powi(2);
            assert!((towards - expected).abs() < 0.03, "{normal} {step}: {towards} for {expected}");
        }
    }
}

/// A cap takes sin²α of a white sky about the normal, wherever the edges and corners of the cube are.
#[test]
fn the_cube_has_no_preferred_directions() {
    for normal in directions() {
        for sine in [0.1f32, 0.3, 0.6, 0.9] {
            let share =
                open_share(receiver(Vec3::ZERO, normal), vec![(normal * 3.0).extend(3.0 * sine).to_array()]);
            let rim = 2.0 * sine * (1.0 - sine * sine).sqrt() / 16.0;
            // Half a texel's diagonal along the rim, and 2 % that a blend of lobes may be off where it is
            // dark and bright.
            assert!((share - (1.0 - sine * sine)).abs() < 0.71 * rim + 0.02, "{normal} {sine}: {share}");
        }
    }
}

/// Degenerate spheres: one without a size hides a texel at most, one far away nothing, and many at one place
/// what one hides.
#[test]
fn spheres_of_no_size_far_away_or_twice_at_one_place() {
    let up = receiver(Vec3::new(0.3, 0.0, -0.2), Vec3::Y);
    for radius in [0.0, f32::MIN_POSITIVE, 1e-30, 1e-9, 1e-4] {
        for centre in [Vec3::new(0.31, 0.5, 0.4), Vec3::new(10.0, 1e-3, 0.0), Vec3::new(0.3, 1.0, -0.2)] {
            let share = open_share(up, vec![centre.extend(radius).to_array()]);
            // No texel's centre is hit but by chance; one texel is 1e-3 of the sky.
            assert!((share - 1.0).abs() < 1.5e-3, "{radius} at {centre}: {share}");
        }
    }
    for distance in [1e4, 1e10, 1e18] {
        let share = open_share(up, vec![[distance, distance, 0.3 * distance, 1.0]]);
        assert!((share - 1.0).abs() < 1.5e-3, "{distance}: {share}");
    }
    let one = vec![[0.4, 1.0, 0.3, 0.5]];
    let many = vec![one[0]; 7];
    assert_eq!(open_share(up, one), open_share(up, many));
}

/// Many spheres on the fast path and the clear one: nothing overflows, all is between darkness and the open
/// sky, and own spheres are left out alike.
#[test]
fn a_thousand_spheres() {
    let mut random = Random(4);
    let now: Vec<[f32; 4]> =
        (0..1000).map(|_| (random.vector() * 3.0).extend(0.05 + 0.05 * random.next()).to_array()).collect();
    let sets = spheres(now);
    let receivers: Vec<Receiver> = (0..48)
        .map(|k| {
            let own = (k % 2 == 0).then_some(Own { set: 0, sphere: 13 * k });
            Receiver { own, ..receiver(random.vector() * 3.0, random.vector().normalize()) }
        })
        .collect();
    let (lobes, white) = (lobes(&receivers, None), white());
    let clear = radiance(&receivers, &sets, &lobes, &white, Levels::All, &TABLE);
    let mut fast = vec![[f32::NAN; 3]; receivers.len()];
    Shading::new(&lobes, &white, Levels::All).radiance(&receivers, &sets, &TABLE, &mut fast);
    assert!(relative_l2(&fast, &clear) < 1e-5);
    assert!(clear.iter().all(|r| (-1e-5..1.03).contains(&r[0])), "{clear:?}");
    let mean = clear.iter().map(|r| r[0]).sum::<f32>() / 48.0;
    assert!((0.05..0.9).contains(&mean), "they block: {mean}");
}

/// A light of a single texel of its map turns slowly all around: where its shadow comes and goes it does so
/// over several frames, and the terms that are kept, other ones in every frame, do not flicker.
#[test]
fn a_light_of_one_texel_turns_without_flicker() {
    let (width, height) = (256, 128);
    let mut map = EquirectMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize] };
    map.texels[(45 * width + 100) as usize] = [1e4; 3];
    let sets = spheres(vec![[0.9, 1.1, 0.2, 0.4], [-0.7, 0.9, -0.8, 0.35], [0.1, 1.3, 1.1, 0.5]]);
    let receivers: Vec<Receiver> = [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.4), Vec3::new(-0.5, 0.0, 0.2)]
        .map(|at| receiver(at, Vec3::new(0.1, 1.0, -0.05).normalize()))
        .into();
    let lobes = lobes(&receivers, Some(200));
    let frame = |number: usize, sets: &Casters| {
        let texels = cubemap::from_equirect(&map, number as f32 * 0.25, 32);
        let mut planes: [Vec<f32>; 3] = std::array::from_fn(|c| texels.iter().map(|t| t[c]).collect());
        planes.iter_mut().for_each(|plane| haar::forward_cube(plane, 32));
        let mut out = vec![[0.0; 3]; receivers.len()];
        Shading::new(&lobes, &light(planes, Some(200)), Levels::Two)
            .radiance(&receivers, sets, &TABLE, &mut out);
        out.into_iter().map(|r| r[0]).collect::<Vec<f32>>()
    };
    let frames: Vec<Vec<f32>> = (0..1440).map(|k| frame(k, &sets)).collect();
    let brightest = (0..1440).step_by(30).map(|k| frame(k, &Casters::default())[0]).fold(0.0, f32::max);
    let (mut worst, mut shadowed, mut lit) = (0.0f32, 0, 0);
    for at in 0..receivers.len() {
        for k in 0..frames.len() {
            let (now, next) = (frames[k][at] / brightest, frames[(k + 1) % frames.len()][at] / brightest);
            assert!((-0.1..1.2).contains(&now), "frame {k}: {now}");
            worst = worst.max((next - now).abs());
            shadowed += usize::from(now < 0.2);
            lit += usize::from(now > 0.8);
        }
    }
    println!("largest change {worst}, {shadowed} frames in shadow, {lit} lit");
    assert!(shadowed > 100 && lit > 100, "{shadowed} {lit}");
    // The map's texel, interpolated, is a tent 2.8° wide: 0.25° move at most 0.25/1.4 of its light over the
    // edge of a shadow.
    assert!(worst < 0.25 / 1.4 + 0.02, "{worst}");
}

/// A scene a thousand times larger or smaller: the same shadows, exactly so with powers of two.
#[test]
fn a_thousand_times_larger_or_smaller() {
    let mut random = Random(9);
    let now: Vec<[f32; 4]> =
        (0..60).map(|_| (random.vector() * 2.0).extend(0.3 + 0.2 * random.next()).to_array()).collect();
    let receivers: Vec<Receiver> =
        (0..200).map(|_| receiver(random.vector() * 2.0, random.vector().normalize())).collect();
    let (lobes, white) = (lobes(&receivers, Some(200)), white());
    let shading = Shading::new(&lobes, &white, Levels::Two);
    let image = |scale: f32| {
        let sets = spheres(now.iter().map(|s| s.map(|x| x * scale)).collect());
        let receivers: Vec<Receiver> =
            receivers.iter().map(|r| Receiver { position: r.position * scale, ..*r }).collect();
        let mut out = vec![[0.0; 3]; receivers.len()];
        shading.radiance(&receivers, &sets, &TABLE, &mut out);
        out
    };
    for scale in [1e-3, 1e3] {
        // Coordinates round differently: a texel here and there, of 6144, changes sides.
        let error = relative_l2(&image(scale), &image(1.0));
        assert!(error < 1e-3, "{scale}: {error}");
    }
    assert_eq!(image(1024.0), image(1.0), "nothing rounds with powers of two");
}

/// A sun of 10⁵ and one of 10¹², the largest that a scene may have: light is linear, so each gives that many
/// times what a sun of 1 gives, and nothing overflows.
#[test]
fn a_sun_is_as_bright_as_it_is() {
    let receivers: Vec<Receiver> =
        directions().into_iter().map(|normal| receiver(0.1 * normal, normal)).collect();
    let lobes = lobes(&receivers, Some(200));
    let sets = spheres(vec![[0.9, 1.1, 0.2, 0.4], [-0.7, 0.9, -0.8, 0.35]]);
    let under = |brightness: f32| {
        let mut plane = vec![0.2 * brightness; TEXELS];
        plane[cubemap::texel_of(Vec3::new(0.3, 0.9, 0.2), 32)] = 1e5 * brightness;
        haar::forward_cube(&mut plane, 32);
        let mut out = vec![[0.0; 3]; receivers.len()];
        Shading::new(&lobes, &light([plane.clone(), plane.clone(), plane], Some(200)), Levels::Two)
            .radiance(&receivers, &sets, &TABLE, &mut out);
        out
    };
    let one = under(1.0);
    for brightness in [1e-5, 1e7] {
        let scaled: Vec<[f32; 3]> = under(brightness).iter().map(|r| r.map(|x| x / brightness)).collect();
        // Sums of a few hundred products in single precision.
        assert!(relative_l2(&scaled, &one) < 1e-5, "{brightness}");
    }
}

/// Few terms under a light of one texel: the light itself needs 16 coefficients, which are all kept, so what
/// is shown is the cut lobe at that texel. It is the same wrong factor at all receivers of one normal, a tint
/// and no pattern, and right with all terms.
#[test]
fn few_terms_tint_a_light_of_one_texel() {
    let normal = Vec3::new(0.2, 1.0, -0.1).normalize();
    let texel = cubemap::texel_of(Vec3::new(0.5, 0.7, 0.3), 32);
    let mut plane = vec![0.0; TEXELS];
    plane[texel] = 1.0;
    haar::forward_cube(&mut plane, 32);
    let receivers =
        [Vec3::ZERO, Vec3::new(3.0, 0.0, 1.0), Vec3::new(-2.0, 5.0, 8.0)].map(|at| receiver(at, normal));
    // A ball that hides another part of the sky from all of them.
    let sets = spheres(vec![[-90.0, 40.0, 0.0, 20.0]]);
    for terms in [Some(50), Some(100), Some(200), None] {
        let lobes = lobes(&receivers, terms);
        let light = light([plane.clone(), plane.clone(), plane.clone()], terms);
        // Levels I and II see means of visibility over 4 × 4 and 2 × 2 texels, all of them open or all
        // blocked here.
        let shown = radiance(&receivers, &sets, &lobes, &light, Levels::Two, &TABLE);
        let cut: f64 = blend(normal)
            .iter()
            .map(|(row, weight)| f64::from(*weight) * f64::from(at_texel(&lobes[*row as usize], texel)))
            .sum();
        let whole: f64 = blend(normal)
            .iter()
            .map(|(row, weight)| {
                f64::from(*weight)
                    * f64::from(at_texel(&lobe(diffuse::lobe(grid_normal(*row as usize)), None), texel))
            })
            .sum();
        println!("{terms:?}: {:.3} of the light", cut / whole);
        for shown in shown {
            assert!((f64::from(shown[0]) / cut - 1.0).abs() < 1e-4, "{terms:?}: {} for {cut}", shown[0]);
        }
        assert!(terms.is_some() || (cut / whole - 1.0).abs() < 1e-5);
    }
}

/// The sum of a function's kept terms at one texel.
fn at_texel(function: &Function, texel: usize) -> f32 {
    let mut plane = vec![0.0; TEXELS];
    function.terms().iter().for_each(|(index, value)| plane[*index as usize] = *value);
    haar::inverse_cube(&mut plane, 32);
    plane[texel]
}
