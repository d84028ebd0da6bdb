//! Means over squares and triple products against sums over texels.

use relume_formats::basis::approximate::{by_size, largest};
use relume_formats::basis::haar::{Number, forward_cube, index, inverse_cube};
use relume_formats::basis::psum::{psum, psum_face, square, squares};
use relume_formats::basis::triple::{Operand, Sparse, dense, sparse};

/// A reproducible stream of numbers in −1..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0
    }
}

/// Coefficients with their means.
#[derive(Clone)]
struct Function<T> {
    coefficients: Vec<T>,
    psums: Vec<T>,
}

impl<T: Number> Function<T> {
    fn of_coefficients(coefficients: Vec<T>, n: usize) -> Self {
        Self { psums: psum(&coefficients, n), coefficients }
    }

    fn of_texels(texels: &[T], n: usize) -> Self {
        let mut coefficients = texels.to_vec();
        forward_cube(&mut coefficients, n);
        Self::of_coefficients(coefficients, n)
    }

    fn texels(&self, n: usize) -> Vec<T> {
        let mut texels = self.coefficients.clone();
        inverse_cube(&mut texels, n);
        texels
    }

    fn operand(&self) -> Operand<'_, T> {
        Operand { coefficients: &self.coefficients, psums: &self.psums }
    }
}

fn by_texels(functions: [&[f64]; 3]) -> f64 {
    let [a, b, c] = functions;
    a.iter().zip(b).zip(c).map(|((a, b), c)| a * b * c).sum()
}

/// What rounding errors of a triple product are relative to: every sum in it is at most ‖a‖·‖b‖·max|c| or the
/// like.
fn magnitude(functions: [&[f64]; 3]) -> f64 {
    let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
    let most = |x: &[f64]| x.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let [a, b, c] = functions;
    norm(a) * norm(b) * most(c) + norm(a) * norm(c) * most(b) + norm(b) * norm(c) * most(a)
}

/// All 64³ products of three basis functions at n = 8, against texels and against the rule of the three
/// cases.
#[test]
fn products_of_basis_functions_are_as_stated() {
    let n = 8;
    let functions: Vec<Function<f64>> = (0..64)
        .map(|at| Function::of_coefficients((0..64).map(|k| f64::from(u8::from(k == at))).collect(), n))
        .collect();
    let texels: Vec<Vec<f64>> = functions.iter().map(|f| f.texels(n)).collect();
    let level = |at: usize| at.ilog2() / 2;
    let square_of = |at: usize| (level(at), at % 4usize.pow(level(at)));
    let mut counts = [0; 4];
    for (a, b, c) in (0..64).flat_map(|a| (0..64).flat_map(move |b| (0..64).map(move |c| (a, b, c)))) {
        let truth = by_texels([&texels[a], &texels[b], &texels[c]]);
        // Powers of two and nothing to round.
        assert_eq!(dense([a, b, c].map(|k| functions[k].operand()), n), truth, "{a} {b} {c}");
        let [terms_a, terms_b] = [a, b].map(|k| [(k as u32, 1.0)]);
        let [sparse_a, sparse_b] =
            [(a, &terms_a), (b, &terms_b)].map(|(k, terms)| Sparse { terms, dense: functions[k].operand() });
        assert_eq!(sparse(&sparse_a, &sparse_b, &functions[c].operand(), n), truth, "sparse {a} {b} {c}");

        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        let case = match sorted {
            _ if truth == 0.0 => 0,
            [0, 0, 0] => 1,
            [0, y, z] => {
                assert_eq!(y, z);
                3
            }
            [x, y, z] if square_of(x) == square_of(y) && square_of(y) == square_of(z) => {
                assert!(x != y && y != z, "three types");
                2
            }
            [x, y, z] => {
                assert!(y == z && level(x) < level(y), "two equal and a coarser one");
                3
            }
        };
        counts[case] += 1;
        let size = match case {
            1 => 1.0 / 8.0,
            2 | 3 => f64::from(1 << if sorted[0] == 0 { 0 } else { level(sorted[0]) }) / 8.0,
            _ => 0.0,
        };
        assert_eq!(truth.abs(), size, "{a} {b} {c}");
    }
    // 6 assignments on 21 squares; 3 places for the third of 387 pairs of a wavelet and what covers it.
    assert_eq!(counts, [64 * 64 * 64 - 1288, 1, 6 * 21, 3 * 387]);
}

