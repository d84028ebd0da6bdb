//! Kind `environment`, version 0: light from all directions, infinitely far away, as an equirectangular map.
//!
//! | section  | type | shape              | content |
//! |----------|------|--------------------|---------|
//! | `meta`   | u8   | record             | [`Meta`]: name and unit |
//! | `texels` | f16  | [height, width, 3] | linear RGB radiance in [`Meta::unit`] W/(sr·m²), rows from +Y down; 0 to [`MAX_RADIANCE`] |
//!
//! The direction (x, y, z) is found at u = 0.5 + atan2(x, −z)/2π, v = acos(y)/π.

use super::names::fault_of_name;
use crate::basis::EquirectMap;
use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::{Error, Place, Result};
use half::f16;
use serde::{Deserialize, Serialize};

/// Largest width of a stored map; the height is at most as large. Lights are a few texels a degree,
/// backgrounds a little more.
pub const MAX_WIDTH: u32 = 4096;

/// Width to which maps are brought that are wider before a bundle or a player keeps them: light needs less,
/// and a background hardly more.
pub const KEPT_WIDTH: u32 = 2048;

/// Largest radiance of a map, W/(sr·m²): that of lights in scenes, fifty thousand times the sun's.
pub const MAX_RADIANCE: f32 = 1e12;

/// A named map.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Name, unique in a bundle: the file's that it came from.
    pub name: String,
    /// The map.
    pub map: EquirectMap,
}

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Meta {
    name: String,
    /// Factor on the stored halves, a power of two.
    unit: f32,
}

/// The power of two that brings `largest` within half precision; 1 for all that is within it already.
fn unit_for(largest: f32) -> f32 {
    if largest <= f16::MAX.to_f32() { 1.0 } else { (largest / f16::MAX.to_f32()).log2().ceil().exp2() }
}

impl Environment {
    /// A map of any size as bundles and players keep it: no wider than [`KEPT_WIDTH`], and rounded to halves.
    pub fn kept(name: String, map: &EquirectMap) -> Self {
        Self { name, map: map.reduced(KEPT_WIDTH) }.rounded()
    }

    /// The map as it is after storing: rounded to halves.
    pub fn rounded(&self) -> Self {
        let (unit, halves) = self.halves();
        let texels = halves.as_chunks().0.iter().map(|t| t.map(|h| h.to_f32() * unit)).collect();
        Self { name: self.name.clone(), map: EquirectMap { texels, ..self.map } }
    }

    /// Checks what reading checks, of a map that is yet to be written.
    ///
    /// # Errors
    /// `Invalid` with what is wrong.
    pub fn validate(&self, place: &Place) -> Result<()> {
        self.fault().map_or(Ok(()), |fault| {
            Err(Error::invalid(place, format!("environment map `{}`: {fault}", self.name)))
        })
    }

    /// Checks the map, whatever its name.
    ///
    /// # Errors
    /// `Invalid` with what is wrong.
    pub fn validate_map(&self, place: &Place) -> Result<()> {
        self.fault_of_map()
            .map_or(Ok(()), |fault| Err(Error::invalid(place, format!("{fault}; mend or scale the picture"))))
    }

    fn fault(&self) -> Option<String> {
        fault_of_name("the map", &self.name).or_else(|| self.fault_of_map())
    }

    fn fault_of_map(&self) -> Option<String> {
        let EquirectMap { width, height, texels } = &self.map;
        if ![width, height].iter().all(|n| (1..=MAX_WIDTH).contains(*n)) {
            return Some(format!("{width}×{height} texels, 1 to {MAX_WIDTH} along each side are possible"));
        }
        // Rounding to halves may have made the largest larger, by 2⁻¹¹ of it.
        let legal = 0.0..=MAX_RADIANCE * 1.001;
        let sound = texels.as_flattened().iter().all(|radiance| legal.contains(radiance));
        (!sound).then(|| format!("a radiance is outside 0..{MAX_RADIANCE:e}"))
    }

    /// The unit, a power of two, and the texels as halves in it, row-major [height, width, 3]: what is
    /// stored.
    pub fn halves(&self) -> (f32, Vec<f16>) {
        let values = self.map.texels.as_flattened();
        let unit = unit_for(values.iter().copied().fold(0.0, f32::max));
        (unit, values.iter().map(|v| f16::from_f32(v / unit)).collect())
    }
}

impl Stored for Environment {
    const KIND: Kind = Kind::Environment;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let (unit, halves) = self.halves();
        out.record("meta", &Meta { name: self.name.clone(), unit })?;
        out.f16s("texels", &[self.map.height.into(), self.map.width.into(), 3], &halves)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Meta = section.record()?;
        if !(meta.unit.is_finite() && meta.unit >= 1.0 && meta.unit.log2().fract() == 0.0) {
            return Err(section.invalid(format!("unit {} is no power of two of at least 1", meta.unit)));
        }
        let section = sections.take("texels")?;
        let (width, height) = match section.info.shape[..] {
            [height, width, 3] => u32::try_from(width).ok().zip(u32::try_from(height).ok()),
            _ => None,
        }
        .ok_or_else(|| {
            section.invalid(format!("has shape {:?}, expected [height, width, 3]", section.info.shape))
        })?;
        let values: Vec<f32> = section.f16s()?.iter().map(|h| h.to_f32() * meta.unit).collect();
        let environment = Self {
            name: meta.name,
            map: EquirectMap { width, height, texels: values.as_chunks().0.to_vec() },
        };
        section.expect(environment.fault())?;
        Ok(environment)
    }
}
