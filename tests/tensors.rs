//! Tensors of BRDF spaces, from bake's library to what users see of their files.

use crate::support::{expect_exit, run};
use relume_bake::brdf::tensor::{Separation, SpaceTensor};
use relume_formats::basis::disc::{self, CELLS, RINGS};
use relume_formats::container::Stored as _;
use relume_formats::kinds::brdf_tensor::Samples;
use relume_formats::state::Model;
use serde_json::Value;
use std::path::Path;

/// The arrays of an export alone say the same lobes as the file.
#[test]
fn exported_arrays_are_the_lobe() {
    let samples = Samples::Line(vec![1.0, 20.0, 200.0]);
    let space = SpaceTensor::new(Model::BlinnPhong, samples, &Separation::default());
    let (tensor, _) = space.decomposed([2, 3, 4]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let text = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let file = text("phong.relume");
    tensor.write_file(Path::new(&file)).unwrap();

    expect_exit("bake", &["verify", &file], 0);
    let info: Value = serde_json::from_slice(&run("bake", &["info", &file, "--json"]).stdout).unwrap();
    assert_eq!((&info["kind"], &info["details"]["ranks"]), (&"brdf-tensor".into(), &[2, 3, 4][..].into()));
    assert_eq!(info["details"]["whole"].as_f64().unwrap(), tensor.meta.whole);
    let told = String::from_utf8(run("bake", &["info", &file]).stdout).unwrap();
    assert!(told.contains("2 of materials, 3 of outgoing and 4 of incoming directions"), "{told}");

    expect_exit("bake", &["export", &file, "-o", &text("out")], 0);
    let array = |name: &str, shape: &str| -> Vec<f32> {
        let bytes = std::fs::read(text(&format!("out/{name}"))).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let described = String::from_utf8_lossy(&bytes[..header]).into_owned();
        assert!(described.contains(&format!("'shape': ({shape}, )")), "{name}: {described}");
        bytes[header..].as_chunks::<4>().0.iter().map(|value| f32::from_le_bytes(*value)).collect()
    };
    let terms = tensor.widths_deg.len();
    let core = array("core.npy", "2, 3, 4");
    let materials = array("materials.npy", "3, 2");
    let outgoing = array("outgoing.npy", &format!("{CELLS}, 3"));
    let incoming = array("incoming.npy", &format!("{CELLS}, 5"));
    assert_eq!(array("mirror.npy", &format!("3, {RINGS}, {terms}")), tensor.mirror);
    assert_eq!(array("exponents.npy", "3"), [1.0, 20.0, 200.0]);
    for (sample, o, i) in [(0, 0, 5), (1, 100, 300), (2, CELLS - 1, 40)] {
        let (mut sum, mut magnitude) = (0.0, 0.0);
        for (a, b, c) in (0..24).map(|at| (at / 12, at / 4 % 3, at % 4)) {
            let term = core[12 * a + 4 * b + c] * materials[2 * sample + a];
            let term = term * outgoing[3 * o + b] * incoming[5 * i + 1 + c];
            (sum, magnitude) = (sum + term, magnitude + term.abs());
        }
        let core = tensor.core_of(&[(sample, 1.0)]);
        let value = tensor.residual(&core, disc::direction(o), disc::direction(i));
        // Some thirty roundings, and nodes are met to theirs.
        assert!((sum - value).abs() < 1e-5 * magnitude, "{sum} is not {value}");
    }
}
