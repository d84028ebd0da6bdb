//! The Pareto front: the points than which nothing is both cheaper and more exact.

/// The points on the front, from the cheapest to the most exact. A point, cost before error, is not on it if
/// another is no worse in both and better in one; equal points share a place. Points that are no numbers are
/// on no front.
pub fn front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|at| points[*at].iter().all(|x| x.is_finite())).collect();
    order.sort_by(|a, b| {
        points[*a][0].total_cmp(&points[*b][0]).then(points[*a][1].total_cmp(&points[*b][1]))
    });
    let mut front: Vec<usize> = Vec::new();
    for at in order {
        let last = front.last().map(|last| points[*last]);
        if last.is_none_or(|last| points[at][1] < last[1] || points[at] == last) {
            front.push(at);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn dominated(point: [f64; 2], by: [f64; 2]) -> bool {
        by[0] <= point[0] && by[1] <= point[1] && by != point
    }

    proptest! {
        /// Coordinates are few, so that ties are common.
        #[test]
        fn the_front_is_what_nothing_dominates(points in prop::collection::vec([0u8..8, 0u8..8], 0..40)) {
            let points: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::from)).collect();
            let mut found = front(&points);
            prop_assert!(found.windows(2).all(|w| points[w[0]][0] <= points[w[1]][0] && points[w[0]][1] >= points[w[1]][1]));
            found.sort_unstable();
            let expected: Vec<usize> = (0..points.len()).filter(|at| !points.iter().any(|by| dominated(points[*at], *by))).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn what_is_no_number_is_on_no_front() {
        assert_eq!(front(&[[1.0, f64::INFINITY], [2.0, 1.0], [f64::NAN, 0.0]]), [1]);
    }
}
