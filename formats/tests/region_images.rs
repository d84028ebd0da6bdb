//! What `region-images` mean, by the sums of the thesis written out (eq. 4-35), wavelet by wavelet.

use crate::support::regions::region_images;
use crate::support::samples::{self, Random};
use relume_formats::basis::haar::{Wavelet, describe};
use relume_formats::evaluate::region_images::{Worn, coefficients_at, evaluate, region_means};
use relume_formats::kinds::region_images::{COVER, REGION_COUNT, REGIONS, RegionImages, Source};
use relume_formats::kinds::{BrdfBasis, region_images};
use relume_formats::state::{Brdf, Paint};

const SIDE: usize = region_images::planes::SIDE;

/// Of 40 × 7 texels, no two alike.
fn paint(random: &mut Random) -> Paint {
    let brdf = Brdf::BlinnPhong(random.blinn_phong());
    let mut paint = Paint::uniform(&brdf, [40, 7]);
    for texel in &mut paint.texels {
        let brdf = random.blinn_phong();
        *texel = [brdf.kd, brdf.ks, [brdf.shininess, 1.0 + 199.0 * random.unit(), 20.0]];
    }
    paint
}

/// A wavelet of a tile at a cell of it.
fn wavelet(index: usize, cell: usize) -> f64 {
    let (x, y) = (cell % SIDE, cell / SIDE);
    match describe(index, SIDE) {
        Wavelet::Scaling => 1.0 / SIDE as f64,
        Wavelet::Detail { level, m, i, j } => {
            let side = SIDE >> level;
            if x / side != i || y / side != j {
                return 0.0;
            }
            let sign = |at: usize| if at % side < side / 2 { 1.0 } else { -1.0 };
            let signs = [1.0, sign(x), sign(y), sign(x) * sign(y)][m];
            signs * f64::from(1 << level) / SIDE as f64
        }
    }
}

