//! Where the camera stands, and how large the ground is.

use super::placing::Placing;

/// Vertical field of view, degrees: that of a short telephoto lens.
pub(super) const FOV_DEG: f64 = 36.0;
/// How far above the horizon, and to the right of the model's front, which is +Z in glTF, the camera stands,
/// degrees.
const ELEVATION_DEG: f64 = 25.0;
const AZIMUTH_DEG: f64 = 30.0;
/// The sphere about the model fills this part of the film's height.
const FILLED: f64 = 0.9;
/// Side of the ground in radii: all that the camera sees is ground.
const GROUND: f64 = 40.0;
/// Side of a ground that is fine enough for light that is computed at 97 × 97 vertices, in radii.
const SMALL_GROUND: f64 = 8.0;
/// How far the ground is below the model, in radii: surfaces in one plane hide each other in spots.
const GAP: f64 = 1e-3;

/// Camera and ground; metres.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Framing {
    pub position: [f64; 3],
    pub target: [f64; 3],
    pub ground: f64,
    pub small_ground: f64,
    pub ground_y: f64,
}

impl Framing {
    /// For a model that stands so.
    pub fn new(placing: &Placing) -> Self {
        let (elevation, azimuth) = (ELEVATION_DEG.to_radians(), AZIMUTH_DEG.to_radians());
        // A sphere whose tangents enclose FILLED of the film's height.
        let half_angle = (FILLED * (0.5 * FOV_DEG).to_radians().tan()).atan();
        let distance = placing.radius / half_angle.sin();
        let target = [0.0, placing.half_height, 0.0];
        let towards = [elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos()];
        Self {
            position: std::array::from_fn(|k| target[k] + distance * towards[k]),
            target,
            ground: GROUND * placing.radius,
            small_ground: SMALL_GROUND * placing.radius,
            ground_y: -GAP * placing.radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::starter::model::Extent;
    use relume_formats::state::Camera;

    fn framed(half: [f64; 3]) -> (Placing, Framing, Camera) {
        let radius = half.iter().map(|x| x * x).sum::<f64>().sqrt();
        let placing = Placing::new(&Extent { low: half.map(|x| -x), high: half, radius }, Some(1.0));
        let framing = Framing::new(&placing);
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let camera = Camera {
            position: single(framing.position),
            target: single(framing.target),
            fov_deg: FOV_DEG as f32,
            exposure_ev: 0.0,
        };
        (placing, framing, camera)
    }

    /// The sphere about the model is seen under the angle that fills FILLED of the film, so all of it is in
    /// view.
    #[test]
    fn the_bounding_sphere_is_in_view() {
        for half in [[1.0, 1.0, 1.0], [0.01, 3.0, 0.01], [50.0, 0.0, 50.0], [1e-3, 2e-3, 1e-3]] {
            let (placing, framing, _) = framed(half);
            let distance: f64 =
                (0..3).map(|k| (framing.position[k] - framing.target[k]).powi(2)).sum::<f64>().sqrt();
            let seen = (placing.radius / distance).asin().tan() / (0.5 * FOV_DEG).to_radians().tan();
            assert!((seen - 0.9).abs() < 1e-9, "{half:?}: {seen}");
        }
    }

    /// Every ray through the film's border meets the ground within its square, for models of any shape.
    #[test]
    fn the_ground_fills_what_the_camera_sees() {
        for half in [[1.0, 1.0, 1.0], [0.01, 3.0, 0.01], [50.0, 0.0, 50.0]] {
            let (_, framing, camera) = framed(half);
            let film = camera.film(64, 64);
            for i in 0..=64 {
                for (x, y) in [(i, 0), (i, 64), (0, i), (64, i)] {
                    let direction = film.direction(x as f32, y as f32).as_dvec3();
                    let t = (framing.ground_y - framing.position[1]) / direction.y;
                    assert!(t > 0.0, "{half:?}: the horizon is in view");
                    for (p, d) in [(framing.position[0], direction.x), (framing.position[2], direction.z)] {
                        assert!(
                            (p + t * d).abs() < 0.5 * framing.ground,
                            "{half:?}: the ground ends in view"
                        );
                    }
                }
            }
        }
    }
}
