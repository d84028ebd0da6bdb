//! Material parameters and their legal range.

use super::{MaterialState, Rgb};
use crate::error::{Error, Place, Result};
use serde::{Deserialize, Serialize};

/// Smallest exponent of the Blinn-Phong space.
pub const SHININESS_MIN: f32 = 1.0;
/// Largest exponent of the Blinn-Phong space. Sharper lobes need more bases than any bake offers.
pub const SHININESS_MAX: f32 = 200.0;

/// The normalised Blinn-Phong BRDF, ρ = kd/π + ks·(s+2)/(2π)·cosˢδ with δ between the half vector and the normal
/// (thesis eq. 4-15).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BlinnPhong {
    /// Diffuse reflectance per channel.
    pub kd: Rgb,
    /// Glossy reflectance per channel.
    pub ks: Rgb,
    /// Exponent s in [`SHININESS_MIN`]..=[`SHININESS_MAX`].
    pub shininess: f32,
}

impl BlinnPhong {
    /// This material with the leaves that `change` names replaced. `name` is used in messages.
    pub fn with(&self, change: &MaterialState, name: &str, place: &Place) -> Result<Self> {
        let material = Self {
            kd: change.kd.unwrap_or(self.kd),
            ks: change.ks.unwrap_or(self.ks),
            shininess: change.shininess.unwrap_or(self.shininess),
        };
        material.validate(name, place)?;
        Ok(material)
    }

    /// Checks kd, ks ≥ 0, kd + ks ≤ 1 (thesis eq. 4-16) and the range of s.
    pub fn validate(&self, name: &str, place: &Place) -> Result<()> {
        let refuse = |reason: String| Err(Error::invalid(place, format!("material `{name}`: {reason}")));
        for (kd, ks) in self.kd.iter().zip(&self.ks) {
            if !(kd.is_finite() && ks.is_finite() && *kd >= 0.0 && *ks >= 0.0) {
                return refuse(format!("kd {:?} and ks {:?} must be numbers of at least 0", self.kd, self.ks));
            }
            // Sums such as 0.3 + 0.7 land a rounding error above 1.
            if kd + ks > 1.0 + 1e-5 {
                return refuse(format!("kd + ks = {} exceeds 1, more light than arrives; lower one of them", kd + ks));
            }
        }
        if !(SHININESS_MIN..=SHININESS_MAX).contains(&self.shininess) {
            return refuse(format!("shininess {} is outside {SHININESS_MIN}..{SHININESS_MAX}", self.shininess));
        }
        Ok(())
    }
}
