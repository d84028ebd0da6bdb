//! `[materials]`.

use crate::description::{BrdfName, MaterialFile};
use crate::scene::Material;
use relume_formats::state::BlinnPhong;
use relume_formats::{Error, Place, Result};
use std::collections::BTreeMap;

/// Every material, sorted by name.
pub(super) fn build(files: &BTreeMap<String, MaterialFile>, place: &Place) -> Result<Vec<Material>> {
    files.iter().map(|(name, file)| Ok(Material { name: name.clone(), brdf: brdf(name, file, place)? })).collect()
}

fn brdf(name: &str, file: &MaterialFile, place: &Place) -> Result<BlinnPhong> {
    if file.brdf == BrdfName::Ggx {
        return Err(Error::unsupported(place, format!("material `{name}`: brdf \"ggx\" is not modelled yet; use \"blinn-phong\"")));
    }
    for (key, given) in [("base_color", &file.base_color), ("metallic", &file.metallic), ("roughness", &file.roughness)] {
        if given.is_some() {
            let reason = format!("material `{name}`: `{key}` belongs to \"ggx\"; \"blinn-phong\" has kd, ks and shininess");
            return Err(Error::invalid(place, reason));
        }
    }
    let brdf = BlinnPhong { kd: file.kd.unwrap_or([0.5; 3]), ks: file.ks.unwrap_or([0.0; 3]), shininess: file.shininess.unwrap_or(10.0) };
    brdf.validate(name, place)?;
    Ok(brdf)
}
