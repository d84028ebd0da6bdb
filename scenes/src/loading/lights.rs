//! `[[light]]`. In its own space a light emits along −Z, as in glTF; an area light is the unit square in z =
//! 0.

use super::{Context, expect_unique};
use crate::description::{LightFile, LightKind};
use crate::numbering::{listed, numbered};
use crate::scene::{Emitter, Light};
use crate::transform::is_mirroring;
use glam::{DAffine3, DVec3, Vec3};
use relume_formats::state::{Rgb, expect_radiometric};
use relume_formats::{Error, Place, Result};

/// Every light, in file order, then the imported ones; those whose name is taken are numbered.
pub(super) fn build(
    files: &[LightFile],
    imported: Vec<Light>,
    context: &mut Context<'_>,
) -> Result<Vec<Light>> {
    expect_unique(files.iter().map(|l| l.name.as_str()), "light", &context.place)?;
    let lights = files.iter().map(|file| light(file, &context.place.part(format!("light `{}`", file.name))));
    let mut lights = lights.collect::<Result<Vec<_>>>()?;
    let wanted = lights.iter().chain(&imported).map(|light| light.name.clone());
    let (names, changed) = numbered(wanted);
    if !changed.is_empty() {
        context.warnings.push(format!(
            "{}: names of lights repeat; numbered {}",
            context.place,
            listed(&changed)
        ));
    }
    let described = lights.len();
    lights.extend(
        imported
            .into_iter()
            .zip(names.into_iter().skip(described))
            .map(|(light, name)| Light { name, ..light }),
    );
    Ok(lights)
}

fn light(file: &LightFile, place: &Place) -> Result<Light> {
    let emission = emission(file, place)?;
    let world_from_local = file.transform.world_from_local(place)?;
    let emitter = match file.kind {
        LightKind::Area => area(&world_from_local, emission, place)?,
        LightKind::Point => Emitter::Point {
            position: finite(world_from_local.translation, place)?,
            intensity: emission,
            cone: None,
        },
        LightKind::Directional => {
            let direction = world_from_local.transform_vector3(DVec3::NEG_Z).try_normalize();
            let direction = direction
                .ok_or_else(|| Error::invalid(place, "a scale of 0 leaves no direction; remove it"))?;
            Emitter::Directional { direction: direction.as_vec3().to_array(), irradiance: emission }
        }
    };
    Ok(Light { name: file.name.clone(), emitter })
}

/// The one quantity that fits the kind of light.
fn emission(file: &LightFile, place: &Place) -> Result<Rgb> {
    let given = [("radiance", file.radiance), ("intensity", file.intensity), ("irradiance", file.irradiance)];
    let (kind, fitting) = match file.kind {
        LightKind::Area => ("an area", "radiance"),
        LightKind::Point => ("a point", "intensity"),
        LightKind::Directional => ("a directional", "irradiance"),
    };
    if let Some((stranger, _)) = given.iter().find(|(name, value)| *name != fitting && value.is_some()) {
        return Err(Error::invalid(
            place,
            format!("{kind} light is measured by `{fitting}`, not by `{stranger}`"),
        ));
    }
    let value = given.into_iter().find_map(|(_, value)| value);
    let value = value.ok_or_else(|| Error::invalid(place, format!("{kind} light needs `{fitting}`")))?;
    expect_radiometric(value, fitting, place)?;
    Ok(value)
}

fn area(world_from_local: &DAffine3, radiance: Rgb, place: &Place) -> Result<Emitter> {
    let corner = finite(world_from_local.transform_point3(DVec3::new(-0.5, -0.5, 0.0)), place)?;
    let x = Vec3::from(finite(world_from_local.matrix3.x_axis, place)?);
    let y = Vec3::from(finite(world_from_local.matrix3.y_axis, place)?);
    // y × x points along −z in a right-handed space.
    let (edge_u, edge_v) = if is_mirroring(world_from_local) { (x, y) } else { (y, x) };
    let area = edge_u.cross(edge_v).length();
    if !(area.is_finite() && area > f32::MIN_POSITIVE) {
        return Err(Error::invalid(
            place,
            format!("its area is {area} m²; give it a scale above 0 along x and y"),
        ));
    }
    Ok(Emitter::Area { corner, edge_u: edge_u.to_array(), edge_v: edge_v.to_array(), radiance })
}

/// A vector that single precision holds.
pub(super) fn finite(v: DVec3, place: &Place) -> Result<[f32; 3]> {
    let v = v.as_vec3();
    if v.is_finite() {
        Ok(v.to_array())
    } else {
        Err(Error::invalid(place, "transform: too large for single precision"))
    }
}
