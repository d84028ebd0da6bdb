//! Haar transforms, triple products and the choice of terms, each beside a straightforward version of the
//! same work.
//!
//! `bake/benches/pywavelets.py` times PyWavelets on the work of the first group; run both on one machine to
//! compare.

#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use relume_formats::basis::approximate::{by_area, largest};
use relume_formats::basis::haar::{forward, forward_cube, index, inverse_cube};
use relume_formats::basis::psum::psum;
use relume_formats::basis::triple::{self, Operand, Sparse};
use relume_formats::basis::two_level::{BYTES, SIDE, two_level};
use relume_formats::kinds::HaarTable;
use std::cmp::Reverse;
use std::hint::black_box;

/// Texels along a side of the light of `sparse-transfer`.
const LIGHT_SIDE: usize = 64;
/// Cubes that are transformed together: 16 MiB, more than caches near a core hold, as in a bake.
const ROWS: usize = 171;

fn noise(count: usize, seed: u64) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| next()).collect()
}

/// The transform as textbooks have it: level by level, rows and then columns of what is left at the upper
/// left.
fn textbook(face: &mut [f32], n: usize) {
    let mut line = vec![0.0; n];
    let mut side = n;
    while side > 1 {
        let half = side / 2;
        for (along, across) in [(1, n), (n, 1)] {
            for start in (0..side).map(|k| k * across) {
                for i in 0..half {
                    let (a, b) = (face[start + 2 * i * along], face[start + (2 * i + 1) * along]);
                    line[i] = (a + b) * std::f32::consts::FRAC_1_SQRT_2;
                    line[half + i] = (a - b) * std::f32::consts::FRAC_1_SQRT_2;
                }
                (0..side).for_each(|i| face[start + i * along] = line[i]);
            }
        }
        side = half;
    }
}

fn transforms(c: &mut Criterion) {
    let n = LIGHT_SIDE;
    let cube = 6 * n * n;
    let mut rows = noise(ROWS * cube, 1);
    let mut group = c.benchmark_group("rows of 6x64x64");
    group.sample_size(20).throughput(Throughput::Bytes((rows.len() * size_of::<f32>()) as u64));
    // Orthonormal: values stay of one size however often they are transformed.
    group.bench_function("forward, textbook", |b| {
        b.iter(|| rows.chunks_exact_mut(n * n).for_each(|face| textbook(face, n)))
    });
    group.bench_function("forward", |b| {
        b.iter(|| rows.chunks_exact_mut(cube).for_each(|row| forward_cube(row, n)))
    });
    group.bench_function("forward, on all cores", |b| {
        b.iter(|| rows.par_chunks_exact_mut(cube).for_each(|row| forward_cube(row, n)))
    });
    group.bench_function("inverse", |b| {
        b.iter(|| rows.chunks_exact_mut(cube).for_each(|row| inverse_cube(row, n)))
    });
    group.finish();

    let mut one = noise(cube, 2);
    let mut group = c.benchmark_group("one 6x64x64");
    group.throughput(Throughput::Bytes((one.len() * size_of::<f32>()) as u64));
    group.bench_function("forward, textbook", |b| {
        b.iter(|| one.chunks_exact_mut(n * n).for_each(|face| textbook(face, n)))
    });
    group.bench_function("forward", |b| b.iter(|| forward_cube(&mut one, n)));
    group.bench_function("inverse", |b| b.iter(|| inverse_cube(&mut one, n)));
    group.finish();
}

fn bitmaps(c: &mut Criterion) {
    let table = HaarTable::bake();
    // Caps, as spheres cast them.
    let caps: [u8; BYTES] = std::array::from_fn(|byte| {
        let (x, y) = (byte % 4 * 8, byte / 4 % SIDE);
        (0..8)
            .fold(0, |bits, k| bits | u8::from((x + k).abs_diff(13).pow(2) + y.abs_diff(17).pow(2) < 90) << k)
    });
    let unpack = |bitmap: &[u8; BYTES], image: &mut [f32]| {
        for (texels, byte) in image.as_chunks_mut::<8>().0.iter_mut().zip(bitmap) {
            *texels = std::array::from_fn(|k| f32::from((byte >> k) & 1));
        }
    };
    let mut image = vec![0.0; BYTES * 8];
    let mut group = c.benchmark_group("bitmap of 6x32x32");
    group.bench_function("unpack, textbook", |b| {
        b.iter(|| {
            unpack(black_box(&caps), &mut image);
            image.chunks_exact_mut(SIDE * SIDE).for_each(|face| textbook(face, SIDE));
        });
    });
    group.bench_function("unpack, plain", |b| {
        b.iter(|| {
            unpack(black_box(&caps), &mut image);
            forward_cube(&mut image, SIDE);
        });
    });
    group.bench_function("two levels", |b| b.iter(|| two_level(black_box(&caps), &table, &mut image)));
    // The sums and products alone, without unpacking or look-ups: this is what is 1/16.
    let mut scratch = Vec::new();
    let mut only = |side: usize| {
        image.chunks_exact_mut(side * side).take(6).for_each(|face| forward(face, side, &mut scratch))
    };
    group.bench_function("arithmetic of plain", |b| b.iter(|| only(SIDE)));
    group.bench_function("arithmetic of two levels", |b| b.iter(|| only(SIDE / 4)));
    group.finish();
}

/// A factor with its means and its largest terms.
struct Factor {
    texels: Vec<f32>,
    coefficients: Vec<f32>,
    psums: Vec<f32>,
}

