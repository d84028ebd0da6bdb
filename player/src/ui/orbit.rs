//! A camera moved by hand, around what it looks at.

use glam::{Quat, Vec3};
use relume_formats::state::Camera;
use relume_playback::Surfaces;

/// Steepest view down or up, in degrees: just before the film would turn over.
const STEEPEST_DEG: f32 = 89.0;
/// A drag over the height of the picture goes round by so much, in degrees.
const ORBIT_DEG: f32 = 180.0;
/// How far the distance to the target may differ from the scene's, as a factor either way.
const REACH: f32 = 1e3;
/// How far a hand keeps the camera away from surfaces, as a share of the scene's distance to the target.
const CLEARANCE: f32 = 0.01;
/// An orbit is looked at in straight pieces that leave its circle by no more than this share of the
/// clearance, but in no more of them than this.
const SAGITTA: f32 = 0.1;
const MOST_PIECES: f32 = 256.0;

/// What a hand does. Lengths are shares of the picture's height, x to the right and y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Goes round the target, as if the scene were turned by its front.
    Orbit([f32; 2]),
    /// Moves camera and target sideways, such that the target follows the hand.
    Pan([f32; 2]),
    /// Multiplies the distance to the target.
    Dolly(f32),
}

/// `camera` after `motion`, which ends where a surface is in the camera's way; `home` is the scene's own,
/// from which it cannot get lost. What is no number moves nothing.
pub fn moved(camera: Camera, motion: Motion, home: Camera, surfaces: &Surfaces) -> Camera {
    let (position, target) = (Vec3::from(camera.position), Vec3::from(camera.target));
    let way = position - target;
    let usual = Vec3::from(home.position).distance(Vec3::from(home.target));
    let keep = CLEARANCE * usual;
    let (position, target) = match motion {
        Motion::Orbit(drag) => (orbited(target, way, drag, keep, surfaces), target),
        Motion::Pan([x, y]) => {
            let [_, right, up] = camera.film(1, 1).axes().map(Vec3::from);
            let end = surfaces.way(position, position + 2.0 * way.length() * (y * up - x * right), keep);
            (end, target + (end - position))
        }
        Motion::Dolly(factor) => {
            let length = (way.length() * factor).clamp(usual / REACH, usual * REACH);
            (surfaces.way(position, target + way.normalize_or(Vec3::Z) * length, keep), target)
        }
    };
    let moved = Camera { position: position.to_array(), target: target.to_array(), ..camera };
    if position.is_finite() && target.is_finite() && moved.position != moved.target { moved } else { camera }
}

/// Where a drag takes a camera round `target`, from which `way` leads to it: as far as it stays away from
/// surfaces by `keep`.
fn orbited(target: Vec3, way: Vec3, drag: [f32; 2], keep: f32, surfaces: &Surfaces) -> Vec3 {
    let at = |share: f32| target + turned(way, drag.map(|x| x * share));
    let angle = drag[0].hypot(drag[1]) * ORBIT_DEG.to_radians();
    let piece = 2.0 * (1.0 - SAGITTA * keep / way.length()).clamp(-1.0, 1.0).acos();
    let pieces = (angle / piece).ceil().clamp(1.0, MOST_PIECES);
    let mut from = way + target;
    for index in 1..=pieces as usize {
        let (before, to) = ((index - 1) as f32 / pieces, at(index as f32 / pieces));
        let end = surfaces.way(from, to, keep);
        if end != to {
            return at(before + from.distance(end) / from.distance(to) / pieces);
        }
        from = to;
    }
    from
}

/// The way from the target to the camera, turned by a drag.
fn turned(way: Vec3, [x, y]: [f32; 2]) -> Vec3 {
    let [across, down] = [x, y].map(|share| (share * ORBIT_DEG).to_radians());
    let level = Vec3::new(way.x, 0.0, way.z);
    let elevation = way.y.atan2(level.length());
    let steepest = STEEPEST_DEG.to_radians();
    // From straight above, the film's top points to -Z: the camera comes down on the side of +Z.
    let level = Quat::from_rotation_y(-across) * level.normalize_or(Vec3::Z);
    // A view that is steeper already may stay so, but not become more so.
    let new = (elevation + down).clamp(elevation.min(-steepest), elevation.max(steepest));
    way.length() * (new.cos() * level + new.sin() * Vec3::Y)
}

#[cfg(test)]
mod tests {
    use super::{moved as moved_among, *};

    const HOME: Camera =
        Camera { position: [1.0, 2.0, 6.0], target: [0.5, 1.0, 0.0], fov_deg: 40.0, exposure_ev: 1.5 };

