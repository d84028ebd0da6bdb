//! Tensors of BRDF spaces, from bake's library to what users see of their files.

use crate::support::{expect_exit, run};
use glam::Vec3;
use relume_bake::brdf::tensor::{CONES, Size, SpaceTensor};
use relume_formats::container::Stored as _;
use relume_formats::kinds::brdf_tensor::Samples;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};
use relume_formats::state::Model;
use serde_json::Value;
use std::path::Path;

/// The arrays of an export alone say the same lobes as the file.
#[test]
fn exported_arrays_are_the_lobe() {
    let space = SpaceTensor::new(Model::BlinnPhong, Samples::Line(vec![1.0, 20.0, 200.0]));
    let tensor = space.decomposed(&Size { columns: 3, ranks: [2, 3], ..Size::default() }).unwrap();
    let ([a, b, c], cones) = (tensor.ranks, CONES.len());
    let folder = tempfile::tempdir().unwrap();
    let text = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let file = text("phong.relume");
    tensor.write_file(Path::new(&file)).unwrap();

    expect_exit("bake", &["verify", &file], 0);
    let info: Value = serde_json::from_slice(&run("bake", &["info", &file, "--json"]).stdout).unwrap();
    assert_eq!((&info["kind"], &info["details"]["ranks"]), (&"brdf-tensor".into(), &[a, b, c][..].into()));
    assert_eq!(info["details"]["whole"].as_f64().unwrap(), tensor.meta.whole);
    assert_eq!(info["details"]["columns"].as_u64().unwrap(), tensor.columns() as u64);
    let told = String::from_utf8(run("bake", &["info", &file]).stdout).unwrap();
    assert!(
        told.contains(&format!("{a} of materials, {b} of outgoing and {c} of incoming directions")),
        "{told}"
    );
    assert!(told.contains("16 leave"), "{told}");

    expect_exit("bake", &["export", &file, "-o", &text("out")], 0);
    let array = |name: &str, shape: &str| -> Vec<f32> {
        let bytes = std::fs::read(text(&format!("out/{name}"))).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let described = String::from_utf8_lossy(&bytes[..header]).into_owned();
        assert!(described.contains(&format!("'shape': ({shape}, )")), "{name}: {described}");
        bytes[header..].as_chunks::<4>().0.iter().map(|value| f32::from_le_bytes(*value)).collect()
    };
    let core = array("core.npy", &format!("{a}, {b}, {c}"));
    let materials = array("materials.npy", &format!("3, {a}"));
    let outgoing = array("outgoing.npy", &format!("{NODES}, {b}"));
    let incoming = array("incoming.npy", &format!("{NODES}, {c}"));
    let orders: Vec<u32> = array("orders.npy", &format!("{c}")).iter().map(|bits| bits.to_bits()).collect();
    assert_eq!(orders, tensor.orders);
    assert_eq!(array("shares.npy", &format!("3, {NODES}, {cones}")), tensor.shares);
    assert_eq!(array("cones.npy", &format!("{cones}, 3"))[15..18], [6.0, 10.0, 0.0]);
    assert_eq!(array("even.npy", &format!("{NODES}")), [1.0; NODES]);
    assert_eq!(array("exponents.npy", "3"), [1.0, 20.0, 200.0]);
    let degrees = array("angles.npy", &format!("{NODES}"));
    for (sample, o, i, turned) in [(0, 1, 5, 0.5f32), (1, 10, 30, 3.0), (2, 29, 14, -2.0)] {
        let (mut sum, mut magnitude) = (0.0, 0.0);
        for (x, y, k) in (0..a).flat_map(|x| (0..b).flat_map(move |y| (0..c).map(move |k| (x, y, k)))) {
            let term = core[(x * b + y) * c + k] * materials[sample * a + x];
            let term = term * outgoing[o * b + y] * incoming[i * c + k];
            sum += term * (orders[k] as f32 * turned).cos();
            magnitude += term.abs();
        }
        let direction = |node: usize, azimuth: f32| {
            assert!((f64::from(degrees[node]).to_radians() - angles::theta(node)).abs() < 1e-6);
            let (sin, cos) = degrees[node].to_radians().sin_cos();
            Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
        };
        let weights = tensor.weights_of(&[(sample, 1.0)]);
        let value = tensor.residual(&weights, direction(o, 0.0), direction(i, turned));
        // Some thirty roundings, nodes are met to theirs, and rows beside them are of the same order.
        assert!((sum - value).abs() < 1e-4 * magnitude, "{sum} is not {value}");
    }
}