impl Factor {
    fn new(mut coefficients: Vec<f32>, n: usize) -> Self {
        let psums = psum(&coefficients, n);
        let kept = coefficients.clone();
        inverse_cube(&mut coefficients, n);
        Self { texels: coefficients, coefficients: kept, psums }
    }

    fn of_texels(mut texels: Vec<f32>, n: usize) -> Self {
        forward_cube(&mut texels, n);
        Self::new(texels, n)
    }

    /// The `k` most important terms, and the factor that they make.
    fn kept(&self, k: usize, n: usize) -> (Vec<(u32, f32)>, Self) {
        let terms = largest(&self.coefficients, k, by_area(n));
        let mut coefficients = vec![0.0; self.coefficients.len()];
        terms.iter().for_each(|(at, value)| coefficients[*at as usize] = *value);
        (terms, Self::new(coefficients, n))
    }

    fn operand(&self) -> Operand<'_, f32> {
        Operand { coefficients: &self.coefficients, psums: &self.psums }
    }
}

/// The algorithm as the source prints it, its misprint mended: means by recursion at every use.
fn by_the_source([a, b, c]: [&[f32]; 3], n: usize) -> f32 {
    let mut sum = a[0] * b[0] * c[0] / n as f32;
    for level in 0..n.ilog2() {
        let scale = (1 << level) as f32 / n as f32;
        for (i, j) in (0..1 << level).flat_map(|j| (0..1 << level).map(move |i| (i, j))) {
            let at = |x: &[f32], m: usize| x[index(level, m, i, j)];
            for [p, q, r] in [[1, 2, 3], [1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]] {
                sum += scale * at(a, p) * at(b, q) * at(c, r);
            }
            for m in 1..=3 {
                sum += at(a, m) * at(b, m) * mean(c, n, level, i, j);
                sum += at(a, m) * at(c, m) * mean(b, n, level, i, j);
                sum += at(b, m) * at(c, m) * mean(a, n, level, i, j);
            }
        }
    }
    sum
}

fn mean(x: &[f32], n: usize, level: u32, i: usize, j: usize) -> f32 {
    let Some(parent) = level.checked_sub(1) else { return x[0] / n as f32 };
    let sign = |positive: bool| if positive { 1.0 } else { -1.0 };
    let (left, upper) = (sign(i.is_multiple_of(2)), sign(j.is_multiple_of(2)));
    let detail = |m: usize| x[index(parent, m, i / 2, j / 2)];
    mean(x, n, parent, i / 2, j / 2)
        + (1 << parent) as f32 / n as f32 * (detail(1) * left + detail(2) * upper + detail(3) * left * upper)
}

fn products(c: &mut Criterion) {
    let n = SIDE;
    let [light, brdf, visibility] = [3, 4, 5]
        .map(|seed| Factor::of_texels(noise(6 * n * n, seed).into_iter().map(|v| v.powi(8)).collect(), n));
    let all = [&light, &brdf, &visibility];
    let mut group = c.benchmark_group("triple product of 6x32x32");
    group.bench_function("as the source prints it", |b| {
        b.iter(|| {
            (0..6)
                .map(|face| {
                    by_the_source(
                        black_box(all).map(|f| &f.coefficients[face * n * n..(face + 1) * n * n]),
                        n,
                    )
                })
                .sum::<f32>()
        });
    });
    group.bench_function("back to texels", |b| {
        let mut texels = all.map(|f| f.coefficients.clone());
        b.iter(|| {
            for (texels, factor) in texels.iter_mut().zip(black_box(all)) {
                texels.copy_from_slice(&factor.coefficients);
                inverse_cube(texels, n);
            }
            let [a, b, c] = &texels;
            a.iter().zip(b).zip(c).map(|((a, b), c)| a * b * c).sum::<f32>()
        });
    });
    group.bench_function("sum over texels", |b| {
        b.iter(|| {
            let [a, b, c] = black_box(all).map(|f| &f.texels);
            a.iter().zip(b).zip(c).map(|((a, b), c)| a * b * c).sum::<f32>()
        });
    });
    group.bench_function("dense", |b| b.iter(|| triple::dense(black_box(all).map(Factor::operand), n)));
    group.bench_function("means of one factor", |b| b.iter(|| psum(black_box(&visibility.coefficients), n)));
    for k in [50, 100, 200] {
        let [(few, brdf), (more, light)] = [brdf.kept(k, n), light.kept(k, n)];
        let [first, second] =
            [(&few, &brdf), (&more, &light)].map(|(terms, factor)| Sparse { terms, dense: factor.operand() });
        group.bench_function(BenchmarkId::new("sparse", k), |b| {
            b.iter(|| triple::sparse(black_box(&first), black_box(&second), &visibility.operand(), n));
        });
    }
    group.finish();
}

fn choices(c: &mut Criterion) {
    let coefficients = noise(6 * LIGHT_SIDE * LIGHT_SIDE, 6);
    let weight = by_area(LIGHT_SIDE);
    let mut group = c.benchmark_group("100 of 24576 terms");
    group.bench_function("full sort", |b| {
        b.iter(|| {
            let importance = |i: u32| coefficients[i as usize].abs() * weight(i as usize);
            let mut order: Vec<u32> = (0..coefficients.len() as u32).collect();
            order.sort_by_cached_key(|i| Reverse(importance(*i).to_bits()));
            order.iter().take(100).map(|i| (*i, coefficients[*i as usize])).collect::<Vec<_>>()
        });
    });
    group.bench_function("largest", |b| b.iter(|| largest(black_box(&coefficients), 100, &weight)));
    group.finish();
}

criterion_group!(haar, transforms, bitmaps, products, choices);
criterion_main!(haar);
