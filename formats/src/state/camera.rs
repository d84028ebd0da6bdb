//! The pinhole camera.

use super::CameraState;
use crate::error::{Error, Place, Result};
use glam::{Vec3, Vec3A};
use serde::{Deserialize, Serialize};

/// A pinhole camera in world space; +Y is up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Eye point, metres.
    pub position: [f32; 3],
    /// Point looked at, metres.
    pub target: [f32; 3],
    /// Vertical field of view, degrees.
    pub fov_deg: f32,
    /// Exposure: the display shows 2^ev times the radiance.
    #[serde(default)]
    pub exposure_ev: f32,
}

/// Farthest from the origin that anything is, along an axis, metres. Products of four lengths, as in the
/// areas of triangles, squared, are then still numbers in single precision.
pub const MAX_COORDINATE: f32 = 1e9;

/// Largest exposure, either way, EV.
pub const MAX_EXPOSURE_EV: f32 = 32.0;

/// The image plane of a camera at a given size: turns film positions into directions.
#[derive(Debug, Clone, Copy)]
pub struct Film {
    /// Eye point in world space.
    pub eye_in_world: Vec3A,
    forward: Vec3A,
    right: Vec3A,
    up: Vec3A,
    width: f32,
    height: f32,
}

impl Camera {
    /// This camera with the leaves that `change` names replaced.
    pub fn with(&self, change: &CameraState, place: &Place) -> Result<Self> {
        let camera = Self {
            position: change.position.unwrap_or(self.position),
            target: change.target.unwrap_or(self.target),
            fov_deg: change.fov_deg.unwrap_or(self.fov_deg),
            exposure_ev: change.exposure_ev.unwrap_or(self.exposure_ev),
        };
        camera.validate(place)?;
        Ok(camera)
    }

    /// What undoes `change` on this camera: the leaves that it names, as they are here.
    pub fn inverse(&self, change: &CameraState) -> CameraState {
        CameraState {
            position: change.position.map(|_| self.position),
            target: change.target.map(|_| self.target),
            fov_deg: change.fov_deg.map(|_| self.fov_deg),
            exposure_ev: change.exposure_ev.map(|_| self.exposure_ev),
        }
    }

    /// Checks that the camera looks somewhere and shows something.
    pub fn validate(&self, place: &Place) -> Result<()> {
        let values: [(&str, &[f32]); 4] = [
            ("position", &self.position),
            ("target", &self.target),
            ("fov_deg", std::slice::from_ref(&self.fov_deg)),
            ("exposure_ev", std::slice::from_ref(&self.exposure_ev)),
        ];
        if let Some((key, _)) = values.iter().find(|(_, values)| !values.iter().all(|x| x.is_finite())) {
            return Err(Error::invalid(place, format!("camera: {key} is not finite; write numbers")));
        }
        if let Some(far) = self.position.iter().chain(&self.target).find(|x| x.abs() > MAX_COORDINATE) {
            return Err(Error::invalid(
                place,
                format!(
                    "camera: {far:?} m is farther from the origin than {MAX_COORDINATE:e} m; move the camera"
                ),
            ));
        }
        let way = Vec3::from(self.target) - Vec3::from(self.position);
        if way.try_normalize().is_none() {
            return Err(Error::invalid(place, "camera: position and target coincide; move one of them"));
        }
        if !(0.1..=170.0).contains(&self.fov_deg) {
            return Err(Error::invalid(
                place,
                format!("camera: fov_deg {} is outside 0.1..170", self.fov_deg),
            ));
        }
        if !(-MAX_EXPOSURE_EV..=MAX_EXPOSURE_EV).contains(&self.exposure_ev) {
            let range = format!("-{MAX_EXPOSURE_EV}..{MAX_EXPOSURE_EV}");
            return Err(Error::invalid(
                place,
                format!("camera: exposure_ev {} is outside {range}", self.exposure_ev),
            ));
        }
        Ok(())
    }

    /// The image plane at `width` × `height` pixels.
    pub fn film(&self, width: u32, height: u32) -> Film {
        let eye = Vec3::from(self.position);
        let forward = (Vec3::from(self.target) - eye).normalize_or(Vec3::NEG_Z);
        // Looking straight up or down, +Y says nothing about the roll; -Z then points up on the film.
        let up_hint = if forward.y.abs() > 0.9999 { Vec3::NEG_Z } else { Vec3::Y };
        let right = forward.cross(up_hint).normalize_or(Vec3::X);
        let half_height = (0.5 * self.fov_deg.to_radians()).tan();
        let half_width = half_height * width as f32 / height as f32;
        Film {
            eye_in_world: eye.into(),
            forward: forward.into(),
            right: (right * half_width).into(),
            up: (right.cross(forward) * half_height).into(),
            width: width as f32,
            height: height as f32,
        }
    }
}

impl Film {
    /// Forward, right and up in world space: film position (u, v), from (−1, −1) at the lower left to (1, 1)
    /// at the upper right, lies in the direction forward + u·right + v·up. The three are at right angles, and
    /// forward is of length 1.
    pub fn axes(&self) -> [Vec3A; 3] {
        [self.forward, self.right, self.up]
    }

    /// Unit direction through film position (x, y) in pixels, y downwards; (0.5, 0.5) is the centre of the
    /// first pixel.
    pub fn direction(&self, x: f32, y: f32) -> Vec3A {
        let u = 2.0 * x / self.width - 1.0;
        let v = 1.0 - 2.0 * y / self.height;
        (self.forward + self.right * u + self.up * v).normalize()
    }
}
