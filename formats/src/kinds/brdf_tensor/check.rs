//! What sections may hold.

use super::angles::NODES;
use super::{Cone, MAX_CONES, MAX_ORDER, MAX_PROFILES, Meta};
use crate::container::{Section, Sections};
use crate::error::Result;

/// Largest value of matrices and of the core: lobes reach 10³ sr⁻¹.
const MAX_VALUE: f32 = 1e6;
/// Largest share of a cone: a lobe of Blinn-Phong reflects up to four times what it receives from above, and some
/// more along the surface.
const MAX_SHARE: f32 = 64.0;
/// Largest standard deviation and turn of a cone, degrees: what is broader is no cone.
const MAX_ANGLE_DEG: f32 = 90.0;
/// Smallest standard deviation of a cone, degrees: maps are not filtered finer.
const MIN_WIDTH_DEG: f32 = 0.1;

pub fn fault_of(meta: &Meta) -> Option<String> {
    let Meta { residual, materials, outgoing, incoming, whole, .. } = *meta;
    let errors = [residual, materials, outgoing, incoming, whole];
    let sound = errors.iter().all(|error| error.is_finite() && *error >= 0.0);
    if !sound {
        return Some(format!("errors {errors:?} are no numbers of at least 0"));
    }
    // Rounded sums of the same squares.
    let most = residual * (1.0 + 1e-6) + 1e-9;
    let beyond = [materials, outgoing, incoming, whole].into_iter().find(|error| *error > most)?;
    Some(format!("an error of {beyond}, above what cones leave, {residual}"))
}

/// Of 1 to [`MAX_PROFILES`] profiles.
pub fn orders(section: &Section) -> Result<Vec<u32>> {
    let count = section.length()?;
    let strange = !(1..=MAX_PROFILES).contains(&count);
    section.expect(strange.then(|| format!("holds {count} profiles, 1 to {MAX_PROFILES} are allowed")))?;
    let orders = section.u32s()?;
    let beyond = orders.iter().position(|order| *order > MAX_ORDER);
    section.expect(beyond.map(|at| format!("element {at} is an order beyond {MAX_ORDER}")))?;
    Ok(orders)
}

/// The shape of the core.
pub fn ranks(core: &Section, profiles: usize) -> Result<[usize; 3]> {
    match core.info.shape[..] {
        [a, b, c]
            if (1..=MAX_PROFILES).contains(&a) && (1..=NODES as u64).contains(&b) && c == profiles as u64 =>
        {
            Ok([a, b, c].map(|rank| rank as usize))
        }
        _ => Err(core.invalid(format!(
            "has shape {:?}, expected 1 to {MAX_PROFILES}, 1 to {NODES} and {profiles}",
            core.info.shape
        ))),
    }
}

pub fn bounded(section: &Section) -> Result<Vec<f32>> {
    let values = section.f32s()?;
    section.expect_at_most(&values, MAX_VALUE)?;
    Ok(values)
}

pub fn matrix(sections: &mut Sections<'_>, name: &str, shape: [u64; 2]) -> Result<Vec<f32>> {
    let section = sections.take(name)?;
    section.expect_shape(&shape)?;
    bounded(&section)
}

/// 1 to [`MAX_CONES`] of them.
pub fn cones(section: &Section) -> Result<Vec<Cone>> {
    let count = section.info.shape.first().copied().unwrap_or(0);
    let strange = !(1..=MAX_CONES).contains(&count);
    section.expect(strange.then(|| format!("holds {count} cones, 1 to {MAX_CONES} are allowed")))?;
    let rows = section.f32_rows::<3>()?;
    section.expect_at_most(rows.as_flattened(), MAX_ANGLE_DEG)?;
    let legal = |[width, _, side]: &[f32; 3]| *width >= MIN_WIDTH_DEG && *side >= 0.0;
    let strange = rows.iter().position(|row| !legal(row));
    section.expect(strange.map(|at| {
        format!("cone {at} is narrower than {MIN_WIDTH_DEG} degrees, or its sides are turned by less than 0")
    }))?;
    let cone = |[width_deg, tilt_deg, side_deg]: [f32; 3]| Cone { width_deg, tilt_deg, side_deg };
    Ok(rows.into_iter().map(cone).collect())
}

pub fn shares(section: &Section) -> Result<Vec<f32>> {
    let shares = section.f32s()?;
    section.expect_at_most(&shares, MAX_SHARE)?;
    let negative = shares.iter().position(|share| *share < 0.0);
    section.expect(negative.map(|at| format!("element {at} is a share below 0")))?;
    Ok(shares)
}

pub fn even(section: &Section) -> Result<Vec<f32>> {
    section.expect_shape(&[NODES as u64])?;
    let even = section.f32s()?;
    section.expect_finite(&even)?;
    // A mean of at most 1, in single precision.
    let strange = even.iter().position(|value| !(0.0..=1.0 + 1e-5).contains(value));
    section.expect(strange.map(|at| format!("element {at} is no share of 0 to 1")))?;
    Ok(even)
}
