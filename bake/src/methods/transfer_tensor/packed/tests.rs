use super::*;
use relume_formats::basis::haar::forward_cube;

/// Numbers without order.
pub(in super::super) fn noise(k: usize) -> f32 {
    let hash = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) as f64 / u64::MAX as f64 - 0.5) as f32
}

/// Vertices that three patterns span, and noise some per cent of these.
fn tensors(vertices: usize, columns: usize) -> Array4<f32> {
    Array4::from_shape_fn((vertices, columns, LIGHTS[0], sh::COUNT), |(v, c, l, s)| {
        let pattern = |k: usize| noise(v * 31 + k) * noise(l * 17 + k + 5) * noise((c * 16 + s) * 13 + k);
        pattern(0) + 0.5 * pattern(1) + 0.2 * pattern(2) + 0.001 * noise(((v * 3 + c) * 384 + l) * 16 + s)
    })
}

fn norm<'a>(values: impl IntoIterator<Item = &'a f32>) -> f64 {
    values.into_iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt()
}

/// Texels of a light as columns, and their Haar coefficients.
fn lights() -> [Array2<f32>; 2] {
    let texels = Array2::from_shape_fn((LIGHTS[0], 2), |(l, k)| noise(l * 2 + k + 900) + 0.5);
    let mut coefficients = texels.clone();
    for mut column in coefficients.columns_mut() {
        let mut values = column.to_vec();
        forward_cube(&mut values, FACE_SIZE);
        column.assign(&ndarray::ArrayView1::from(&values));
    }
    [texels, coefficients]
}

/// Of full rank it is the tensors themselves, whose sums over texels tell what it should be.
#[test]
fn full_ranks_give_the_light_of_the_tensors() {
    let tensors = tensors(9, 2);
    let [texels, coefficients] = lights();
    // More ranks than vertices: what is beyond is 0.
    let packed = Packed::new(&tensors, [12, 384]).unwrap();
    let found = packed.lit(&coefficients);
    for (of_vertex, exact) in found.outer_iter().zip(tensors.outer_iter()) {
        for (found, exact) in of_vertex.outer_iter().zip(exact.outer_iter()) {
            let exact = exact.t().dot(&texels);
            let off = norm(&(&found - &exact)) / norm(&exact);
            assert!(off < 2e-6, "{off}");
        }
    }
    assert!(packed.u.slice(s![.., .., 9..]).iter().all(|x| *x == 0.0));
    assert!(packed.core.slice(s![.., 9.., .., ..]).iter().all(|x| *x == 0.0));
}

/// The largest coefficient of every vector is 1; what is lost is what truncation must lose, and rounding to
/// eight and sixteen bits adds little to it.
#[test]
fn coefficients_are_balanced_for_rounding() {
    let tensors = tensors(40, 2);
    let packed = Packed::new(&tensors, [3, 3]).unwrap();
    for column in packed.u.outer_iter() {
        for vector in column.columns() {
            assert_eq!(vector.iter().fold(0.0f32, |m, x| m.max(x.abs())), 1.0);
        }
    }
    let [texels, coefficients] = lights();
    let rounded = Packed {
        u: packed.u.mapv(|x| (x * 127.0).round() / 127.0),
        core: packed.core.mapv(|x| f16::from_f32(x).to_f32()),
        light: packed.light.mapv(|x| f16::from_f32(x).to_f32()),
    };
    let exact = crate::methods::transfer_tensor::cluster::lit(&tensors, &texels.mapv(f64::from));
    let exact = exact.mapv(|x| x as f32);
    let off = |packed: &Packed| norm(&(packed.lit(&coefficients) - &exact)) / norm(&exact);
    let (before, after) = (off(&packed), off(&rounded));
    println!("{before} {after}");
    // The patterns are 0.024 as a root mean square, the noise 0.0003. Of a vector that is even over its range
    // rounding takes 1/254/√3 of the largest, 0.4 % of its own norm.
    assert!(before < 0.03 && after < (before * before + 0.005f64.powi(2)).sqrt(), "{before} {after}");
}