/// Functions that are hard on some part of the algorithm, on a cube of `n` × `n` a face.
fn inputs(n: usize) -> Vec<(&'static str, Vec<f64>)> {
    let texels = 6 * n * n;
    let mut random = Random(7);
    let mut noise = |scale: f64| -> Vec<f64> { (0..texels).map(|_| scale * random.next()).collect() };
    let place = |i: usize| (i / (n * n), i % n, i / n % n);
    let of = |f: &dyn Fn(usize, usize, usize) -> f64| {
        (0..texels).map(|i| f(place(i).0, place(i).1, place(i).2)).collect::<Vec<f64>>()
    };
    let mixed: Vec<f64> =
        noise(1.0).iter().map(|v| if v.abs() < 0.02 { 1e5 * v.signum() } else { 1e-3 * v }).collect();
    vec![
        ("noise", noise(1.0)),
        ("other noise", noise(3.0)),
        ("1e5 among 1e-3", mixed),
        ("one texel", of(&|face, x, y| if (face, x, y) == (4, n - 1, 2) { 1e5 } else { 0.0 })),
        ("constant", of(&|_, _, _| 0.7)),
        ("black", of(&|_, _, _| 0.0)),
        ("fine checkerboard", of(&|_, x, y| if (x + y) % 2 == 0 { 1.0 } else { -1.0 })),
        ("coarse checkerboard", of(&|_, x, y| if (2 * x / n == 0) == (2 * y / n == 0) { 1.0 } else { 0.0 })),
        ("one face", of(&|face, _, _| if face == 2 { 4.0 } else { 0.0 })),
        ("one quarter", of(&|face, x, y| if face == 5 && x < n / 2 && y >= n / 2 { -3.0 } else { 0.0 })),
        ("columns", of(&|_, x, _| if x % 2 == 0 { 1.0 } else { 0.25 })),
        ("rows", of(&|face, _, y| if y % 4 < 2 { face as f64 } else { -1.0 })),
    ]
}

#[test]
fn dense_products_are_sums_over_texels() {
    for n in [1, 2, 16] {
        let inputs = inputs(n.max(2));
        let inputs: Vec<(&str, Vec<f64>)> =
            inputs.into_iter().map(|(name, t)| (name, t[..6 * n * n].to_vec())).collect();
        let doubles: Vec<_> = inputs.iter().map(|(_, t)| Function::of_texels(t, n)).collect();
        let singles: Vec<_> = inputs
            .iter()
            .map(|(_, t)| Function::of_texels(&t.iter().map(|v| *v as f32).collect::<Vec<_>>(), n))
            .collect();
        let all = 0..inputs.len();
        for (a, b, c) in
            all.clone().flat_map(|a| all.clone().flat_map(move |b| (0..12).map(move |c| (a, b, c))))
        {
            let texels = [a, b, c].map(|k| &inputs[k].1[..]);
            let (truth, magnitude) = (by_texels(texels), magnitude(texels));
            let names = [a, b, c].map(|k| inputs[k].0);
            // Three operands round three times a level, sums and means add as many again: below 64 roundings,
            // each relative to the magnitude.
            let ours = dense([a, b, c].map(|k| doubles[k].operand()), n);
            assert!(
                (ours - truth).abs() <= 64.0 * f64::EPSILON * magnitude,
                "n = {n}, {names:?}: {ours} against {truth}"
            );
            let ours = f64::from(dense([a, b, c].map(|k| singles[k].operand()), n));
            assert!(
                (ours - truth).abs() <= 64.0 * f64::from(f32::EPSILON) * magnitude,
                "n = {n}, {names:?}: {ours} against {truth}"
            );
        }
    }
}

/// The largest terms of a function, and the function that they make.
struct Kept {
    terms: Vec<(u32, f32)>,
    function: Function<f32>,
    texels: Vec<f64>,
}

