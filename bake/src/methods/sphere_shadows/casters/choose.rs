//! The cheapest of what objects could cast shadows by.

use super::By;
use super::options::CasterOption;

/// What an object is to cast by, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// What.
    pub by: By,
    /// Its relative L2 error in the pose and under the light where that is largest.
    pub error: f64,
    /// The same of its spheres, if it has some, with what a frame takes for them in parts of what is chosen.
    pub spheres: Option<(f64, f64)>,
}

/// One of the `options` of each object, so that the errors of all together stay below `error` in every pose and
/// under every light, for as little time a frame as can be found by taking one step after the other: where the
/// error is largest the one that lowers it most for its cost, and then what turns out not to be needed back.
/// If no choice stays below, the most exact that steps lead to.
pub fn chosen(options: &[Vec<CasterOption>], error: f64) -> Vec<Choice> {
    let mut at = vec![0; options.len()];
    let limit = error * error;
    while let Some((state, square)) = worst(options, &at).filter(|(_, square)| *square > limit) {
        let steps = (0..options.len()).flat_map(|o| (0..options[o].len()).map(move |to| (o, to)));
        let better = steps.filter_map(|(o, to)| {
            let (now, then) = (&options[o][at[o]], &options[o][to]);
            let gain = now.squares[state] - then.squares[state];
            // Steps to what is cheaper and better are free.
            let worth = gain / (then.by.cost() - now.by.cost()).max(1e-9);
            let mut after = at.clone();
            after[o] = to;
            // Where another pose or light gets worse than this one was, nothing is gained.
            (gain > 0.0 && worst(options, &after)?.1 < square).then_some((worth, o, to))
        });
        let Some((_, object, to)) = better.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        at[object] = to;
    }
    for object in 0..options.len() {
        let now = at[object];
        let before = worst(options, &at).map_or(0.0, |(_, square)| square).max(limit);
        let cost = options[object][now].by.cost();
        let mut cheaper: Vec<usize> =
            (0..options[object].len()).filter(|to| options[object][*to].by.cost() < cost).collect();
        cheaper.sort_by(|a, b| options[object][*a].by.cost().total_cmp(&options[object][*b].by.cost()));
        for to in cheaper {
            at[object] = to;
            if worst(options, &at).is_none_or(|(_, square)| square <= before) {
                break;
            }
            at[object] = now;
        }
    }
    options.iter().zip(at).map(|(options, at)| choice(options, at)).collect()
}

/// Where the squared errors of all objects together are largest, and what they are there.
fn worst(options: &[Vec<CasterOption>], at: &[usize]) -> Option<(usize, f64)> {
    let states = options.first()?.first()?.squares.len();
    let sum = |state: usize| options.iter().zip(at).map(|(options, at)| options[*at].squares[state]).sum();
    (0..states).map(|state| (state, sum(state))).max_by(|a: &(usize, f64), b| a.1.total_cmp(&b.1))
}

fn choice(options: &[CasterOption], at: usize) -> Choice {
    let by = options[at].by.clone();
    let spheres = options.iter().find(|option| matches!(option.by, By::Spheres(_)));
    let spheres = spheres.map(|option| (option.error(), option.by.cost() / by.cost().max(1.0)));
    Choice { error: options[at].error(), by, spheres }
}

#[cfg(test)]
mod tests {
    use super::super::surface::Simplified;
    use super::*;

    fn mesh(triangles: usize, squares: &[f64]) -> CasterOption {
        let mesh = Simplified {
            triangles: vec![[0, 1, 2]; triangles],
            closed: true,
            offsets: vec![[0.0; 3]; triangles],
            errors: vec![0.0; triangles],
        };
        CasterOption { by: By::Mesh(mesh), squares: squares.to_vec() }
    }

    fn other(by: By, squares: &[f64]) -> CasterOption {
        CasterOption { by, squares: squares.to_vec() }
    }

    fn words(options: &[Vec<CasterOption>], error: f64) -> Vec<String> {
        chosen(options, error).iter().map(|choice| choice.by.words()).collect()
    }

    #[test]
    fn the_cheapest_that_does_is_taken() {
        let near = || {
            vec![
                other(By::Nothing, &[0.04, 0.09]),
                mesh(16, &[0.01, 0.02]),
                mesh(64, &[0.001, 0.0005]),
                other(By::Spheres(64), &[0.01, 0.01]),
                mesh(256, &[0.0001, 0.0001]),
            ]
        };
        let far = || {
            vec![other(By::Nothing, &[0.0004, 0.0]), other(By::Spheres(2), &[0.0, 0.0]), mesh(8, &[0.0, 0.0])]
        };
        assert_eq!(words(&[near()], 0.5), ["nothing"], "what is not seen casts nothing");
        assert_eq!(words(&[near()], 0.04), ["64 triangles"]);
        assert_eq!(words(&[near()], 0.02), ["256 triangles"]);
        assert_eq!(words(&[near()], 1e-9), ["256 triangles"], "the most exact where nothing does");
        assert_eq!(
            words(&[near(), far()], 0.038),
            ["64 triangles", "nothing"],
            "0.001 and 0.0004 do together"
        );
        assert_eq!(words(&[near(), far()], 0.036), ["64 triangles", "2 spheres"], "and here they do not");
        assert_eq!(
            words(&[near(), far()], 0.011),
            ["256 triangles", "2 spheres"],
            "spheres where they are cheaper"
        );
        let choice = &chosen(&[near()], 0.04)[0];
        assert!((choice.error - 0.001f64.sqrt()).abs() < 1e-12);
        assert_eq!(
            choice.spheres,
            Some((0.1, 2.5)),
            "their error, and their cost beside that of 64 triangles"
        );
    }
}
