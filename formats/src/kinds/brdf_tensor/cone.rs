//! Where the Gaussians are that stand for most of a lobe.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// One Gaussian of the angle, or two that share alike, about the mirror direction or off it. A sharp lobe seen
/// along the surface is an ellipse and leans towards it, which a few round ones beside each other follow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cone {
    /// Standard deviation, degrees.
    pub width_deg: f32,
    /// How far it is turned from the mirror direction away from the normal, in the plane of incidence, degrees;
    /// below 0 towards the normal.
    pub tilt_deg: f32,
    /// How far two are turned to either side of that, degrees; 0 for a single one.
    pub side_deg: f32,
}

impl Cone {
    /// The middles of its one or two Gaussians, seen from `outgoing`; unit vectors in the frame of the surface,
    /// whose normal is +Z. They may point below it. Seen along the normal, the plane of incidence is that of X.
    pub fn directions(&self, outgoing: Vec3) -> impl Iterator<Item = Vec3> {
        let flat = outgoing.truncate();
        let away = -flat.normalize_or(glam::Vec2::X);
        let (sin, cos) = (flat.length().atan2(outgoing.z) + self.tilt_deg.to_radians()).sin_cos();
        let middle = (away * sin).extend(cos);
        let (aside, along) = self.side_deg.to_radians().sin_cos();
        let across = Vec3::new(-away.y, away.x, 0.0) * aside;
        let both = [middle * along + across, middle * along - across];
        both.into_iter().take(self.count())
    }

    /// How many Gaussians there are, 1 or 2.
    pub fn count(&self) -> usize {
        if self.side_deg == 0.0 { 1 } else { 2 }
    }
}
