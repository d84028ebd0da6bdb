//! Tensors against the BRDF spaces and bases that they stand on, and the scene.

use super::refuse;
use crate::error::{Place, Result};
use crate::kinds::scene::StoredMaterial;
use crate::kinds::transfer_tensor::{Meta, Source};
use crate::kinds::{BrdfBasis, BrdfTensor, scene};
use crate::state::Model;

/// Fails unless materials of `scene` are no sharper than usual, there is one of `spaces` for every model that objects
/// wear, none has more columns than there are, and what reflects light, by the tensors
/// at `place`, are functions of `bases` for materials that vary.
pub fn expect_spaces(
    meta: &Meta,
    spaces: &[BrdfTensor],
    bases: &[BrdfBasis],
    scene: &scene::Meta,
    place: &Place,
) -> Result<()> {
    let usual = |material: &StoredMaterial| material.brdf.model().usual_sharpest();
    if let Some(material) = scene.materials.iter().find(|m| m.varies && m.sharpest != usual(m)) {
        let (name, sharpest, spanned) = (&material.name, material.sharpest, usual(material));
        return refuse(
            place,
            format!("material `{name}` goes up to {sharpest}, the BRDF tensors before it to {spanned}"),
        );
    }
    for (number, space) in spaces.iter().enumerate() {
        if spaces[..number].iter().any(|other| other.meta.model == space.meta.model) {
            return refuse(place, format!("has two BRDF tensors of {} before it", space.meta.model.name()));
        }
    }
    let worn = scene.objects.iter().filter_map(|object| scene.materials.get(object.material as usize));
    let lacks = |model: Model| spaces.iter().all(|space| space.meta.model != model);
    if let Some(material) = worn.into_iter().find(|material| lacks(material.brdf.model())) {
        let (name, model) = (&material.name, material.brdf.model().name());
        return refuse(
            place,
            format!("has no BRDF tensor of {model} before it, which material `{name}` is of"),
        );
    }
    if let Some(space) = spaces.iter().find(|space| space.columns() > meta.columns as usize) {
        let (needed, there) = (space.columns(), meta.columns);
        return refuse(place, format!("has {there} columns, a BRDF tensor before it needs {needed}"));
    }
    let fault = meta.sources.iter().find_map(|source| fault_of(source, bases, scene));
    fault.map_or(Ok(()), |fault| refuse(&place.part("section `meta`"), fault))
}

fn fault_of(source: &Source, bases: &[BrdfBasis], scene: &scene::Meta) -> Option<String> {
    let index = source.material? as usize;
    let Some(material) = scene.materials.get(index) else {
        return Some(format!("light is reflected by material {index}, which is not there"));
    };
    let name = &material.name;
    if !material.varies {
        return Some(format!("light is reflected by functions of material `{name}`, which does not vary"));
    }
    let basis = bases.iter().find(|basis| basis.functions.model() == material.brdf.model());
    let there = basis.map_or(0, BrdfBasis::bases);
    (source.basis as usize >= there).then(|| {
        format!(
            "light is reflected by function {} of material `{name}`, whose BRDF basis has {there}",
            source.basis
        )
    })
}