impl Kept {
    fn of(texels: &[f64], n: usize, k: usize) -> Self {
        let whole = Function::of_texels(&texels.iter().map(|v| *v as f32).collect::<Vec<_>>(), n);
        let terms = largest(&whole.coefficients, k, by_size);
        let mut coefficients = vec![0.0f32; texels.len()];
        terms.iter().for_each(|(at, value)| coefficients[*at as usize] = *value);
        let doubles = Function::of_coefficients(coefficients.iter().map(|v| f64::from(*v)).collect(), n);
        Self { terms, function: Function::of_coefficients(coefficients, n), texels: doubles.texels(n) }
    }
}

#[test]
fn sparse_products_are_sums_over_the_texels_of_what_was_kept() {
    let n = 16;
    let inputs = inputs(n);
    let kept = |k: usize| -> Vec<Kept> { inputs.iter().map(|(_, texels)| Kept::of(texels, n, k)).collect() };
    let (few, more, all) = (kept(40), kept(100), kept(usize::MAX));
    for (a, b, c) in (0..12).flat_map(|a| (0..12).flat_map(move |b| (0..12).map(move |c| (a, b, c)))) {
        let texels = [&few[a].texels[..], &more[b].texels, &all[c].texels];
        let [first, second] =
            [&few[a], &more[b]].map(|kept| Sparse { terms: &kept.terms, dense: kept.function.operand() });
        let third = all[c].function.operand();
        let truth = by_texels(texels);
        for ours in [
            sparse(&first, &second, &third, n),
            sparse(&second, &first, &third, n),
            dense([first.dense, second.dense, third], n),
        ] {
            let names = [a, b, c].map(|k| inputs[k].0);
            let bound = 64.0 * f64::from(f32::EPSILON) * magnitude(texels);
            assert!((f64::from(ours) - truth).abs() <= bound, "{names:?}: {ours} against {truth}");
        }
    }
}

/// A function of random coefficients where `kept` says so.
fn only(random: &mut Random, n: usize, kept: impl Fn(usize) -> bool) -> Function<f64> {
    Function::of_coefficients((0..n * n).map(|at| if kept(at) { random.next() } else { 0.0 }).collect(), n)
}

#[test]
fn each_case_alone_is_a_sum_over_texels() {
    let (n, random) = (16, &mut Random(3));
    let check = |functions: [&Function<f64>; 3]| {
        let texels = functions.map(|f| f.texels(n));
        let truth = by_texels([&texels[0], &texels[1], &texels[2]]);
        let ours = dense(functions.map(Function::operand), n);
        assert!((ours - truth).abs() < 1e-13 && truth.abs() > 1e-7, "{ours} against {truth}");
    };
    let scaling = [(); 3].map(|()| only(random, n, |at| at == 0));
    check([&scaling[0], &scaling[1], &scaling[2]]);
    for level in 0..4 {
        let of_type =
            |random: &mut Random, m: usize| only(random, n, move |at| at >> (2 * level) == m && at > 0);
        let types = [1, 2, 3].map(|m| of_type(random, m));
        // The means of such functions over the squares of their level are 0, and no two of them are equal:
        // only case 2 is left.
        for [a, b, c] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            check([&types[a], &types[b], &types[c]]);
        }
        for m in 1..=3 {
            let (equal, other) = (of_type(random, m), of_type(random, m));
            let coarser = only(random, n, |at| at < 1 << (2 * level));
            check([&equal, &other, &coarser]);
            check([&equal, &coarser, &other]);
            check([&coarser, &equal, &other]);
        }
    }
}

