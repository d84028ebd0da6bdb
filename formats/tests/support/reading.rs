//! Reading bytes as a file of some kind, and using whatever was read.

use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{BrdfBasis, StoredScene, TransferImages};
use relume_formats::state::{Animation, BlinnPhong};
use relume_formats::{Error, Result, evaluate};
use std::path::Path;

const MATERIAL: BlinnPhong = BlinnPhong { kd: [0.5; 3], ks: [0.5; 3], shininess: 77.0 };

/// Reads `path` as `kind` and does with the value what a player does: it must neither fail nor panic.
pub fn read_and_use(kind: Kind, path: &Path) -> Result<()> {
    match kind {
        Kind::Scene => StoredScene::read_file(path).map(|scene| {
            let direction = scene.meta.camera.film(scene.meta.size[0], scene.meta.size[1]).direction(0.5, 0.5);
            assert!((direction.length() - 1.0).abs() < 1e-3);
            scene.triangles.iter().flatten().for_each(|i| assert!((*i as usize) < scene.positions.len()));
        }),
        // Its own `read_file` reads the text form.
        Kind::Animation => <Animation as Stored>::read_file(path).map(|animation| {
            for time_s in [-1.0, 0.0, 0.3, 1e9] {
                animation.sample(time_s).unwrap();
            }
        }),
        Kind::BrdfBasis => BrdfBasis::read_file(path).map(|basis| {
            assert_eq!(basis.coefficients_of(&MATERIAL).len(), basis.bases());
            let mut values = vec![0.0; basis.bases()];
            [0.0, 0.5, 1.0].iter().for_each(|cos_delta| basis.evaluate(*cos_delta, &mut values));
        }),
        Kind::TransferImages => TransferImages::read_file(path).map(|images| {
            let meta = &images.head.meta;
            // Any size up to 16384² is legal, but a film of that size is too much for a test.
            if meta.size[0] * meta.size[1] < 1 << 20 {
                let basis = super::samples::basis(1, meta.bases as usize, true);
                evaluate::transfer_images::evaluate(&images, &basis, &vec![MATERIAL; meta.materials.len()]);
            }
        }),
    }
}

/// Reads `bytes` from a file that must be refused; returns the error, which names the file.
pub fn refusal(kind: Kind, bytes: &[u8]) -> Error {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.relume");
    std::fs::write(&path, bytes).unwrap();
    let error = read_and_use(kind, &path).expect_err(kind.name());
    let message = error.to_string();
    assert!(message.starts_with(&format!("{}: ", path.display())), "`{message}` does not name the file");
    assert!(!message.contains('\n'), "`{message}` is more than a line");
    assert!(error.is_bad_input());
    error
}
