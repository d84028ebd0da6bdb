//! Shares of mirror terms by expectation maximisation, the source's fit (thesis §5.3.1): the mixture from
//! which what arrives is most likely drawn, which is of least Kullback-Leibler divergence.

use relume_bake::brdf::tensor::Shapes;

/// Rounds.
const ROUNDS: usize = 200;

/// To compare with [`relume_bake::brdf::tensor::least_squares`].
pub fn expectation(shapes: &Shapes, arriving: &[f64]) -> Vec<f64> {
    maximised(shapes.integrals(), arriving, ROUNDS)
}

/// Of shapes by points.
fn maximised(shapes: &[Vec<f64>], arriving: &[f64], rounds: usize) -> Vec<f64> {
    let whole: f64 = arriving.iter().sum();
    let sums: Vec<f64> = shapes.iter().map(|shape| shape.iter().sum()).collect();
    let mut shares = vec![whole / shapes.len() as f64; shapes.len()];
    let (mut model, mut ratio) = (vec![0.0; arriving.len()], vec![0.0; arriving.len()]);
    for _ in 0..rounds {
        model.fill(0.0);
        for (share, shape) in shares.iter().zip(shapes) {
            model.iter_mut().zip(shape).for_each(|(sum, value)| *sum += share * value);
        }
        for ((ratio, model), arriving) in ratio.iter_mut().zip(&model).zip(arriving) {
            *ratio = if *model > 0.0 { arriving / model } else { 0.0 };
        }
        for ((share, shape), sum) in shares.iter_mut().zip(shapes).zip(&sums) {
            *share *= shape.iter().zip(&ratio).map(|(value, ratio)| value * ratio).sum::<f64>() / sum;
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two shapes over two points, the likeliest mixture in closed form: all of both points is met, if
    /// both shares may be above 0, and else the one shape has all that arrives.
    #[test]
    fn mixtures_of_two_points() {
        let shapes = [vec![0.75, 0.25], vec![0.25, 0.75]];
        let met = maximised(&shapes, &[5.0, 3.0], 200);
        assert!((met[0] - 6.0).abs() < 1e-9 && (met[1] - 2.0).abs() < 1e-9, "{met:?}");
        let beyond = maximised(&shapes, &[7.0, 1.0], 200);
        assert!((beyond[0] - 8.0).abs() < 1e-9 && beyond[1].abs() < 1e-9, "{beyond:?}");
    }
}