#[test]
fn nothing_is_nothing_and_one_vertex_is_whole() {
    let packed = Packed::new(&Array4::zeros((5, 2, LIGHTS[0], sh::COUNT)), RANKS).unwrap();
    assert_eq!((packed.u.dim(), packed.core.dim()), ((2, 5, 32), (2, 32, 32, 16)));
    assert!(packed.u.iter().chain(&packed.core).chain(&packed.light).all(|x| *x == 0.0));
    let second = PackedSecond::new(&Array3::zeros((5, 4, 24)).view()).unwrap();
    assert!(second.u.iter().chain(&second.vectors).all(|x| *x == 0.0));
    let one = Array3::from_shape_fn((1, 4, 24), |(_, p, l)| noise(p * 24 + l));
    let whole = PackedSecond::new(&one.view()).unwrap().whole();
    let off = norm(&(&whole.permuted_axes([0, 2, 1]) - &one));
    assert!(off < 1e-6, "{off}");
}

/// Where singular values are equal, vectors are by rule, and never by how many threads there are.
#[test]
fn equal_singular_values_give_the_same_bytes_on_any_threads() {
    // Pairs of vertices see the same at different places.
    let equal = Array4::from_shape_fn((64, 3, LIGHTS[0], sh::COUNT), |(v, c, l, s)| {
        if l % 64 == v { noise(c * 16 + s) + if s == 0 { 1.0 } else { 0.0 } } else { 0.0 }
    });
    let twice = Array3::from_shape_fn((30, 5, 24), |(v, p, l)| if l == v % 24 { noise(p) } else { 0.0 });
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (Packed::new(&equal, RANKS).unwrap(), PackedSecond::new(&twice.view()).unwrap()))
    };
    let (one, two) = (on(1), on(2));
    assert!(norm(&one.0.core) > 0.1 && norm(&one.1.vectors) > 0.1);
    assert!(one == two);
}

/// Sixteen patterns are kept, whatever they are of.
#[test]
fn light_after_two_reflections_is_kept_up_to_its_rank() {
    let exact = Array3::from_shape_fn((50, 6, 24), |(v, p, l)| {
        (0..SECOND_RANK).map(|k| noise(v * 16 + k) * noise((p * 24 + l) * 16 + k + 7000)).sum()
    });
    let whole = PackedSecond::new(&exact.view()).unwrap().whole();
    let off = norm(&(&whole.permuted_axes([0, 2, 1]) - &exact)) / norm(&exact);
    assert!(off < 2e-6, "{off}");
}

/// A light of 6×2×2 is one of 6×8×8 that is even over 4×4 texels.
#[test]
fn coarse_tensors_are_for_coarse_lights() {
    let tensor = tensors(1, 3).index_axis_move(Axis(0), 0);
    let coarse = coarse(&tensor.view());
    let light: Vec<f32> = (0..LIGHTS[1]).map(|k| noise(k + 50)).collect();
    let mut coefficients = light.clone();
    forward_cube(&mut coefficients, COARSE);
    for s in 0..sh::COUNT {
        for column in 0..3 {
            let row = &coarse[(s * 3 + column) * LIGHTS[1]..][..LIGHTS[1]];
            let found: f32 = row.iter().zip(&coefficients).map(|(t, c)| t.to_f32() * c).sum();
            let texel = |l: usize| {
                let (face, y, x) = (l / 64, l / 8 % 8, l % 8);
                light[face * 4 + y / 4 * 2 + x / 4]
            };
            let exact: f32 = (0..LIGHTS[0]).map(|l| texel(l) * tensor[[column, l, s]]).sum();
            // Halves: 24 roundings of 2⁻¹¹ of values of about one.
            assert!((found - exact).abs() < 3e-3, "{s} {column}: {found} {exact}");
        }
    }
}
