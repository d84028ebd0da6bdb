//! Whether a mesh is fine enough for methods that know the light at vertices only, and blend it in between.

use glam::{DVec3, Vec3A};
use relume_formats::state::Film;
use relume_scenes::{Object, Scene};

/// A triangle is coarse if it spans more of the film's height than this: no shadow that is smaller can show
/// in it, and one that is hardly larger is a blur of its size. A sixteenth is about what the shadow of a
/// chair's leg takes in the view of a room.
const COARSE: f64 = 1.0 / 16.0;
/// But on a small film what spans so few pixels hardly shows either way.
const LEAST_PIXELS: f64 = 16.0;
/// Objects that are named.
const MOST_LISTED: usize = 3;

/// What is said of objects whose triangles are coarse in the scene's own view, of whatever else is before
/// them; none if there is none.
pub(super) fn notice(scene: &Scene) -> Option<String> {
    let [width, height] = scene.size;
    let view = View::new(&scene.camera.film(width, height), scene.size);
    let least = (COARSE * f64::from(height)).max(LEAST_PIXELS);
    let mut coarse: Vec<(&str, f64)> =
        scene.objects.iter().map(|object| (object.name.as_str(), view.largest(object))).collect();
    coarse.retain(|(_, span)| *span > least);
    coarse.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = coarse.first()?.1;
    let names: Vec<String> = coarse.iter().take(MOST_LISTED).map(|(name, _)| format!("`{name}`")).collect();
    let more = coarse.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Some(format!(
        "shadows smaller than the triangles of {}{more}, of which one spans {largest:.0} pixels (more than {least:.0} is coarse): \
         light is known at vertices only; raise `segments` or `subdivisions`, subdivide the mesh, or, where the light may stay, use transfer-images",
        names.join(", ")
    ))
}

/// A point in front of a camera: right and up as shares of half the film at depth 1, and the depth.
type Seen = [f64; 3];

struct View {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Pixels of half the film.
    half: [f64; 2],
}

impl View {
    fn new(film: &Film, size: [u32; 2]) -> Self {
        let [forward, right, up] = film.axes().map(Vec3A::as_dvec3);
        let by_square = |v: DVec3| v / v.length_squared();
        let half = size.map(|n| 0.5 * f64::from(n));
        Self { eye: film.eye_in_world.as_dvec3(), forward, right: by_square(right), up: by_square(up), half }
    }

    fn seen(&self, point: [f32; 3]) -> Seen {
        let way = DVec3::from(point.map(f64::from)) - self.eye;
        [way.dot(self.right), way.dot(self.up), way.dot(self.forward)]
    }

    /// The largest span of a triangle of `object`, pixels.
    fn largest(&self, object: &Object) -> f64 {
        let seen: Vec<Seen> = object.mesh.positions.iter().map(|point| self.seen(*point)).collect();
        let corners = |triangle: &[u32; 3]| {
            triangle.iter().filter_map(|vertex| seen.get(*vertex as usize).copied()).collect()
        };
        object.mesh.triangles.iter().map(|triangle| self.span(corners(triangle))).fold(0.0, f64::max)
    }

    /// The largest distance on the film between two points of what is seen of a polygon, pixels.
    fn span(&self, corners: Vec<Seen>) -> f64 {
        // Depth first, and not at the eye itself, where everything is endlessly large.
        let depth = |[_, _, w]: &Seen| w - 1e-6;
        let sides: [&dyn Fn(&Seen) -> f64; 5] =
            [&depth, &|[x, _, w]| w - x, &|[x, _, w]| w + x, &|[_, y, w]| w - y, &|[_, y, w]| w + y];
        let seen = sides.into_iter().fold(corners, |polygon, side| clipped(&polygon, side));
        let on_film: Vec<[f64; 2]> =
            seen.iter().map(|[x, y, w]| [x / w * self.half[0], y / w * self.half[1]]).collect();
        let pairs = on_film
            .iter()
            .enumerate()
            .flat_map(|(index, a)| on_film[index + 1..].iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
    }
}

/// What of a convex polygon lies where `side` is at least 0 (Sutherland and Hodgman 1974).
fn clipped(polygon: &[Seen], side: &dyn Fn(&Seen) -> f64) -> Vec<Seen> {
    let next = polygon.iter().cycle().skip(1);
    let mut inside = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in polygon.iter().zip(next) {
        let (da, db) = (side(a), side(b));
        if da >= 0.0 {
            inside.push(*a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            inside.push(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * da / (da - db)));
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::state::Camera;

    /// At the origin, looking along −Z at a film of 200 × 100 pixels; at depth 1 it is 2 high.
    fn view() -> View {
        let camera = Camera { position: [0.0; 3], target: [0.0, 0.0, -1.0], fov_deg: 90.0, exposure_ev: 0.0 };
        View::new(&camera.film(200, 100), [200, 100])
    }

    fn span(corners: [[f32; 3]; 3]) -> f64 {
        let view = view();
        view.span(corners.iter().map(|corner| view.seen(*corner)).collect())
    }

    #[test]
    fn spans_are_those_of_what_is_seen() {
        for (corners, expected) in [
            // At depth 2 a metre is 25 pixels.
            ([[0.0, 0.0, -2.0], [0.4, 0.0, -2.0], [0.0, 0.3, -2.0]], 12.5),
            // The same twice as far away.
            ([[0.0, 0.0, -4.0], [0.4, 0.0, -4.0], [0.0, 0.3, -4.0]], 6.25),
            // The whole film and more: its diagonal.
            ([[-90.0, -90.0, -2.0], [90.0, -90.0, -2.0], [0.0, 400.0, -2.0]], 200.0f64.hypot(100.0)),
            // Behind, and beside.
            ([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]], 0.0),
            ([[9.0, 0.0, -2.0], [10.0, 0.0, -2.0], [9.0, 1.0, -2.0]], 0.0),
            // A floor 1 m below that goes on behind the eye is seen from the film's lower edge to the horizon
            // at infinity, here to depth 100.
            ([[-1e4, -1.0, 50.0], [1e4, -1.0, 50.0], [0.0, -1.0, -100.0]], 0.0),
        ] {
            let given = span(corners);
            match expected {
                0.0 if corners[0][2] == 50.0 => assert!((200.0..=206.2).contains(&given), "{given}"),
                expected => assert!(
                    (given - expected).abs() < 1e-3 * expected.max(1.0),
                    "{corners:?}: {given} is not {expected}"
                ),
            }
        }
    }
}
