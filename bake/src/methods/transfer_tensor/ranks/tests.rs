use super::super::packed::tests::noise;
use super::super::packed::{Packed, PackedSecond, whole};
use super::*;
use glam::Vec3A;
use ndarray::{Array3, Array4, s};
use relume_formats::basis::haar::inverse_cube;

/// Vertices of a cluster, half of which shine, and sources.
const MEMBERS: usize = 40;
const SOURCES: usize = 2;

fn receivers() -> Vec<Receiver> {
    let normal = |k: usize| Vec3A::new(noise(k), noise(k + 50), 1.0).normalize();
    (0..MEMBERS).map(|k| Receiver { origin: Vec3A::ZERO, normal: normal(k) }).collect()
}

fn states(receivers: &[Receiver]) -> States<'_> {
    let light =
        |coefficients: usize| Array2::from_shape_fn((coefficients, RADIANCES), |(k, s)| noise(k * 48 + s));
    let weight =
        |state: usize, source: usize| [0, 1, 2].map(|c| noise(state * 7 + source * 3 + c).abs() + 0.1);
    States {
        receivers,
        shines: (0..MEMBERS).map(|k| k % 2 == 1).collect(),
        weights: (0..STATES)
            .map(|state| (0..SOURCES).map(|source| weight(state, source)).collect())
            .collect(),
        pairs: vec![[0, 0], [0, 1], [1, 0], [1, 1]],
        lights: LIGHTS.map(light),
    }
}

/// Squared errors of `vertex`, which receives `off`, [harmonics, states], by sums over many directions.
fn by_directions(states: &States<'_>, vertex: usize, off: &Array2<f64>) -> [f64; STATES] {
    const DIRECTIONS: usize = 20_000;
    let (normal, mut sums) = (states.receivers[vertex].normal, [[0.0; 2]; RADIANCES]);
    for k in 0..DIRECTIONS {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (r, angle) = ((1.0 - z * z).sqrt(), 2.399_963_229_728_653 * k as f64);
        let direction = glam::DVec3::new(r * angle.cos(), r * angle.sin(), z).as_vec3();
        let cosine = f64::from(direction.dot(normal.into()).max(0.0));
        let harmonics = sh::evaluate(direction).map(f64::from);
        for (sums, column) in sums.iter_mut().zip(off.columns()) {
            let radiance: f64 = column.iter().zip(harmonics).map(|(a, b)| a * b).sum();
            let area = 4.0 * PI / DIRECTIONS as f64;
            *sums = [sums[0] + radiance * cosine * area / PI, sums[1] + radiance * radiance * area / TAU];
        }
    }
    let square = |[irradiance, mean]: [f64; 2]| {
        let diffuse = irradiance * irradiance;
        if states.shines[vertex] { 0.25 * (diffuse + mean) } else { diffuse }
    };
    std::array::from_fn(|state| sums[3 * state..][..3].iter().map(|sums| square(*sums)).sum())
}