/// The algorithm of the source, transcribed with the given six assignments of types, with means taken from
/// texels.
fn by_the_source(assignments: [[usize; 3]; 6], functions: [&Function<f64>; 3], n: usize) -> f64 {
    let texels = functions.map(|f| f.texels(n));
    let mut integral = functions.map(|f| f.coefficients[0]).iter().product::<f64>() / n as f64;
    for level in 0..n.ilog2() {
        for (i, j) in (0..1 << level).flat_map(|j| (0..1 << level).map(move |i| (i, j))) {
            let of = |f: usize, m: usize| functions[f].coefficients[index(level, m, i, j)];
            let products = assignments.iter().map(|[p, l, v]| of(0, *p) * of(1, *l) * of(2, *v)).sum::<f64>();
            integral += f64::from(1 << level) / n as f64 * products;
            let mean = |f: usize| square_mean(&texels[f], n, level, i, j);
            integral += (1..=3)
                .map(|m| {
                    of(0, m) * of(1, m) * mean(2)
                        + of(2, m) * of(0, m) * mean(1)
                        + of(1, m) * of(2, m) * mean(0)
                })
                .sum::<f64>();
        }
    }
    integral
}

fn square_mean(texels: &[f64], n: usize, level: u32, i: usize, j: usize) -> f64 {
    let side = n >> level;
    (0..side * side).map(|k| texels[(j * side + k / side) * n + i * side + k % side]).sum::<f64>()
        / (side * side) as f64
}

/// The source lists p[11]·L[01]·V[10] twice and p[11]·L[10]·V[01] never.
#[test]
fn the_misprint_of_the_source_is_no_triple_product() {
    let (n, random) = (8, &mut Random(11));
    let functions = [(); 3].map(|()| only(random, n, |_| true));
    let functions = [&functions[0], &functions[1], &functions[2]];
    let texels = functions.map(|f| f.texels(n));
    let truth = by_texels([&texels[0], &texels[1], &texels[2]]);
    let printed = [[1, 2, 3], [1, 3, 2], [2, 3, 1], [2, 1, 3], [3, 1, 2], [3, 1, 2]];
    let mut mended = printed;
    mended[5] = [3, 2, 1];
    let (wrong, right) = (by_the_source(printed, functions, n), by_the_source(mended, functions, n));
    assert!((wrong - truth).abs() > 0.01 * truth.abs(), "{wrong} as printed, {truth} over texels");
    assert!((right - truth).abs() < 1e-12, "{right} mended, {truth} over texels");
    assert!((dense(functions.map(Function::operand), n) - truth).abs() < 1e-12);
}

#[test]
fn means_by_recursion_are_means_of_texels() {
    for n in [1usize, 2, 4, 8, 32] {
        let mut random = Random(n as u64);
        let texels: Vec<f64> = (0..6 * n * n).map(|_| (random.next() * 512.0).round()).collect();
        let singles = Function::of_texels(&texels.iter().map(|v| *v as f32).collect::<Vec<_>>(), n);
        let levels = n.ilog2();
        assert_eq!(singles.psums.len(), 6 * squares(levels));
        for (face, level) in (0..6).flat_map(|face| (0..levels).map(move |level| (face, level))) {
            for (i, j) in (0..1 << level).flat_map(|j| (0..1 << level).map(move |i| (i, j))) {
                let mean = square_mean(&texels[face * n * n..], n, level, i, j);
                let ours = singles.psums[face * squares(levels) + square(level, i, j)];
                // Whole numbers below 1024 over a power of two need 20 bits at most: nothing is rounded.
                assert_eq!(f64::from(ours), mean, "n = {n}, face {face}, level {level}, square ({i}, {j})");
            }
        }
    }
}

#[test]
fn the_first_stage_of_a_transform_gives_the_coarse_means() {
    let n = 32;
    let mut random = Random(5);
    let function = Function::of_texels(&(0..n * n).map(|_| random.next()).collect::<Vec<_>>(), n);
    for levels in 0..=6 {
        let mut coarse = vec![f64::NAN; squares(levels)];
        // Coefficients of the last level are not looked at.
        let known = if levels == 0 { 0 } else { 1 << (2 * (levels - 1)) };
        psum_face(&function.coefficients[..known], n, &mut coarse);
        if levels <= 5 {
            assert_eq!(coarse, function.psums[..squares(levels)]);
        } else {
            // One level more: the squares are the texels.
            let texels = function.texels(n);
            assert!(coarse[squares(5)..].iter().zip(&texels).all(|(a, b)| (a - b).abs() < 1e-14));
        }
    }
}
