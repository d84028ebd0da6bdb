//! Frame times in rounds: in each, all bundles are played in turns by processes of their own, so what the
//! machine does meanwhile falls on all of them, and ratios within a round are steadier than times.

use super::figures::FrameTime;
use super::sweep::Variant;
use crate::play::{Played, Playing};
use relume_bake::compress::statistics::median;
use relume_bake::error::Result;
use relume_bake::job::Job;
use std::path::Path;

/// Number of rounds.
const ROUNDS: usize = 7;
/// 97.5 % quantile of Student's t with one degree of freedom less than rounds.
const STUDENT: f64 = 2.447;

/// Plays the frames of `animation` by every variant, and says what they cost next to the first one's.
///
/// # Errors
/// If the player fails or the user interrupts.
pub fn measure(
    variants: &[Variant],
    animation: &Path,
    frames: u32,
    size: [u32; 2],
    job: &Job,
) -> Result<Vec<FrameTime>> {
    let progress = job.progress("timing", (variants.len() * ROUNDS) as u64);
    let mut rounds = Vec::new();
    for round in 0..ROUNDS {
        let mut played: Vec<(usize, Played)> = Vec::new();
        // There and back again: who comes late in one round is early in the next.
        let turns: Box<dyn Iterator<Item = usize>> =
            if round % 2 == 0 { Box::new(0..variants.len()) } else { Box::new((0..variants.len()).rev()) };
        for number in turns {
            progress.check()?;
            let Variant { method, folder, .. } = &variants[number];
            played.push((number, Playing { folder, method, animation, frames, size, exr: None }.play()?));
            progress.advance(1);
        }
        played.sort_by_key(|(number, _)| *number);
        rounds.push(
            played.into_iter().map(|(_, played)| [played.median_ms, played.p95_ms]).collect::<Vec<_>>(),
        );
    }
    Ok((0..variants.len()).map(|number| frame_time(&rounds, number)).collect())
}

/// What the rounds, each with the median and 95th percentile of every variant, say of variant `number`.
fn frame_time(rounds: &[Vec<[f64; 2]>], number: usize) -> FrameTime {
    let middle = |values: Vec<f64>| median(&values);
    let logs: Vec<f64> = rounds.iter().map(|round| (round[number][0] / round[0][0]).ln()).collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // Of the difference of two such means: a second run is as uncertain as this one.
    let within = STUDENT * (2.0 * variance / count).sqrt();
    FrameTime {
        median_ms: middle(rounds.iter().map(|round| round[number][0]).collect()),
        p95_ms: middle(rounds.iter().map(|round| round[number][1]).collect()),
        ratio: mean.exp(),
        ratio_low: (mean - within).exp(),
        ratio_high: (mean + within).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_taken_within_rounds() {
        // The machine is three times as slow in every other round.
        let rounds: Vec<_> = (0..ROUNDS)
            .map(|round| if round % 2 == 0 { 1.0 } else { 3.0 })
            .map(|slow| vec![[10.0 * slow, 11.0 * slow], [25.0 * slow, 30.0 * slow]])
            .collect();
        let time = frame_time(&rounds, 1);
        assert!(
            (time.ratio - 2.5).abs() < 1e-9 && (time.ratio_high - time.ratio_low).abs() < 1e-9,
            "{time:?}"
        );
        assert_eq!((time.median_ms, time.p95_ms), (25.0, 30.0));
        let first = frame_time(&rounds, 0);
        assert_eq!((first.ratio, first.ratio_low, first.ratio_high), (1.0, 1.0, 1.0));
    }

    /// Of many pairs of runs with log-normal times, the second ratio lies in the first's interval in 95 of
    /// 100, as Student's t has it.
    #[test]
    fn a_second_run_falls_into_the_interval_as_often_as_it_says() {
        let sampler = |run: u32| relume_bake::trace::sampler::PixelSampler::new(7, run);
        // Box and Muller.
        let normal = |run: u32, index: u32| {
            let [u, v] = sampler(run).sample(index).pair(index).map(f64::from);
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        let run = |run: u32| {
            let rounds: Vec<_> = (0..ROUNDS as u32)
                .map(|round| vec![[1.0, 1.0], [2.0 * (0.1 * normal(run, round)).exp(), 1.0]])
                .collect();
            frame_time(&rounds, 1)
        };
        let inside = (0..4000).filter(|pair| {
            let (first, second) = (run(2 * pair), run(2 * pair + 1));
            (first.ratio_low..=first.ratio_high).contains(&second.ratio)
        });
        let share = inside.count() as f64 / 4000.0;
        // Three standard deviations of a share of 95 % in 4000.
        assert!((share - 0.95).abs() < 3.0 * (0.95f64 * 0.05 / 4000.0).sqrt(), "{share}");
    }
}
