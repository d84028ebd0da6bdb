//! Texels of cubes against rays through them one by one, with every kind of instructions.

use super::*;
use crate::trace::wide::tests::{Random, scenes, wide};

/// Points to look from, with their horizons: anywhere, and on triangles as vertices have it.
fn eyes(triangles: &[[Vec3A; 3]], random: &mut Random) -> Vec<(Vec3A, Option<Vec3A>)> {
    let mut eyes: Vec<_> =
        (0..4).map(|k| (random.point(), (k % 2 == 0).then(|| random.direction()))).collect();
    for triangle in triangles.iter().step_by(triangles.len() / 5 + 1) {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a).normalize_or(Vec3A::Y);
        eyes.push((a + 1e-4 * normal, Some(normal)));
        eyes.push(((a + b + c) / 3.0, None));
    }
    eyes
}

#[test]
fn texels_are_those_that_rays_see_and_what_is_behind_them_is_what_rays_hit() {
    let mut random = Random(11);
    let (mut seen, mut hidden) = (0, 0);
    for (number, triangles) in scenes().into_iter().enumerate() {
        let mut wide = wide(&triangles);
        let order = wide.order.clone();
        for (at, (origin, horizon)) in eyes(&triangles, &mut random).into_iter().enumerate() {
            let rays = TexelRays::centres([32, 64, 40][(number + at) % 3]);
            let n = rays.face_size();
            let asked = horizon.map_or_else(|| TexelSet::of(n, |_| true), |normal| rays.above(normal));
            // As a material with holes has it: some triangles do not count.
            for leaves_out in [u32::MAX, 3] {
                let counts = |at: u32| order[at as usize] % 4 != leaves_out;
                let nearest = |texel: usize| {
                    let hit = wide.nearest(origin, rays.directions()[texel], |at, _| counts(at));
                    hit.filter(|_| asked.has(texel / n, texel % n))
                };
                let hits: Vec<_> = (0..FACES * n * n).map(nearest).collect();
                let expected = TexelSet::of(n, |i| asked.has(i / n, i % n) && hits[i].is_none());
                let hits: Vec<_> =
                    hits.into_iter().map(|hit| hit.map(|hit| (hit.number(), hit.hit))).collect();
                wide.with_all_kernels(|wide, kernel| {
                    let (mut found, what) = (asked.clone(), format!("scene {number}, {kernel}, {origin}"));
                    let eye = Eye { origin, horizon, rays: &rays, within: None };
                    wide.see(eye, &mut found, |at| !counts(at), |at, _| counts(at));
                    assert!(found == expected, "{what}, without {leaves_out}");
                    let behind = wide.nearest_of_texels(eye, &asked, |at| !counts(at), |at, _| counts(at));
                    let behind = behind.into_iter().map(|hit| hit.map(|hit| (hit.number(), hit.hit)));
                    assert!(behind.eq(hits.iter().copied()), "{what}, without {leaves_out}: what is nearest");
                });
                seen += expected.count();
                hidden += asked.count() - expected.count();
            }
        }
    }
    println!("{seen} seen, {hidden} hidden");
    assert!(seen > 100_000 && hidden > 100_000, "{seen} seen, {hidden} hidden");
}

#[test]
fn what_is_above_a_horizon_is_what_its_cosine_says() {
    let mut random = Random(13);
    let axes = [Vec3A::Y, Vec3A::NEG_X, Vec3A::new(0.0, 0.6, -0.8), Vec3A::ONE.normalize()];
    for (number, normal) in axes.into_iter().chain((0..60).map(|_| random.direction())).enumerate() {
        let rays = TexelRays::centres([32, 64, 40, 192][number % 4]);
        let above = TexelSet::of(rays.face_size(), |texel| normal.dot(rays.directions()[texel]) > 0.0);
        assert!(rays.above(normal) == above, "{normal}");
    }
}