/// The same errors as those of the tensors themselves beside what fewer ranks leave of them, summed over
/// directions.
#[test]
fn errors_of_one_reflection_are_those_of_tensors_cut() {
    let tensors = Array4::from_shape_fn((MEMBERS, SOURCES, LIGHTS[0], sh::COUNT), |(v, c, l, s)| {
        noise(((v * SOURCES + c) * LIGHTS[0] + l) * 16 + s)
    });
    let packed = Packed::new(&tensors, RANKS).unwrap();
    let mut u = packed.u.view();
    u.swap_axes(0, 1);
    let halves =
        |values: &mut dyn Iterator<Item = &f32>| values.map(|x| f16::from_f32(*x)).collect::<Vec<_>>();
    let piece = OncePiece {
        shares: u.iter().map(|x| (127.0 * x).round() as i8).collect(),
        core: halves(&mut packed.core.iter()),
        light: halves(&mut packed.light.iter()),
        coarse: Vec::new(),
        sampled: sampled(MEMBERS).into_iter().flat_map(|k| whole(&tensors.index_axis(Axis(0), k))).collect(),
    };
    let members: Vec<usize> = (0..MEMBERS).collect();
    let (receivers, mut tried) = (receivers(), Tried::once());
    let states = states(&receivers);
    tried.add(&piece, &members, &states);
    assert_eq!(tried.vertices, SAMPLED);
    let mut texels = states.lights[0].clone();
    for mut column in texels.columns_mut() {
        let mut values = column.to_vec();
        inverse_cube(&mut values, 8);
        column.assign(&ndarray::ArrayView1::from(&values));
    }
    for [m, n] in [[8, 8], RANKS] {
        let mut cut = packed.clone();
        cut.u.slice_mut(s![.., .., m..]).fill(0.0);
        cut.core.slice_mut(s![.., .., n.., ..]).fill(0.0);
        let found = cut.lit(&states.lights[0]);
        let mut expected = [0.0; STATES];
        for vertex in sampled(MEMBERS) {
            let off = Array2::from_shape_fn((sh::COUNT, RADIANCES), |(s, k)| {
                (0..SOURCES)
                    .map(|source| {
                        let tensor = tensors.slice(s![vertex, source, .., s]);
                        let exact = tensor.dot(&texels.column(k));
                        f64::from(states.weights_of(source)[k] * (found[[vertex, source, s, k]] - exact))
                    })
                    .sum()
            });
            add(&mut expected, &by_directions(&states, vertex, &off));
        }
        let at = tried.choices.iter().position(|choice| *choice == [m, n]).unwrap();
        for (found, expected) in tried.squares[at].iter().zip(expected) {
            // Shares of eight bits and halves err by less than a hundredth of what ranks leave out.
            assert!((found / expected - 1.0).abs() < 0.03, "[{m}, {n}]: {found}, not {expected}");
        }
    }
    let worse = |a: &Errors, b: &Errors| a.iter().sum::<f64>() > b.iter().sum();
    assert!(
        tried.squares.chunks(OF_LIGHT.len()).all(|row| row.is_sorted_by(worse)),
        "more of light, less error"
    );
}

#[test]
fn errors_of_two_reflections_are_those_of_tensors_cut() {
    let (pairs, receivers) = (4, receivers());
    let states = states(&receivers);
    let tensors = Array3::from_shape_fn((MEMBERS, pairs, LIGHTS[1]), |(v, p, l)| noise((v * 4 + p) * 24 + l));
    let packed = PackedSecond::new(&tensors.view()).unwrap();
    let transposed = |k: usize| tensors.index_axis(Axis(0), k).t().iter().copied().collect::<Vec<_>>();
    let piece = TwicePiece {
        shares: packed.u.iter().map(|x| (127.0 * x).round() as i8).collect(),
        vectors: packed.vectors.iter().map(|x| f16::from_f32(*x)).collect(),
        sampled: sampled(MEMBERS).into_iter().flat_map(transposed).map(f16::from_f32).collect(),
    };
    let mut tried = Tried::twice();
    tried.add(&piece, MEMBERS, &states);
    let mut cut = packed;
    cut.u.slice_mut(s![.., 4..]).fill(0.0);
    let found = cut.whole();
    let mut expected = [0.0; STATES];
    for vertex in sampled(MEMBERS) {
        for (k, light) in states.lights[1].columns().into_iter().enumerate() {
            let of_pair = |(number, pair): (usize, &[usize; 2])| {
                let off = &found.slice(s![vertex, .., number]) - &tensors.slice(s![vertex, number, ..]);
                pair.iter().map(|source| states.weights_of(*source)[k]).product::<f32>() * off.dot(&light)
            };
            let off: f32 = states.pairs.iter().enumerate().map(of_pair).sum();
            expected[k / 3] += f64::from(off).powi(2);
        }
    }
    for (found, expected) in tried.squares[0].iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.03, "{found}, not {expected}");
    }
}

