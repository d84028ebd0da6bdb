//! A step of a bake, and what runs it: threads, log, progress, interruption, ray counts and shares of a
//! cluster are here and nowhere else.

use crate::error::{BakeError, Result};
use crate::job::{Job, note};
use crate::trace::world::{reset_ray_counts, take_ray_count};
use crate::work_log::WorkLog;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// A step whose work comes in numbered pieces. A piece depends on the key and its number alone, so that it
/// can be made at any time, in any order, anywhere.
pub trait Stage: Sync {
    /// What its log is called: the method's name, or the method's name and what else it does after a `-`.
    fn name(&self) -> String;

    /// What it does, for the user; `None` if its pieces tell their own progress.
    fn label(&self) -> Option<&'static str>;

    /// A hash of everything that its pieces depend on, and of nothing else.
    fn key(&self) -> u128;

    /// How many pieces there are.
    fn pieces(&self) -> u32;

    /// Piece number `number`, as bytes for the log.
    ///
    /// # Errors
    /// Whatever ends the bake.
    fn piece(&self, number: u32) -> Result<Vec<u8>>;

    /// Whether its log is kept beside the bundle: worth it where the log is small, and another bake is likely
    /// to need the very same pieces.
    fn keeps_log(&self) -> bool {
        false
    }

    /// The number that counts for shares of the first piece: stages of one piece each are dealt out by it.
    fn first_share(&self) -> u32 {
        0
    }
}

/// Which pieces of every stage are made here: each so many of them, the others elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// From 1 on.
    pub number: u32,
    /// Of so many.
    pub of: u32,
}

impl Share {
    /// All pieces.
    pub const WHOLE: Self = Self { number: 1, of: 1 };
    /// Most shares of one bake.
    const MOST: u32 = 1 << 16;

    /// Whether piece number `piece`, from 0 on, is made here. Neighbours go to different shares, so that all
    /// take about as long.
    pub fn has(self, piece: u32) -> bool {
        piece % self.of == self.number - 1
    }

    /// Whether there are others.
    pub fn is_part(self) -> bool {
        self.of > 1
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(number, of)| Some(Self { number: number.parse().ok()?, of: of.parse().ok()? }));
        let legal = numbers
            .filter(|share| (1..=Self::MOST).contains(&share.of) && (1..=share.of).contains(&share.number));
        legal.ok_or_else(|| {
            format!("expected I/N such as 3/100, with I from 1 to N and N at most {}", Self::MOST)
        })
    }
}

/// What running a stage took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Traced {
    /// Rays traced, shadow rays included; those of resumed pieces are not counted.
    pub rays: u64,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Pieces that were made.
    pub pieces: u32,
}

impl Traced {
    /// Adds what another stage took; of one that traced nothing not its seconds, which are those of rays.
    pub fn add(&mut self, other: Self) {
        self.rays += other.rays;
        self.seconds += if other.rays > 0 { other.seconds } else { 0.0 };
        self.pieces += other.pieces;
    }
}

/// Makes the pieces of `stage` that `log` lacks, as far as they are in `share`, on all threads.
///
/// # Errors
/// If a piece fails, the log cannot be written, or the job is interrupted; finished pieces stay in the log.
pub fn fill(stage: &dyn Stage, log: &WorkLog, share: Share, job: &Job) -> Result<Traced> {
    let finished = log.finished();
    let is_missing =
        |piece: &u32| finished.binary_search(piece).is_err() && share.has(stage.first_share() + piece);
    let missing: Vec<u32> = (0..stage.pieces()).filter(is_missing).collect();
    if let Some(label) = stage.label().filter(|_| !finished.is_empty() && !missing.is_empty()) {
        note(&format!("note: {label}: goes on after {} of {} pieces", finished.len(), stage.pieces()));
    }
    let progress = stage.label().map(|label| job.progress(label, missing.len() as u64));
    // What came before may have traced some, too.
    reset_ray_counts();
    let (rays, start) = (AtomicU64::new(0), Instant::now());
    missing.par_iter().try_for_each(|&piece| {
        progress.iter().try_for_each(crate::job::Progress::check)?;
        let bytes = stage.piece(piece)?;
        rays.fetch_add(take_ray_count(), Ordering::Relaxed);
        log.append(piece, &bytes)?;
        progress.iter().for_each(|progress| progress.advance(1));
        Ok::<_, BakeError>(())
    })?;
    Ok(Traced {
        rays: rays.into_inner(),
        seconds: start.elapsed().as_secs_f64(),
        pieces: missing.len() as u32,
    })
}

/// Whether `log` has all pieces of `stage`.
pub fn is_whole(stage: &dyn Stage, log: &WorkLog) -> bool {
    log.has_all(stage.pieces())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::ProgressMode;

    /// Pieces that say their number.
    struct Numbers;

    impl Stage for Numbers {
        fn name(&self) -> String {
            "numbers".to_owned()
        }

        fn label(&self) -> Option<&'static str> {
            Some("counting")
        }

        fn key(&self) -> u128 {
            7
        }

        fn pieces(&self) -> u32 {
            23
        }

        fn piece(&self, number: u32) -> Result<Vec<u8>> {
            Ok(vec![number as u8; number as usize])
        }
    }

    #[test]
    fn shares_are_read_and_deal_out_every_piece_once() {
        let share = |text: &str| text.parse::<Share>();
        assert_eq!(share("3/100"), Ok(Share { number: 3, of: 100 }));
        for text in ["", "3", "0/3", "4/3", "1/0", "a/b", "1/70000", "-1/3", "1/2/3"] {
            assert!(share(text).unwrap_err().contains("such as 3/100"), "{text}");
        }
        for of in 1..9 {
            let shares = (1..=of).map(|number| Share { number, of });
            let counts = shares.map(|share| (0..100).filter(|piece| share.has(*piece)).count());
            let counts: Vec<usize> = counts.collect();
            assert_eq!(counts.iter().sum::<usize>(), 100);
            assert!(counts.iter().all(|count| count.abs_diff(100 / of as usize) <= 1), "{counts:?}");
        }
    }

    #[test]
    fn only_what_is_missing_and_of_the_share_is_made() {
        let folder = tempfile::tempdir().unwrap();
        let log = WorkLog::create(&folder.path().join("log"), 7).unwrap();
        log.append(4, &[1]).unwrap();
        let job = Job::new(ProgressMode::None);
        let made = |share| fill(&Numbers, &log, share, &job).unwrap().pieces;
        assert_eq!(made(Share { number: 2, of: 3 }), 7, "1, 7, ... 22; 4 is there");
        assert!(!is_whole(&Numbers, &log));
        assert_eq!((made(Share::WHOLE), made(Share::WHOLE)), (15, 0));
        assert!(is_whole(&Numbers, &log));
        assert_eq!((log.read(4).unwrap(), log.read(5).unwrap()), (vec![1], vec![5; 5]));
    }
}
