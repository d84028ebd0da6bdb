//! Weights of one fragment's neighbours.

use super::film::Film;

/// How far neighbours may be, pixels.
pub const RADIUS: i32 = 8;
/// Side of the window of all neighbours.
pub const WINDOW: i32 = 2 * RADIUS + 1;
/// How much normals may differ, squared: where they differ so much, neighbours count e^(-1/2).
const NORMALS: f32 = 0.1;
/// How far neighbours may be from the plane of a fragment, in distances of nearest neighbours.
const PLANE: f32 = 3.0;
/// Features that vary less in a window, squared, are left out: what depends on them there is noise.
const FLAT: f32 = 1e-5;
/// Held against the slope of every feature, in parts of all weights.
const RIDGE: f32 = 1e-3;
/// Weights below this, in parts of the largest, are dropped.
const LEAST: f32 = 1e-4;
/// Place on the film, normal, colour.
const FEATURES: usize = 2 + 3 + 3;

/// What a fragment becomes: numbers of fragments, and their weights, which are above 0 and 1 in all.
pub type Row = Vec<(u32, f32)>;

/// The neighbours of one fragment, and how far they belong together by what is known of them without light.
pub struct Neighbours {
    /// Its own number.
    own: u32,
    /// Numbers of fragments.
    numbers: Vec<u32>,
    /// Their places in the window.
    places: Vec<u16>,
    weights: Vec<f32>,
    /// Those features that vary, each of all neighbours: differences from the fragment's own.
    features: Vec<Vec<f32>>,
}

impl Neighbours {
    /// Of fragment number `own`.
    pub fn new(film: &Film, own: u32) -> Self {
        let fragment = &film.fragments()[own as usize];
        let ([x, y], class) = (film.pixel(fragment), usize::from(fragment.class));
        let reach = PLANE * spacing(film, own);
        let (mut numbers, mut places, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let mut features: Vec<Vec<f32>> = vec![Vec::new(); FEATURES];
        for (place, (dx, dy)) in window().enumerate() {
            let Some(number) = film.at(class, x + dx, y + dy) else { continue };
            let other = &film.fragments()[number as usize];
            let turn = other.normal - fragment.normal;
            let off = (other.position - fragment.position).dot(fragment.normal.normalize_or_zero()) / reach;
            let off = if off.is_finite() { off * off } else { 0.0 };
            let weight = other.samples * (-0.5 * (turn.length_squared() / NORMALS + off)).exp();
            if weight < LEAST * fragment.samples {
                continue;
            }
            numbers.push(number);
            places.push(place as u16);
            weights.push(weight);
            let of_place = [dx, dy].map(|d| d as f32 / RADIUS as f32);
            let tint = other.colour - fragment.colour;
            let all = of_place.into_iter().chain(turn.to_array()).chain(tint.to_array());
            features.iter_mut().zip(all).for_each(|(feature, value)| feature.push(value));
        }
        features.retain(|feature| variance(feature, &weights) > FLAT);
        Self { own, numbers, places, weights, features }
    }

    /// Their weights where patches differ by `distances`, by place in the window: neighbours that differ by
    /// `strength` noises count 1/e.
    pub fn row(&self, distances: &[f32], strength: f32) -> Row {
        let sharpness = 1.0 / (strength * strength);
        let alike = |place: u16| (-distances[usize::from(place)].max(0.0) * sharpness).exp();
        let mut alike: Vec<f32> = self.places.iter().map(|place| alike(*place)).collect();
        // Nothing is as like a fragment as itself, and one that is all noise is like nothing else.
        if let Some(own) = self.numbers.iter().position(|number| *number == self.own) {
            alike[own] = 0.0;
            alike[own] = alike.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        }
        let weights: Vec<f32> = self.weights.iter().zip(&alike).map(|(w, alike)| w * alike).collect();
        let fitted = fit(&weights, &self.features);
        let largest = fitted.iter().copied().fold(0.0, f32::max);
        let kept = self.numbers.iter().zip(fitted).filter(|(_, weight)| *weight > LEAST * largest);
        let mut row: Row = kept.map(|(number, weight)| (*number, weight)).collect();
        let sum: f32 = row.iter().map(|(_, weight)| weight).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return vec![(self.own, 1.0)];
        }
        row.iter_mut().for_each(|(_, weight)| *weight /= sum);
        row
    }
}

