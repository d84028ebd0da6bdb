//! Reading bytes as a file of some kind, and using whatever was read.

use super::playing::{
    play_animation, play_basis, play_environment, play_images, play_received, play_regions, play_rows,
    play_scene, play_shadows, play_shape, play_spheres, play_table, play_tensor, play_textures,
    play_visibility,
};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{
    BrdfBasis, BrdfTensor, Environment, HaarTable, RegionImages, SparseTransfer, SphereSet, SphereShadows,
    StoredScene, Textures, TransferImages, TransferTensor, VisibilityTable,
};
use relume_formats::shape::DeformingMesh;
use relume_formats::state::Animation;
use relume_formats::{Error, Result};
use std::path::Path;

/// Reads `path` as `kind` and does with the value what a player does: it must neither fail nor panic.
pub fn read_and_use(kind: Kind, path: &Path) -> Result<()> {
    match kind {
        Kind::Scene => StoredScene::read_file(path).map(|scene| play_scene(&scene)),
        // Its own `read_file` reads the text form.
        Kind::Animation => <Animation as Stored>::read_file(path).map(|animation| play_animation(&animation)),
        Kind::BrdfBasis => BrdfBasis::read_file(path).map(|basis| play_basis(&basis)),
        Kind::TransferImages => TransferImages::read_file(path).map(|images| play_images(&images)),
        Kind::RegionImages => RegionImages::read_file(path).map(|images| play_regions(&images)),
        Kind::HaarTable => HaarTable::read_file(path).map(|table| play_table(&table)),
        Kind::Environment => Environment::read_file(path).map(|environment| play_environment(&environment)),
        Kind::Textures => Textures::read_file(path).map(|textures| play_textures(&textures)),
        Kind::SparseTransfer => SparseTransfer::read_file(path).map(|transfer| play_rows(&transfer)),
        Kind::SphereSet => SphereSet::read_file(path).map(|set| play_spheres(&set)),
        Kind::Shape => DeformingMesh::read_file(path).map(|shape| play_shape(&shape)),
        Kind::VisibilityTable => VisibilityTable::read_file(path).map(|table| play_visibility(&table)),
        Kind::BrdfTensor => BrdfTensor::read_file(path).map(|tensor| play_tensor(&tensor)),
        Kind::TransferTensor => TransferTensor::read_file(path).map(|tensors| play_received(&tensors)),
        Kind::SphereShadows => SphereShadows::read_file(path).map(|shadows| play_shadows(&shadows)),
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