/// α of every row, by basis of the eye and channel.
fn alphas(images: &RegionImages, basis: &BrdfBasis, worn: &[Worn<'_>]) -> Vec<Vec<[f64; 3]>> {
    let head = &images.head;
    let mut weights = head.weights.iter();
    let mut of_row = |row: &region_images::Row| -> [f64; 3] {
        let c = |k: usize| match (row.source, row.source) {
            (Source::Fixed, _) => 1.0,
            (Source::Whole { material, basis: b }, _) => match worn[usize::from(material)] {
                Worn::Whole(brdf) => f64::from(basis.coefficients_of(brdf).unwrap()[usize::from(b)][k]),
                Worn::Painted(_) => panic!("no row of a whole is painted"),
            },
            (Source::Painted { .. }, _) => 0.0,
        };
        let mut alpha: [f64; 3] = std::array::from_fn(c);
        if let Source::Painted { material, basis: b } = row.source {
            let Worn::Painted(paint) = worn[usize::from(material)] else { panic!("it is painted") };
            let cover = &head.cover[usize::from(material) / 2];
            let means = region_means(basis, paint, cover).unwrap();
            for (region, weight) in weights.next().unwrap().iter().enumerate() {
                let mean = means.0[region * basis.bases() + usize::from(b)];
                (0..3).for_each(|k| alpha[k] += f64::from(weight.to_f32()) * f64::from(mean[k]));
            }
        }
        std::array::from_fn(|k| alpha[k] * f64::from(row.colour[k]) * f64::from(row.step))
    };
    head.rows.iter().map(|rows| rows.iter().map(&mut of_row).collect()).collect()
}

#[test]
fn pixels_are_the_sums_of_the_thesis() {
    for (seed, one_colour) in [(1, true), (2, false), (5, true)] {
        let random = &mut Random(seed);
        let basis = samples::basis(seed, 4, true);
        let images = region_images(seed, 4, one_colour, [37, 3]);
        let head = &images.head;
        let (first, last) = (paint(random), paint(random));
        let whole = Brdf::BlinnPhong(random.blinn_phong());
        let worn = [Worn::Painted(&first), Worn::Whole(&whole), Worn::Painted(&last)];
        let film = evaluate(&images, &basis, &worn).unwrap();

        let alphas = alphas(&images, &basis, &worn);
        let cells = head.planes().cells;
        let mut taps = head.taps.iter();
        let mut expected = vec![[0.0; 3]; film.len()];
        let mut sizes = vec![[0.0; 3]; film.len()];
        for (fragment, cell) in cells.iter().enumerate() {
            let class = usize::from(head.fragments.class[fragment]);
            let coefficients: Vec<[f64; 3]> = match worn.get(class) {
                None => vec![[1.0; 3]],
                Some(Worn::Whole(brdf)) => {
                    basis.coefficients_of(brdf).unwrap().iter().map(|c| c.map(f64::from)).collect()
                }
                Some(Worn::Painted(paint)) => {
                    let taps = taps.next().unwrap();
                    let all: f64 = taps.iter().map(|tap| f64::from(tap.weight)).sum();
                    let mut mean = vec![[0.0; 3]; 4];
                    for tap in taps {
                        let here = coefficients_at(&basis, &paint.brdf, &paint.at(tap.uv())).unwrap();
                        for (mean, here) in mean.iter_mut().zip(&here) {
                            (0..3).for_each(|k| mean[k] += f64::from(tap.weight) / all * f64::from(here[k]));
                        }
                    }
                    mean
                }
            };
            let pixel = head.fragments.pixel[fragment] as usize;
            for (e, c) in coefficients.iter().enumerate() {
                let count = head.direct_fragments(e);
                for k in 0..3 {
                    let (plane, colour) = match head.meta.chromaticity {
                        Some(colour) if e > 0 => (0, colour[k]),
                        _ => (k, 1.0),
                    };
                    let half = images.direct[e][plane * count + fragment].to_f32();
                    let direct = f64::from(half) * f64::from(head.scales[e]) * f64::from(colour);
                    let (mut light, mut size) = (0.0, 0.0);
                    for index in 0..SIDE * SIDE {
                        let Some(entries) = images.indirect.get(e) else { break };
                        let (tile, cell) = (*cell as usize / 1024, *cell as usize % 1024);
                        for (row, steps) in entries.at(tile * 1024 + index) {
                            let term =
                                alphas[e][usize::from(row)][k] * f64::from(steps) * wavelet(index, cell);
                            light += term;
                            size += term.abs();
                        }
                    }
                    let share = f64::from(head.fragments.coverage[fragment].to_f32());
                    expected[pixel][k] += c[k] * (direct + light * share);
                    sizes[pixel][k] += (c[k].abs() + 1.0) * (direct.abs() + size * share);
                }
            }
        }
        for ((shown, expected), size) in film.iter().zip(&expected).zip(&sizes) {
            for k in 0..3 {
                let off = (f64::from(shown[k]) - expected[k]).abs();
                // Sums of a thousand terms in single precision.
                assert!(off <= 1e-4 * size[k] + 1e-30, "{} for {}", shown[k], expected[k]);
            }
        }
    }
}

#[test]
fn regions_have_the_mean_of_what_is_on_a_surface() {
    let random = &mut Random(7);
    let basis = samples::basis(7, 3, true);
    // As many texels as two in each region: points lie on the quarters of these.
    let brdf = Brdf::BlinnPhong(random.blinn_phong());
    let mut paint = Paint::uniform(&brdf, [64, 32]);
    for (i, texel) in paint.texels.iter_mut().enumerate() {
        texel[0] = [if i % 2 == 0 { 0.1 } else { 0.5 }; 3];
    }
    let diffuse = |cover: &[bool], region: usize| {
        let [red, ..] = region_means(&basis, &paint, cover).unwrap().0[region * 3];
        let own =
            coefficients_at(&basis, &brdf, &[[0.0; 3], paint.texels[0][1], paint.texels[0][2]]).unwrap();
        red - own[0][0]
    };
    let everywhere = vec![true; COVER * COVER];
    let inner = REGIONS * 5 + 5;
    assert!((diffuse(&everywhere, inner) - 0.3).abs() < 1e-5);
    assert!((diffuse(&vec![false; COVER * COVER], inner) - 0.3).abs() < 1e-5, "without a surface all counts");
    // Left halves of regions alone: the dark texel, and what flows into it from the bright ones around.
    let left: Vec<bool> = (0..COVER * COVER).map(|i| i % 32 < 16).collect();
    let shares = [0.1 + 0.4 * 0.25, 0.1 + 0.4 * 0.25];
    let mean = shares.iter().sum::<f64>() / 2.0;
    assert!((f64::from(diffuse(&left, inner)) - mean).abs() < 1e-5);
    assert_eq!(
        region_means(&basis, &Paint::uniform(&brdf, [1, 1]), &left).unwrap().0.len(),
        3 * REGION_COUNT
    );
}

#[test]
fn materials_of_another_model_are_none_of_the_basis() {
    let random = &mut Random(3);
    let images = region_images(3, 3, true, [4, 4]);
    let (basis, brdf) = (samples::basis(3, 3, true), Brdf::Ggx(random.ggx()));
    let paint = Paint::uniform(&brdf, [2, 2]);
    let worn = [Worn::Painted(&paint), Worn::Whole(&brdf), Worn::Painted(&paint)];
    assert_eq!(evaluate(&images, &basis, &worn), None);
}