/// Of two reflections, each a tenth of all with fewest and nothing with most: the smallest file that errs by no
/// more than asked for, all that there is where no file does, and where a number of terms was asked for.
#[test]
fn the_smallest_file_that_keeps_the_bound_is_chosen() {
    let by_terms: Vec<Errors> = (1..=100).map(|terms| [1.0 / f64::from(terms); STATES]).collect();
    let mut once = Tried::once();
    once.vertices = 2;
    for ([m, n], squares) in once.choices.iter().zip(&mut once.squares) {
        let left = 1.0 - (*m.min(n) as f64 - 8.0) / 24.0;
        *squares = [2.0 * 4.0 * 0.01 * left * left; STATES];
    }
    let twice = Tried { vertices: 1, ..Tried::twice() };
    let sizes = Sizes { vertices: 1e4, columns: 5.0, clusters: 10.0, sources: 13.0, pairs: 163.0 };
    let with = |terms| choose(&by_terms, (&once, &twice), &[4.0; STATES], &sizes, terms);
    let loose = with(Terms::Error(0.2));
    assert_eq!((loose.ranks, loose.vectors), ([8, 8], 4));
    assert!((loose.reflected[0] - 0.1).abs() < 1e-12);
    // 1.05·√(0.1² + 1/t²) ≤ 0.2
    assert_eq!(loose.terms, 7);
    let tight = with(Terms::Error(0.04));
    assert!(tight.ranks[0] >= 24 && tight.ranks[1] >= 24 && tight.ranks < RANKS, "{tight:?}");
    assert!(1.05 * together(&by_terms[tight.terms - 1], &tight.reflected)[0] <= 0.04);
    let asked = with(Terms::Number(50));
    assert_eq!((asked.terms, asked.ranks, asked.vectors), (50, RANKS, SECOND_RANK));
    let most = with(Terms::Error(1e-3));
    assert_eq!((most.terms, most.ranks, most.vectors), (100, RANKS, SECOND_RANK), "no file reaches it");
    let mut norm = [4.0; STATES];
    norm[3] = 0.0;
    let unlit = choose(&by_terms, (&once, &twice), &norm, &sizes, Terms::Error(0.2));
    assert!(unlit.reflected[3].is_nan(), "a light that shows nothing has no error");
    assert_eq!((unlit.terms, unlit.ranks), (loose.terms, loose.ranks), "and chooses nothing");
    let single =
        choose(&by_terms, (&Tried::once(), &Tried::twice()), &[4.0; STATES], &sizes, Terms::Error(0.2));
    assert_eq!((single.terms, single.ranks, single.vectors), (6, [0; 2], 0), "nothing is reflected again");
}

/// What is kept stands where it stood.
#[test]
fn a_cut_keeps_the_first_functions() {
    let (vertices, clusters) = (3, 2);
    let core = |c: usize, s: usize, m: usize, n: usize, h: usize| {
        f16::from_f32((((c * 2 + s) * 4 + m) * 3 + n) as f32 + h as f32 / 16.0)
    };
    let light =
        |c: usize, s: usize, n: usize, k: usize| f16::from_f32((((c * 2 + s) * 3 + n) * 4 + k % 4) as f32);
    let filled = |m: usize, n: usize| {
        let all = |c: usize| (0..SOURCES).map(move |s| (c, s));
        let pairs: Vec<_> = (0..clusters).flat_map(all).collect();
        let of_core = |(c, s): &(usize, usize)| {
            let (c, s) = (*c, *s);
            (0..m * n * sh::COUNT)
                .map(move |k| core(c, s, k / (n * sh::COUNT), k / sh::COUNT % n, k % sh::COUNT))
                .collect::<Vec<_>>()
        };
        let of_light = |(c, s): &(usize, usize)| {
            let (c, s) = (*c, *s);
            (0..n * LIGHTS[0]).map(move |k| light(c, s, k / LIGHTS[0], k % LIGHTS[0])).collect::<Vec<_>>()
        };
        Once {
            clusters: vec![0, 1, 1],
            shares: (0..vertices * SOURCES).flat_map(|k| (0..m).map(move |m| (k * 10 + m) as i8)).collect(),
            core: pairs.iter().flat_map(of_core).collect(),
            light: pairs.iter().flat_map(of_light).collect(),
        }
    };
    assert_eq!(cut_once(&filled(4, 3), [4, 3], [2, 1]), filled(2, 1));
    assert_eq!(cut_once(&filled(4, 3), [4, 3], [4, 3]), filled(4, 3));
    let twice = |vectors: usize| Twice {
        shares: (0..vertices).flat_map(|v| (0..vectors).map(move |k| (v * 10 + k) as i8)).collect(),
        vectors: (0..clusters)
            .flat_map(|c| (0..vectors * 5).map(move |k| f16::from_f32((c * 100 + k) as f32)))
            .collect(),
    };
    assert_eq!(cut_twice(&twice(4), clusters, [4, 3]), twice(3));
}
