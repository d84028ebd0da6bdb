//! `[materials]`, and those that glTF files bring.

use super::Context;
use crate::description::{BrdfName, MaterialFile, VaryFile};
use crate::library::{expect_file, locate};
use crate::scene::Material;
use crate::suggest::unknown_name;
use relume_formats::basis::Texture;
use relume_formats::state::{
    ASKED_ROUGHNESS_MIN, BlinnPhong, Brdf, CookTorrance, DIELECTRIC_F0, FIXED_ROUGHNESS_MIN, Ggx,
    MaterialState, ROUGHNESS_MIN,
};
use relume_formats::{Error, Place, Result};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// Every material, sorted by name. One with a `brdf` replaces an imported one of its name, one without
/// changes it.
pub(super) fn build(
    files: &BTreeMap<String, MaterialFile>,
    imported: Vec<Material>,
    vary: &VaryFile,
    context: &mut Context<'_>,
) -> Result<Vec<Material>> {
    let mut materials: BTreeMap<String, Material> =
        imported.into_iter().map(|m| (m.name.clone(), m)).collect();
    let varying: HashSet<&str> = vary.materials.iter().map(String::as_str).collect();
    let least_varying = vary.roughness_min.unwrap_or(ROUGHNESS_MIN);
    for material in materials.values_mut() {
        let roughness_given =
            files.get(&material.name).is_some_and(|file| file.brdf.is_some() || file.roughness.is_some());
        if !roughness_given {
            let varies = varying.contains(material.name.as_str()).then_some(least_varying);
            raise_roughness(material, varies, context);
        }
    }
    for (name, file) in files {
        let material = match (file.brdf, materials.get(name)) {
            (Some(model), _) => described(name, file, model, context)?,
            (None, Some(imported)) => changed(imported, file, &context.place)?,
            (None, None) => {
                let unknown =
                    unknown_name("material of a glTF file", name, materials.keys().map(String::as_str));
                return Err(Error::invalid(
                    &context.place,
                    format!("material `{name}`: has no `brdf`, and there is {unknown}; add one"),
                ));
            }
        };
        materials.insert(name.clone(), material);
    }
    Ok(materials.into_values().collect())
}

/// Checks what can be checked before any file is read.
pub(super) fn check(files: &BTreeMap<String, MaterialFile>, place: &Place) -> Result<()> {
    let wrong = files
        .iter()
        .find_map(|(name, file)| Some((name, file.emission.filter(|x| !(x.is_finite() && *x >= 0.0))?)));
    wrong.map_or(Ok(()), |(name, emission)| {
        let place = place.part(format!("material `{name}`"));
        Err(Error::invalid(
            &place,
            format!("emission {emission} must be a number of 0 or more; it scales what the material emits"),
        ))
    })
}

fn described(
    name: &str,
    file: &MaterialFile,
    model: BrdfName,
    context: &mut Context<'_>,
) -> Result<Material> {
    let default = match model {
        BrdfName::BlinnPhong => Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.0; 3], shininess: 10.0 }),
        BrdfName::Ggx => Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.0, roughness: 0.5 }),
        BrdfName::CookTorrance => Brdf::CookTorrance(CookTorrance {
            kd: [0.5; 3],
            ks: [0.0; 3],
            fresnel: DIELECTRIC_F0,
            roughness: 0.3,
        }),
    };
    let brdf = default.with(&leaves(file), name, &context.place)?;
    let place = context.place.part(format!("material `{name}`"));
    if file.emission.is_some() {
        let reason = "`emission` scales what a material of a glTF file emits, but a material with `brdf` is described whole; remove one of them";
        return Err(Error::invalid(&place, reason));
    }
    let texture =
        file.texture.as_deref().map(|texture| read_texture(texture, &place, context)).transpose()?;
    let alpha_cutoff = alpha_cutoff(file, &place)?;
    Ok(Material { name: name.to_owned(), brdf, texture, paint: None, alpha_cutoff })
}

fn read_texture(name: &str, place: &Place, context: &mut Context<'_>) -> Result<Arc<Texture>> {
    let path = locate(context.folder, name);
    expect_file(&path, name, place)?;
    context.textures.read(&path)
}

fn alpha_cutoff(file: &MaterialFile, place: &Place) -> Result<Option<f32>> {
    match file.alpha_cutoff {
        Some(_) if file.texture.is_none() => {
            Err(Error::invalid(place, "alpha_cutoff needs a `texture` whose alpha it cuts; add or remove it"))
        }
        Some(cutoff) if !(cutoff > 0.0 && cutoff <= 1.0) => {
            Err(Error::invalid(place, format!("alpha_cutoff {cutoff} must be above 0 and at most 1")))
        }
        cutoff => Ok(cutoff),
    }
}

/// An imported material with other leaves; its texture stays.
fn changed(imported: &Material, file: &MaterialFile, place: &Place) -> Result<Material> {
    if file.texture.is_some() || file.alpha_cutoff.is_some() {
        let reason = "`texture` and `alpha_cutoff` belong to a material that is described whole; add `brdf` and the other keys";
        return Err(Error::invalid(&place.part(format!("material `{}`", imported.name)), reason));
    }
    Ok(Material { brdf: imported.brdf.with(&leaves(file), &imported.name, place)?, ..imported.clone() })
}

fn leaves(file: &MaterialFile) -> MaterialState {
    MaterialState {
        kd: file.kd,
        ks: file.ks,
        shininess: file.shininess,
        fresnel: file.fresnel,
        base_color: file.base_color,
        metallic: file.metallic,
        roughness: file.roughness,
        ..MaterialState::default()
    }
}

/// Other programs' files are often smoother than what is modelled; they are shown as smooth as it gets, which is
/// `varying` for a material that varies.
fn raise_roughness(material: &mut Material, varying: Option<f32>, context: &mut Context<'_>) {
    let Brdf::Ggx(ggx) = &mut material.brdf else { return };
    let (least, kind) = varying.map_or((FIXED_ROUGHNESS_MIN, "does not vary"), |least| (least, "varies"));
    if ggx.roughness < least {
        let may_be_asked_for = varying.is_some_and(|least| least > ASKED_ROUGHNESS_MIN);
        let more = if may_be_asked_for {
            format!("; [vary] roughness_min lets transfer-images go down to {ASKED_ROUGHNESS_MIN}")
        } else {
            String::new()
        };
        let (place, name, given) = (&context.place, &material.name, ggx.roughness);
        context
            .warnings
            .push(format!("{place}: material `{name}` {kind}: raised its roughness from {given} to {least}, the least of one that {kind}{more}"));
        ggx.roughness = least;
    }
}