    fn moved(camera: Camera, motion: Motion, home: Camera) -> Camera {
        moved_among(camera, motion, home, &Surfaces::default())
    }

    /// Where a point appears: as shares of the picture's height, x to the right and y down, from its middle.
    fn seen(camera: &Camera, point: Vec3) -> [f32; 2] {
        let [forward, right, up] = camera.film(1, 1).axes().map(Vec3::from);
        let way = point - Vec3::from(camera.position);
        [0.5, -0.5]
            .map(|s| s / way.dot(forward))
            .into_iter()
            .zip([right, up])
            .map(|(s, axis)| s * way.dot(axis) / axis.length_squared())
            .collect::<Vec<_>>()
            .try_into()
            .unwrap()
    }

    fn distance(camera: &Camera) -> f32 {
        Vec3::from(camera.position).distance(Vec3::from(camera.target))
    }

    #[test]
    fn an_orbit_keeps_distance_and_target_and_the_front_follows_the_hand() {
        let front = Vec3::from(HOME.target) + 0.01 * (Vec3::from(HOME.position) - Vec3::from(HOME.target));
        for drag in [[0.05, 0.0], [-0.05, 0.0], [0.0, 0.03], [0.0, -0.03], [0.02, 0.02]] {
            let camera = moved(HOME, Motion::Orbit(drag), HOME);
            assert!((distance(&camera) - distance(&HOME)).abs() < 1e-5);
            assert_eq!(camera.target, HOME.target);
            let to = seen(&camera, front);
            assert!(
                drag.iter().zip(to).all(|(drag, to)| *drag == 0.0 || drag * to > 0.0),
                "{drag:?} leads to {to:?}"
            );
        }
        // Half a turn, and once round.
        let across = moved(HOME, Motion::Orbit([1.0, 0.0]), HOME).position;
        assert!(Vec3::from(across).distance(Vec3::new(0.0, 2.0, -6.0)) < 1e-5, "{across:?}");
        let round = (0..8).fold(HOME, |camera, _| moved(camera, Motion::Orbit([0.25, 0.0]), HOME));
        assert!(Vec3::from(round.position).distance(Vec3::from(HOME.position)) < 1e-4);
    }

    #[test]
    fn it_never_turns_over() {
        for down in [9.0, -9.0] {
            let camera = moved(HOME, Motion::Orbit([0.3, down]), HOME);
            let way = (Vec3::from(camera.position) - Vec3::from(camera.target)).normalize();
            assert!((way.y.abs() - STEEPEST_DEG.to_radians().sin()).abs() < 1e-5 && way.y * down > 0.0);
        }
        let above = Camera { position: [0.5, 9.0, 0.0], ..HOME };
        let still = moved(above, Motion::Orbit([0.0, 0.0]), HOME);
        assert!(Vec3::from(still.position).distance(Vec3::from(above.position)) < 1e-5);
        let down = moved(above, Motion::Orbit([0.0, -0.25]), HOME);
        assert!(down.position[2] > 1.0 && (distance(&down) - 8.0).abs() < 1e-5, "{down:?}");
    }

