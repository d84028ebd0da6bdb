//! The smallest ball around points whose squared distances carry weights: of all points c the one where max
//! |c − qᵢ|² + wᵢ is least.
//!
//! With all weights 0 this is the smallest enclosing ball. Weights come in when a linear term pulls the
//! centre: g·c + a·max |c − pᵢ|² is that same problem with q = p − g/2a.

use glam::{DMat3, DVec3};

/// Most rounds; each adds the point that is farthest out. Far more than points in general position take.
const ROUNDS: usize = 64;
/// How far a centre may be out of its sites' hull, in parts of its extent, for rounding.
const SLACK: f64 = 1e-9;

/// The c where the greatest of g·c + a·|c − p|² over `points` is least, for a = `scale` above 0. `start` is
/// where to look first.
pub fn pulled_centre(points: &[DVec3], pull: DVec3, scale: f64, start: DVec3) -> DVec3 {
    let shift = pull / (2.0 * scale);
    let site = |p: DVec3| Site { q: p - shift, weight: 2.0 * p.dot(shift) - shift.length_squared() };
    let farthest = |c: DVec3| {
        let power = |p: &DVec3| (c - *p).length_squared() + 2.0 * c.dot(shift);
        points.iter().map(|p| (power(p), *p)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let Some((_, first)) = farthest(start) else { return start };
    let mut best = smallest(&[site(first)]);
    for _ in 0..ROUNDS {
        let Some((power, point)) = farthest(best.centre) else { break };
        if power <= best.power + 1e-12 * best.power.abs().max(best.centre.length_squared()) {
            break;
        }
        let mut sites = best.support.clone();
        sites.push(site(point));
        let next = smallest(&sites);
        if next.power <= best.power {
            break;
        }
        best = next;
    }
    best.centre
}

#[derive(Debug, Clone, Copy)]
struct Site {
    q: DVec3,
    weight: f64,
}

#[derive(Debug, Clone)]
struct Smallest {
    centre: DVec3,
    power: f64,
    /// At most four sites that hold it in place: equally far from the centre, which lies in their hull.
    support: Vec<Site>,
}

/// The smallest ball around at most five sites: of the centres equally far from some of them and in their
/// hull the one that serves all best.
fn smallest(sites: &[Site]) -> Smallest {
    let mut best = Smallest { centre: DVec3::ZERO, power: f64::INFINITY, support: Vec::new() };
    for subset in 1_u32..1 << sites.len().min(5) {
        if subset.count_ones() > 4 {
            continue;
        }
        let support: Vec<Site> =
            sites.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1).map(|(_, s)| *s).collect();
        let Some(centre) = equidistant(&support) else { continue };
        let power = sites
            .iter()
            .map(|s| (centre - s.q).length_squared() + s.weight)
            .fold(f64::NEG_INFINITY, f64::max);
        if power < best.power {
            best = Smallest { centre, power, support };
        }
    }
    best
}

/// The point of the sites' affine hull that is equally far from all, if it lies between them: else they
/// cannot hold a ball in place, though others that happen to be as far may.
fn equidistant(sites: &[Site]) -> Option<DVec3> {
    let (first, rest) = sites.split_first()?;
    let edge = |i: usize| rest.get(i).map_or(DVec3::ZERO, |s| s.q - first.q);
    let value =
        |i: usize| rest.get(i).map_or(0.0, |s| (edge(i).length_squared() + s.weight - first.weight) / 2.0);
    let edges = [edge(0), edge(1), edge(2)];
    // Columns that no site fills stand for directions that the hull lacks.
    let filled = match rest.len() {
        0 => return Some(first.q),
        1 if edges[0] == DVec3::ZERO => return None,
        1 => {
            let other = edges[0].any_orthogonal_vector();
            DMat3::from_cols(edges[0], other, edges[0].cross(other))
        }
        2 => DMat3::from_cols(edges[0], edges[1], edges[0].cross(edges[1])),
        _ => DMat3::from_cols(edges[0], edges[1], edges[2]),
    };
    let scale = filled.x_axis.length() * filled.y_axis.length() * filled.z_axis.length();
    if filled.determinant().abs() <= 1e-12 * scale {
        return None;
    }
    let inverse = filled.inverse();
    let offset = inverse.transpose() * DVec3::new(value(0), value(1), value(2));
    let shares = inverse * offset;
    let between = shares.min_element() >= -SLACK && shares.element_sum() <= 1.0 + SLACK;
    between.then(|| first.q + offset)
}
