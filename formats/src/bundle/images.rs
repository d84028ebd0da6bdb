//! Images against the basis that they stand on and the scene that they show.

use super::refuse;
use crate::error::{Place, Result};
use crate::kinds::BrdfBasis;
use crate::kinds::region_images;
use crate::kinds::scene::{self, StoredMaterial};
use crate::kinds::transfer_images::Head;
use std::collections::{HashMap, HashSet};

/// Fails unless size, bases and materials of the images at `place` are those of `basis` and `scene`: a
/// material has images exactly if it varies.
pub fn expect_images(head: &Head, basis: &BrdfBasis, scene: &scene::Meta, place: &Place) -> Result<()> {
    let meta = &head.meta;
    expect_shown((meta.size, meta.bases, &meta.materials), basis, scene, place)
}

/// The same of the images of regions.
pub fn expect_regions(
    head: &region_images::Head,
    basis: &BrdfBasis,
    scene: &scene::Meta,
    place: &Place,
) -> Result<()> {
    let meta = &head.meta;
    expect_shown((meta.size, meta.bases, &meta.materials), basis, scene, place)
}

fn expect_shown(
    (size, bases, materials): ([u32; 2], u32, &[String]),
    basis: &BrdfBasis,
    scene: &scene::Meta,
    place: &Place,
) -> Result<()> {
    let place = place.part("section `meta`");
    if size != scene.size {
        return refuse(&place, format!("film size {size:?}, the scene's is {:?}", scene.size));
    }
    if bases as usize != basis.bases() {
        return refuse(&place, format!("{bases} bases, the BRDF basis has {}", basis.bases()));
    }
    let known: HashMap<&str, &StoredMaterial> =
        scene.materials.iter().map(|m| (m.name.as_str(), m)).collect();
    for name in materials {
        match known.get(name.as_str()) {
            Some(material) if material.varies && material.brdf.model() != basis.functions.model() => {
                return refuse(&place, format!("material `{name}` is of another model than the BRDF basis"));
            }
            Some(material) if material.varies && !basis.spans(material.sharpest) => {
                let [of_scene, of_basis] = [material.sharpest, basis.sharpest()];
                let reason = format!("material `{name}` goes up to {of_scene}, the BRDF basis to {of_basis}");
                return refuse(&place, reason);
            }
            Some(material) if material.varies => {}
            Some(_) => return refuse(&place, format!("material `{name}` does not vary in the scene")),
            None => return refuse(&place, format!("material `{name}` is not in the scene")),
        }
    }
    let shown: HashSet<&str> = materials.iter().map(String::as_str).collect();
    match scene.materials.iter().find(|m| m.varies && !shown.contains(m.name.as_str())) {
        Some(left_out) => refuse(
            &place,
            format!("material `{}` varies in the scene, but there are no images of it", left_out.name),
        ),
        None => Ok(()),
    }
}
