//! Long work: progress with time left, and interruption.

use crate::interrupted::Interrupted;
use crate::memory::MemoryLimit;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use relume_formats::name::plain;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write as _};
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How progress is told, always on stderr.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProgressMode {
    /// A bar on a terminal, else plain lines.
    Auto,
    /// A line now and then.
    Plain,
    /// A JSON object a line: stage, done, total, seconds, seconds_left.
    Json,
    /// Nothing.
    None,
}

static STOP: AtomicBool = AtomicBool::new(false);

/// How much the program says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Voice {
    /// Warnings and errors: no progress and no notes.
    Quiet,
    /// Notes and progress, too.
    Usual,
    /// How long every step takes, and every warning however many there are.
    Verbose,
}

static VOICE: AtomicU8 = AtomicU8::new(Voice::Usual as u8);

/// From now on the program says so much.
pub fn speak(voice: Voice) {
    VOICE.store(voice as u8, Ordering::Relaxed);
}

/// Whether all is told that there is to tell.
pub fn is_verbose() -> bool {
    VOICE.load(Ordering::Relaxed) >= Voice::Verbose as u8
}

fn is_quiet() -> bool {
    VOICE.load(Ordering::Relaxed) == Voice::Quiet as u8
}

/// [`say`]s a line of which nobody needs to know who wants it quiet.
pub fn note(line: &str) {
    if !is_quiet() {
        say(line);
    }
}

/// [`say`]s a line that only who asked for more wants to read.
pub fn detail(line: &str) {
    if is_verbose() {
        say(line);
    }
}

/// From now on Ctrl-C and SIGTERM end what is running at its next step.
///
/// # Errors
/// If the handler cannot be installed.
pub fn watch_signals() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        // A second signal does not wait for the step to end. Finished steps are safe on disk already.
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    })
}

/// From now on a write beyond the user's limit of a file's size (`ulimit -f`) fails as on a full disk,
/// instead of ending the program without a word.
///
/// # Errors
/// If the signal cannot be watched.
pub fn outlive_file_limits() -> std::io::Result<()> {
    // That somebody watches is all that it takes.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// The work of one command.
#[derive(Debug, Clone)]
pub struct Job {
    mode: ProgressMode,
    memory: MemoryLimit,
    start: Instant,
    steps: Arc<Mutex<Steps>>,
}

/// Wall-clock seconds of every step, by its name.
pub type Steps = BTreeMap<&'static str, f64>;

impl Job {
    /// A job that tells its progress in the given way.
    pub fn new(mode: ProgressMode) -> Self {
        let mode = match mode {
            _ if is_quiet() => ProgressMode::None,
            ProgressMode::Auto if !std::io::stderr().is_terminal() => ProgressMode::Plain,
            other => other,
        };
        Self { mode, memory: MemoryLimit::Free, start: Instant::now(), steps: Arc::default() }
    }

    /// The same job with a limit of memory of its own.
    pub fn with_memory(self, memory: MemoryLimit) -> Self {
        Self { memory, ..self }
    }

    /// The same job with nothing done yet.
    pub fn anew(&self) -> Self {
        Self { start: Instant::now(), steps: Arc::default(), ..*self }
    }

    /// How much memory the job may take.
    pub fn memory(&self) -> MemoryLimit {
        self.memory
    }

    /// Starts a step, which lasts until what is returned is dropped. Steps of the same name add up; none may
    /// begin within another, so that all together are as long as the job at most.
    pub fn step(&self, name: &'static str) -> Step {
        Step { name, start: Instant::now(), steps: Arc::clone(&self.steps) }
    }

    /// Wall-clock seconds since the job began.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// What the steps that ended took.
    pub fn steps(&self) -> Steps {
        self.steps.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Starts a step of so many parts, to be told as they are done.
    pub fn progress(&self, name: &'static str, total: u64) -> Progress {
        let bar = match self.mode {
            ProgressMode::Auto => {
                ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(8))
            }
            _ => ProgressBar::hidden(),
        };
        if let Ok(style) =
            ProgressStyle::with_template("{msg:<12} {wide_bar} {percent:>3} %  {elapsed} gone, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(name);
        let step = self.step(name);
        let last_told = Mutex::new(step.start);
        Progress { mode: self.mode, total, done: AtomicU64::new(0), bar, step, last_told }
    }
}

/// A step that has begun; it ends when this is dropped.
#[derive(Debug)]
pub struct Step {
    name: &'static str,
    start: Instant,
    steps: Arc<Mutex<Steps>>,
}

impl Drop for Step {
    fn drop(&mut self) {
        let mut steps = self.steps.lock().unwrap_or_else(PoisonError::into_inner);
        *steps.entry(self.name).or_default() += self.start.elapsed().as_secs_f64();
    }
}

/// How far something is; its steps may be done by many threads.
#[derive(Debug)]
pub struct Progress {
    mode: ProgressMode,
    total: u64,
    done: AtomicU64,
    bar: ProgressBar,
    step: Step,
    last_told: Mutex<Instant>,
}

/// Time between two lines of plain progress.
const PLAIN_INTERVAL: Duration = Duration::from_secs(5);
/// Time between two lines of JSON progress.
const JSON_INTERVAL: Duration = Duration::from_millis(500);

impl Progress {
    /// Counts `steps` more steps as done.
    pub fn advance(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.bar.inc(steps);
        let interval = match self.mode {
            ProgressMode::Plain => PLAIN_INTERVAL,
            ProgressMode::Json => JSON_INTERVAL,
            ProgressMode::Auto | ProgressMode::None => return,
        };
        let Ok(mut last_told) = self.last_told.try_lock() else { return };
        if done == self.total || last_told.elapsed() >= interval {
            *last_told = Instant::now();
            self.tell(done);
        }
    }

    fn tell(&self, done: u64) {
        let seconds = self.step.start.elapsed().as_secs_f64();
        let left = seconds / done.max(1) as f64 * self.total.saturating_sub(done) as f64;
        if self.mode == ProgressMode::Json {
            let line = serde_json::json!({ "stage": self.step.name, "done": done, "total": self.total, "seconds": seconds, "seconds_left": left });
            say(&line.to_string());
        } else {
            say(&format!(
                "{}: {} %, {seconds:.0} s gone, {left:.0} s left",
                self.step.name,
                100 * done / self.total.max(1)
            ));
        }
    }

    /// Fails if the user asked to stop.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn check(&self) -> Result<(), Interrupted> {
        if STOP.load(Ordering::SeqCst) { Err(Interrupted) } else { Ok(()) }
    }
}

/// A line on stderr, whatever names it has in it. Nobody listening is no reason to stop.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", plain(line));
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_add_up_by_name_within_the_time_of_the_job() {
        let job = Job::new(ProgressMode::None);
        for _ in 0..3 {
            let start = Instant::now();
            let before = job.steps().get("tracing").copied().unwrap_or_default();
            let progress = job.progress("tracing", 1);
            assert_eq!(job.steps().get("tracing").copied().unwrap_or_default(), before, "not before it ends");
            drop(progress);
            let took = job.steps()["tracing"] - before;
            assert!(took > 0.0 && took <= start.elapsed().as_secs_f64());
        }
        drop(job.step("writing"));
        assert_eq!(job.steps().into_keys().collect::<Vec<_>>(), ["tracing", "writing"]);
        assert!(job.steps().into_values().sum::<f64>() <= job.seconds());
        assert!(job.anew().steps().is_empty(), "another bake of the same command");
    }
}
