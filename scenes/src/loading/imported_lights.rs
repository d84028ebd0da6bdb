//! Lights of glTF nodes (KHR_lights_punctual). Candela are read as W/sr and lux as W/m².

use super::lights::finite;
use crate::geometry::{GltfFile, PlacedNode, tidy_name};
use crate::scene::{Cone, Emitter, Light};
use glam::{DAffine3, DVec3};
use gltf::khr_lights_punctual::{Kind, Light as Source};
use relume_formats::counts::{counted, one_or};
use relume_formats::state::expect_radiometric;
use relume_formats::{Error, Place, Result};
use std::f32::consts::FRAC_PI_2;

/// Every light of `nodes`, named as its node or else as itself. Adds what is ignored to `warnings`.
pub(super) fn punctual_lights(
    file: &GltfFile,
    nodes: &[PlacedNode<'_>],
    warnings: &mut Vec<String>,
) -> Result<Vec<Light>> {
    let place = Place::file(&file.path);
    let (mut lights, mut ranges) = (Vec::new(), 0);
    for (node, world_from_node) in nodes {
        let Some(source) = node.light() else { continue };
        let name =
            [node.name(), source.name()].into_iter().flatten().map(tidy_name).find(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("light-{}", source.index()));
        let place = place.part(format!("light `{name}`"));
        let Some(emitter) = emitter(&source, world_from_node, &place)? else {
            warnings.push(format!("{place}: its node's scale leaves it no direction, left it out"));
            continue;
        };
        ranges += usize::from(source.range().is_some());
        lights.push(Light { name, emitter });
    }
    if ranges > 0 {
        warnings.push(format!(
            "{place}: {ranges} of {} {} a range, which is ignored",
            counted(lights.len(), "light", "lights"),
            one_or(ranges, "has", "have")
        ));
    }
    Ok(lights)
}

/// None if the light has no direction, though it needs one.
fn emitter(source: &Source<'_>, world_from_node: &DAffine3, place: &Place) -> Result<Option<Emitter>> {
    let emission = source.color().map(|x| x * source.intensity());
    expect_radiometric(emission, "color times intensity", place)?;
    let direction = direction(world_from_node);
    Ok(match (source.kind(), direction) {
        (Kind::Point, _) => Some(Emitter::Point {
            position: finite(world_from_node.translation, place)?,
            intensity: emission,
            cone: None,
        }),
        (_, None) => None,
        (Kind::Directional, Some(direction)) => {
            Some(Emitter::Directional { direction, irradiance: emission })
        }
        (Kind::Spot { inner_cone_angle, outer_cone_angle }, Some(direction)) => {
            let cone = Some(cone(direction, inner_cone_angle, outer_cone_angle, place)?);
            Some(Emitter::Point {
                position: finite(world_from_node.translation, place)?,
                intensity: emission,
                cone,
            })
        }
    })
}

/// Where the light looks: along its node's −Z.
fn direction(world_from_node: &DAffine3) -> Option<[f32; 3]> {
    let direction = world_from_node.transform_vector3(DVec3::NEG_Z).try_normalize()?;
    Some(direction.as_vec3().to_array())
}

fn cone(direction: [f32; 3], inner: f32, outer: f32, place: &Place) -> Result<Cone> {
    // Exporters round a right angle up.
    if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 + 1e-5) {
        return Err(Error::invalid(
            place,
            format!("cone angles {inner} and {outer} must rise within 0 and π/2; mend the light"),
        ));
    }
    let cos_inner = inner.cos();
    // A hard edge, which some programs write as equal angles, is a very steep one.
    Ok(Cone { direction, cos_inner, cos_outer: outer.cos().min(cos_inner - 1e-4) })
}
