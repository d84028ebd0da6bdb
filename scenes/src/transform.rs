//! Transforms as a scene file writes them, and what they mean.

use glam::{DAffine3, DMat3, DVec3};
use relume_formats::{Error, Place, Result};
use serde::Deserialize;

/// `{ translation, rotation_deg, scale }`: scaled first, then turned about the world's x, y and z axes in
/// this order, then moved.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct TransformFile {
    translation: [f64; 3],
    rotation_deg: [f64; 3],
    scale: ScaleFile,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a number or [x, y, z] is expected; correct it")]
enum ScaleFile {
    Uniform(f64),
    Axes([f64; 3]),
}

impl Default for TransformFile {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation_deg: [0.0; 3], scale: ScaleFile::Uniform(1.0) }
    }
}

impl TransformFile {
    /// The map from local to world space.
    pub fn world_from_local(&self, place: &Place) -> Result<DAffine3> {
        let scale = match self.scale {
            ScaleFile::Uniform(s) => DVec3::splat(s),
            ScaleFile::Axes(s) => s.into(),
        };
        let [x, y, z] = self.rotation_deg;
        let linear = rotation_z(z) * rotation_y(y) * rotation_x(x) * DMat3::from_diagonal(scale);
        let world_from_local = DAffine3::from_mat3_translation(linear, self.translation.into());
        if !world_from_local.is_finite() {
            return Err(Error::invalid(place, "transform: every value must be a finite number"));
        }
        Ok(world_from_local)
    }
}

impl TransformFile {
    /// Fails if the scale leaves of any surface no more than a line or a point.
    pub fn expect_extent(&self, place: &Place) -> Result<()> {
        let scale = match self.scale {
            ScaleFile::Uniform(s) => [s; 3],
            ScaleFile::Axes(s) => s,
        };
        if scale.iter().filter(|s| **s == 0.0).count() < 2 {
            return Ok(());
        }
        let shown = if matches!(self.scale, ScaleFile::Uniform(_)) {
            "scale 0".to_owned()
        } else {
            format!("scale {scale:?}")
        };
        Err(Error::invalid(
            place,
            format!("transform: {shown} leaves no surface of it; give numbers other than 0"),
        ))
    }
}

/// Maps surface normals as `map` maps the surface: the inverse transpose times |det|, which exists for flat
/// maps too.
pub(crate) fn normal_map(map: &DAffine3) -> DMat3 {
    let m = map.matrix3;
    let cofactors =
        DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if is_mirroring(map) { -cofactors } else { cofactors }
}

/// True if `map` turns right hands into left ones.
pub(crate) fn is_mirroring(map: &DAffine3) -> bool {
    map.matrix3.determinant() < 0.0
}

fn rotation_x(degrees: f64) -> DMat3 {
    let (s, c) = sin_cos_deg(degrees);
    DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c])
}

fn rotation_y(degrees: f64) -> DMat3 {
    let (s, c) = sin_cos_deg(degrees);
    DMat3::from_cols_array(&[c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c])
}

fn rotation_z(degrees: f64) -> DMat3 {
    let (s, c) = sin_cos_deg(degrees);
    DMat3::from_cols_array(&[c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0])
}

/// Exact at right angles, so that the walls of a room meet without a gap.
fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let quarters = degrees / 90.0;
    if quarters.fract() != 0.0 {
        return degrees.to_radians().sin_cos();
    }
    match quarters.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<DAffine3> {
        let place = Place::file("t.toml");
        relume_formats::state::parse_toml::<TransformFile>(text, &place)?.world_from_local(&place)
    }

    #[test]
    fn scales_then_turns_about_x_y_z_then_moves() {
        let map = parse("translation = [10, 20, 30]\nrotation_deg = [90, 90, 0]\nscale = [2, 3, 4]").unwrap();
        // Local +Y: scaled to 3, about x to +Z, about y (z → x) to +X.
        assert_eq!(map.transform_point3(DVec3::Y), DVec3::new(13.0, 20.0, 30.0));
        // Local +Z: scaled to 4, about x to −Y, unmoved about y.
        assert_eq!(map.transform_point3(DVec3::Z), DVec3::new(10.0, 16.0, 30.0));
        // Local +X: unmoved about x, about y to −Z.
        assert_eq!(map.transform_point3(DVec3::X), DVec3::new(10.0, 20.0, 28.0));
    }

    #[test]
    fn rotations_agree_with_glam() {
        let map = parse("rotation_deg = [20, -35, 130]").unwrap();
        let turn = |axis: DVec3, degrees: f64| DMat3::from_axis_angle(axis, degrees.to_radians());
        let expected = turn(DVec3::Z, 130.0) * turn(DVec3::Y, -35.0) * turn(DVec3::X, 20.0);
        assert!(map.matrix3.abs_diff_eq(expected, 1e-14));
    }

    #[test]
    fn normal_map_keeps_normals_perpendicular_and_outside() {
        for text in [
            "rotation_deg = [20, 30, 40]\nscale = [1, 5, 0.2]",
            "rotation_deg = [1, 2, 3]\nscale = [-1, 2, 3]",
        ] {
            let map = parse(text).unwrap();
            let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 0.5, 2.0));
            let n = normal_map(&map) * a.cross(b);
            assert!(
                n.dot(map.transform_vector3(a)).abs() < 1e-9 && n.dot(map.transform_vector3(b)).abs() < 1e-9
            );
            // A point on the outside of the plane stays on its outside.
            assert!(n.dot(map.transform_vector3(a.cross(b))) > 0.0);
        }
    }

    #[test]
    fn mistakes_are_refused() {
        for (text, part) in [
            ("scale = \"big\"", "line 1, column 9: scale: a number or [x, y, z] is expected; correct it"),
            ("translation = [nan, 0, 0]", "finite"),
            ("rotation_dg = [1, 2, 3]", "did you mean `rotation_deg`?"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