    #[test]
    fn a_pan_takes_the_target_along() {
        for drag in [[0.25, 0.0], [0.0, 0.25], [-0.1, 0.2]] {
            let camera = moved(HOME, Motion::Pan(drag), HOME);
            let old = seen(&camera, Vec3::from(HOME.target));
            assert!(
                drag.iter().zip(old).all(|(drag, old)| (drag - old).abs() < 1e-5),
                "{drag:?} leads to {old:?}"
            );
            assert!((distance(&camera) - distance(&HOME)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_dolly_ends_before_the_target_and_before_infinity() {
        assert!((distance(&moved(HOME, Motion::Dolly(0.5), HOME)) - 0.5 * distance(&HOME)).abs() < 1e-5);
        for (factor, end) in [(0.5, 1e-3), (2.0, 1e3)] {
            let camera = (0..40).fold(HOME, |camera, _| moved(camera, Motion::Dolly(factor), HOME));
            assert!((distance(&camera) / distance(&HOME) / end - 1.0).abs() < 1e-2, "{factor}");
            camera.validate(&relume_formats::Place::file("test")).unwrap();
        }
        for motion in
            [Motion::Dolly(f32::NAN), Motion::Orbit([f32::NAN, 0.0]), Motion::Pan([f32::INFINITY, 1.0])]
        {
            assert_eq!(moved(HOME, motion, HOME), HOME);
        }
    }

    /// Two large squares: x = 3, and z = -2 behind the target.
    fn walls() -> Surfaces {
        let corners =
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|c: [f32; 2]| c.map(|x| 50.0 * x));
        let (side, back) = (corners.map(|[y, z]| [3.0, y, z]), corners.map(|[x, y]| [x, y, -2.0]));
        Surfaces::new([side, back].concat(), vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    }

    #[test]
    fn an_orbit_goes_through_no_surface() {
        let walls = walls();
        let keep = CLEARANCE * distance(&HOME);
        for pieces in [1, 7, 100] {
            let end = (0..pieces).fold(HOME, |camera, _| {
                moved_among(camera, Motion::Orbit([-0.9 / pieces as f32, 0.0]), HOME, &walls)
            });
            assert!(
                (3.0 - end.position[0] - keep).abs() < (SAGITTA + 0.01) * keep,
                "{pieces}: {:?}",
                end.position
            );
            assert!((distance(&end) - distance(&HOME)).abs() < 1e-4);
            assert_eq!(end.target, HOME.target);
            let back = moved_among(end, Motion::Orbit([0.1, 0.0]), HOME, &walls);
            assert!(
                Vec3::from(back.position).distance(end.position.into()) > 0.5,
                "back again it goes at once"
            );
        }
        // The other way round the wall behind the target is met.
        let end = moved_among(HOME, Motion::Orbit([0.9, 0.0]), HOME, &walls);
        assert!(
            (end.position[2] + 2.0 - keep).abs() < (SAGITTA + 0.01) * keep && end.position[0] < 0.0,
            "{:?}",
            end.position
        );
        // Where nothing is in the way the same drag ends where it would without surfaces.
        let free = Motion::Orbit([0.2, 0.1]);
        let apart = Vec3::from(moved_among(HOME, free, HOME, &walls).position)
            .distance(moved(HOME, free, HOME).position.into());
        assert!(apart < 1e-5, "{apart}");
    }

    #[test]
    fn a_pan_goes_through_no_surface_and_keeps_the_direction() {
        let walls = walls();
        let keep = CLEARANCE * distance(&HOME);
        let end = moved_among(HOME, Motion::Pan([-5.0, 0.0]), HOME, &walls);
        assert!((3.0 - end.position[0] - keep).abs() < 0.01 * keep, "{:?}", end.position);
        let [before, after] =
            [HOME, end].map(|camera| Vec3::from(camera.target) - Vec3::from(camera.position));
        assert!(before.distance(after) < 1e-5);
        assert_eq!(
            moved_among(HOME, Motion::Pan([0.1, 0.1]), HOME, &walls),
            moved(HOME, Motion::Pan([0.1, 0.1]), HOME)
        );
    }

    #[test]
    fn a_dolly_goes_through_no_surface() {
        // A wall through the target, square to the way there.
        let (eye, target) = (Vec3::from(HOME.position), Vec3::from(HOME.target));
        let right = (eye - target).cross(Vec3::Y);
        let up = right.cross(eye - target).normalize() * right.length();
        let corners =
            [-right - up, right - up, right + up, up - right].map(|corner| (target + corner).to_array());
        let wall = Surfaces::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        let near = (0..200).fold(HOME, |camera, _| moved_among(camera, Motion::Dolly(0.7), HOME, &wall));
        assert!(
            (distance(&near) / distance(&HOME) / CLEARANCE - 1.0).abs() < 0.01,
            "{}",
            distance(&near) / distance(&HOME)
        );
        let back = moved_among(near, Motion::Dolly(50.0), HOME, &wall);
        assert!((distance(&back) - 50.0 * distance(&near)).abs() < 1e-3, "out again it goes at once");
        // From behind, the same wall is in the way; and the way back is not open either.
        let room =
            Camera { position: (target + 3.0 * (target - eye)).to_array(), target: eye.to_array(), ..HOME };
        let near = (0..200).fold(room, |camera, _| moved_among(camera, Motion::Dolly(0.7), HOME, &wall));
        assert!(
            (Vec3::from(near.position).distance(target) / distance(&HOME) / CLEARANCE - 1.0).abs() < 0.01
        );
        let inside = Camera { target: (2.0 * eye - target).to_array(), ..HOME };
        let back = (0..200).fold(inside, |camera, _| moved_among(camera, Motion::Dolly(1.5), HOME, &wall));
        assert!(
            (Vec3::from(back.position).distance(target) / distance(&HOME) / CLEARANCE - 1.0).abs() < 0.01
        );
    }
}