/// Steps to all places of a window, row by row.
fn window() -> impl Iterator<Item = (i32, i32)> {
    (-RADIUS..=RADIUS).flat_map(|dy| (-RADIUS..=RADIUS).map(move |dx| (dx, dy)))
}

/// How far the nearest neighbour of a fragment is from it, metres; without any, infinite.
fn spacing(film: &Film, own: u32) -> f32 {
    let fragment = &film.fragments()[own as usize];
    let [x, y] = film.pixel(fragment);
    let near = [(1, 0), (-1, 0), (0, 1), (0, -1)].into_iter();
    let near = near.filter_map(|(dx, dy)| film.at(usize::from(fragment.class), x + dx, y + dy));
    let distance = |number: u32| film.fragments()[number as usize].position.distance(fragment.position);
    near.map(distance).filter(|d| *d > 0.0).fold(f32::INFINITY, f32::min)
}

fn variance(values: &[f32], weights: &[f32]) -> f32 {
    let sum: f32 = weights.iter().sum();
    let mean = values.iter().zip(weights).map(|(v, w)| v * w).sum::<f32>() / sum;
    values.iter().zip(weights).map(|(v, w)| w * (v - mean) * (v - mean)).sum::<f32>() / sum
}

/// What each neighbour counts in the value, at the fragment itself, of a function that is linear in the
/// features and fits all neighbours best; negative ones as 0.
fn fit(weights: &[f32], features: &[Vec<f32>]) -> Vec<f32> {
    let size = features.len() + 1;
    let feature = |k: usize, j: usize| if k == 0 { 1.0 } else { features[k - 1][j] };
    let mut matrix = [[0.0f64; FEATURES + 1]; FEATURES + 1];
    for (row, values) in matrix.iter_mut().enumerate().take(size) {
        for (column, value) in values.iter_mut().enumerate().take(row + 1) {
            let product = |(j, w): (usize, &f32)| w * feature(row, j) * feature(column, j);
            *value = f64::from(weights.iter().enumerate().map(product).sum::<f32>());
        }
    }
    let ridge = f64::from(RIDGE) * matrix[0][0];
    (1..size).for_each(|k| matrix[k][k] += ridge);
    let slopes = first_column_of_inverse(&matrix, size);
    let count = |(j, weight): (usize, &f32)| {
        let value: f32 = (0..size).map(|k| slopes[k] * feature(k, j)).sum();
        (weight * value).max(0.0)
    };
    weights.iter().enumerate().map(count).collect()
}

/// Of a symmetric positive definite matrix, by Cholesky's decomposition of its lower triangle; of any other
/// the fit is that of a constant.
fn first_column_of_inverse(matrix: &[[f64; FEATURES + 1]; FEATURES + 1], size: usize) -> [f32; FEATURES + 1] {
    let mut constant = [0.0; FEATURES + 1];
    constant[0] = 1.0;
    let mut lower = [[0.0f64; FEATURES + 1]; FEATURES + 1];
    for row in 0..size {
        for column in 0..=row {
            let sum: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = matrix[row][column] - sum;
            if row > column {
                lower[row][column] = rest / lower[column][column];
            } else if rest > 0.0 {
                lower[row][row] = rest.sqrt();
            } else {
                return constant;
            }
        }
    }
    let mut solution = [0.0f64; FEATURES + 1];
    for row in 0..size {
        let sum: f64 = (0..row).map(|k| lower[row][k] * solution[k]).sum();
        solution[row] = (if row == 0 { 1.0 } else { 0.0 } - sum) / lower[row][row];
    }
    for row in (0..size).rev() {
        let sum: f64 = (row + 1..size).map(|k| lower[k][row] * solution[k]).sum();
        solution[row] = (solution[row] - sum) / lower[row][row];
    }
    // Scales cancel, for rows are 1 in all; this keeps them within what single precision holds.
    solution.map(|value| (value * matrix[0][0]) as f32)
}
