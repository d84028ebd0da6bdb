//! The BRDF spaces of a scene, and the columns that they give a vertex of its row of visibility.

use crate::brdf::tensor;
use glam::Vec3A;
use ndarray_linalg::error::LinalgError;
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::{NODES, theta};
use relume_formats::state::Model;
use relume_scenes::Scene;
use std::f32::consts::{FRAC_PI_2, PI};

/// The spaces of all models that objects wear, in the order of [`Model`].
///
/// # Errors
/// If LAPACK does not converge.
pub fn spaces(scene: &Scene) -> Result<Vec<BrdfTensor>, LinalgError> {
    models(scene).into_iter().map(tensor::make).collect()
}

/// The models that objects of `scene` wear.
pub(super) fn models(scene: &Scene) -> Vec<Model> {
    let worn =
        |model: &Model| scene.objects.iter().any(|o| scene.materials[o.material].brdf.model() == *model);
    [Model::BlinnPhong, Model::Ggx, Model::CookTorrance].into_iter().filter(worn).collect()
}

/// What a vertex is to know of the light, as functions of where that comes from.
pub struct Columns {
    orders: Vec<u32>,
    /// Row-major [[`NODES`], profiles].
    profiles: Vec<f32>,
    /// What each column usually counts for, beside the first: 1.
    pub importance: Vec<f32>,
}

impl Columns {
    /// Those of `space`.
    pub fn new(space: &BrdfTensor) -> Self {
        Self { orders: space.orders.clone(), profiles: space.incoming.clone(), importance: importance(space) }
    }

    /// Those of a material without highlights: the first alone.
    pub fn even() -> Self {
        Self { orders: Vec::new(), profiles: Vec::new(), importance: vec![1.0] }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.importance.len()
    }

    /// Values of all but the first at a unit vector about +Z, that of z not below 0, over that of the first: π times
    /// those of [`BrdfTensor::column_values`].
    pub fn ratios(&self, incoming: Vec3A, values: &mut [f32]) {
        let at = incoming.z.min(1.0).acos() / FRAC_PI_2 * (NODES - 1) as f32;
        let node = (at as usize).min(NODES - 2);
        let (share, count) = (at - node as f32, self.orders.len());
        let radius = incoming.truncate().length();
        let (cos, sin) = if radius > 0.0 { (incoming.x / radius, incoming.y / radius) } else { (1.0, 0.0) };
        let mut column = 0;
        for (profile, order) in self.orders.iter().enumerate() {
            let row = |node: usize| self.profiles[node * count + profile];
            let value = PI * (row(node) + share * (row(node + 1) - row(node)));
            let (mut c, mut s) = (1.0, 0.0);
            // cos mφ and sin mφ, an order at a time.
            for _ in 0..*order {
                (c, s) = (c * cos - s * sin, s * cos + c * sin);
            }
            values[column] = value * c;
            column += 1;
            if *order > 0 {
                values[column] = value * s;
                column += 1;
            }
        }
    }
}

/// The root mean square over samples and outgoing directions, by the cosine, of what unit lobes multiply each column with.
fn importance(space: &BrdfTensor) -> Vec<f32> {
    let count = space.orders.len();
    let mut squares = vec![0.0f64; count];
    let mut total = 0.0;
    for sample in 0..space.samples.count() {
        let weights = space.weights_of(&[(sample, 1.0)]);
        for (node, row) in weights.chunks_exact(count.max(1)).enumerate().take(NODES) {
            let (sin, cos) = theta(node).sin_cos();
            total += sin * cos;
            squares.iter_mut().zip(row).for_each(|(sum, w)| *sum += sin * cos * f64::from(*w).powi(2));
        }
    }
    let mut importance = vec![1.0];
    for (square, order) in squares.iter().zip(&space.orders) {
        // Of a pair, each column is multiplied with a cosine or a sine.
        let share = if *order > 0 { 0.5 } else { 1.0 };
        let value = (share * square / f64::max(total, f64::MIN_POSITIVE)).sqrt() as f32;
        importance.extend(std::iter::repeat_n(value, if *order > 0 { 2 } else { 1 }));
    }
    importance
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::state::Model;

    #[test]
    fn ratios_are_those_of_the_stored_columns() {
        let space = tensor::make(Model::CookTorrance).unwrap();
        let columns = Columns::new(&space);
        assert_eq!(columns.count(), space.columns());
        let mut values = vec![0.0; columns.count() - 1];
        for step in 0..200 {
            let (z, phi) = ((step as f32 * 0.618).fract(), 2.4 * step as f32);
            let r = (1.0 - z * z).sqrt();
            let incoming = Vec3A::new(r * phi.cos(), r * phi.sin(), z);
            columns.ratios(incoming, &mut values);
            let stored = space.column_values(incoming.into());
            for (found, stored) in values.iter().zip(&stored[1..]) {
                assert!(
                    (found - PI * stored).abs() < 1e-3 * (1.0 + stored.abs()),
                    "{incoming}: {found} {stored}"
                );
            }
        }
    }
}
