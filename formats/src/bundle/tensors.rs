//! Tensors against the BRDF spaces and bases before them, and against the scene.

use super::refuse;
use crate::error::{Place, Result};
use crate::kinds::transfer_tensor::{Meta, Source};
use crate::kinds::{BrdfBasis, BrdfTensor, scene};
use crate::state::Model;

/// Fails unless there is one space of `spaces` for the model of each material that an object of `scene` has, within the
/// columns of the tensors at `place`, and for each source of reflected light the basis of a material that varies.
pub fn expect_tensors(
    meta: &Meta,
    spaces: &[BrdfTensor],
    bases: &[BrdfBasis],
    scene: &scene::Meta,
    place: &Place,
) -> Result<()> {
    let models: Vec<Model> = spaces.iter().map(|space| space.meta.model).collect();
    let of_bases: Vec<Model> = bases.iter().map(|basis| basis.functions.model()).collect();
    for (what, models) in [("BRDF space", &models), ("BRDF basis", &of_bases)] {
        if let Some(twice) = models.iter().enumerate().find(|(at, model)| models[..*at].contains(model)) {
            return refuse(place, format!("comes after a second {what} of model \"{}\"", twice.1.name()));
        }
    }
    let worn = scene.objects.iter().filter_map(|object| scene.materials.get(object.material as usize));
    let mut without = worn.filter(|material| !models.contains(&material.brdf.model()));
    if let Some(material) = without.next() {
        let (name, model) = (&material.name, material.brdf.model().name());
        return refuse(
            place,
            format!("needs a BRDF space of model \"{model}\" before it: `{name}` is of it"),
        );
    }
    if let Some(space) = spaces.iter().find(|space| space.columns() > meta.columns as usize) {
        let (columns, there) = (space.columns(), meta.columns);
        return refuse(place, format!("has {there} columns, a BRDF space before it needs {columns}"));
    }
    meta.sources.iter().try_for_each(|source| expect_source(source, bases, scene, place))
}

fn expect_source(source: &Source, bases: &[BrdfBasis], scene: &scene::Meta, place: &Place) -> Result<()> {
    let Some(index) = source.material else { return Ok(()) };
    let Some(material) = scene.materials.get(index as usize).filter(|material| material.varies) else {
        return refuse(
            place,
            format!("has light of material {index}, which the scene does not have or vary"),
        );
    };
    let model = material.brdf.model();
    let basis = bases.iter().find(|basis| basis.functions.model() == model);
    match basis.filter(|basis| (source.basis as usize) < basis.bases()) {
        Some(_) => Ok(()),
        None => refuse(
            place,
            format!(
                "needs function {} of a BRDF basis of model \"{}\" before it",
                source.basis,
                model.name()
            ),
        ),
    }
}
