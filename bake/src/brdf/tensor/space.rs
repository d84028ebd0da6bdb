//! The materials of a space that are decomposed (thesis §5.3.2).
//!
//! The source has Blinn-Phong's of exponents 1, 2, … 200, which are needlessly close where lobes are sharp, and
//! Cook and Torrance's as they were fitted to a hundred measured materials (Ngan et al. 2005), points in the plane
//! of Fresnel reflectance and roughness. Ours are spaced evenly in octaves of what makes a lobe sharp; Schlick's
//! reflectance makes lobes linear along the other axis of that plane, where few values do. GGX has the same plane,
//! its f₀ for reflectance.

use relume_formats::kinds::brdf_tensor::Samples;
use relume_formats::state::{
    BlinnPhong, Brdf, CookTorrance, Ggx, Model, ROUGHNESS_MIN, SHININESS_MAX, SLOPE_MIN,
};
use spade::{DelaunayTriangulation, Point2, Triangulation as _};

/// Exponents of the line.
const EXPONENTS: usize = 48;
/// Roughnesses of the plane.
const ROWS: usize = 25;
/// Reflectances at every other roughness, and one less between, so that triangles are no slivers.
const COLUMNS: usize = 4;

/// The samples of the space of `model`.
pub fn samples_of(model: Model) -> Samples {
    match model {
        Model::BlinnPhong => Samples::Line((0..EXPONENTS).map(exponent).collect()),
        Model::Ggx => plane(ROUGHNESS_MIN),
        Model::CookTorrance => plane(SLOPE_MIN),
    }
}

/// The material of sample number `sample` whose BRDF is its glossy lobe of unit strength; black where there
/// is none of this number.
pub fn lobe_of(model: Model, samples: &Samples, sample: usize) -> Brdf {
    let (dark, white) = ([0.0; 3], [1.0; 3]);
    let exponent = match samples {
        Samples::Line(exponents) => exponents.get(sample).copied(),
        Samples::Plane { .. } => None,
    };
    let point = match samples {
        Samples::Plane { points, .. } => points.get(sample).copied(),
        Samples::Line(_) => None,
    };
    match (model, exponent, point) {
        (Model::BlinnPhong, Some(shininess), _) => {
            Brdf::BlinnPhong(BlinnPhong { kd: dark, ks: white, shininess })
        }
        (Model::Ggx, _, Some([f0, roughness])) => {
            Brdf::Ggx(Ggx { base_color: [f0; 3], metallic: 1.0, roughness })
        }
        (Model::CookTorrance, _, Some([fresnel, roughness])) => {
            Brdf::CookTorrance(CookTorrance { kd: dark, ks: white, fresnel, roughness })
        }
        _ => Brdf::BlinnPhong(BlinnPhong { kd: dark, ks: dark, shininess: 1.0 }),
    }
}

fn exponent(number: usize) -> f32 {
    SHININESS_MAX.powf(number as f32 / (EXPONENTS - 1) as f32)
}

fn plane(least: f32) -> Samples {
    let row = |row: usize| {
        let columns = COLUMNS - row % 2;
        let roughness = least.powf(1.0 - row as f32 / (ROWS - 1) as f32);
        (0..columns).map(move |column| [column as f32 / (columns - 1) as f32, roughness])
    };
    let points: Vec<[f32; 2]> = (0..ROWS).flat_map(row).collect();
    Samples::Plane { triangles: delaunay(&points), points }
}

/// Counter-clockwise triangles in the plane of reflectance and ln roughness, each with its least index first,
/// in the order of indices; points are finite and differ.
fn delaunay(points: &[[f32; 2]]) -> Vec<[u32; 3]> {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    for [reflectance, roughness] in points {
        // None of these fails: points are finite and of the order of 1.
        let _ = triangulation.insert(Point2::new(f64::from(*reflectance), f64::from(*roughness).ln()));
    }
    let corners = triangulation.inner_faces().map(|face| face.vertices().map(|corner| corner.index() as u32));
    let mut triangles: Vec<[u32; 3]> = corners
        .map(|mut corners| {
            let least = (0..3).min_by_key(|at| corners[*at]).unwrap_or(0);
            corners.rotate_left(least);
            corners
        })
        .collect();
    triangles.sort_unstable();
    triangles
}
