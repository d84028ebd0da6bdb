//! Runs the `player` that stands beside `bake`: what it shows and how long a frame takes is measured on the
//! program that users run.

use relume_bake::error::{BakeError, Result};
use relume_bake::interrupted::Interrupted;
use relume_formats::{Error, Place};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// What to play.
#[derive(Debug, Clone, Copy)]
pub struct Playing<'a> {
    /// Folder of the bundle.
    pub folder: &'a Path,
    /// By which of its methods.
    pub method: &'a str,
    /// An animation file with a frame at every whole second from 0 on.
    pub animation: &'a Path,
    /// Number of frames.
    pub frames: u32,
    /// Size of the frames in pixels.
    pub size: [u32; 2],
    /// Where frames go, a pattern such as `OUT/%04d.exr`; without it they are only timed.
    pub exr: Option<&'a str>,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Played {
    /// Name of the GPU adapter.
    pub adapter: String,
    /// Median milliseconds of a frame, CPU and GPU together; of the CPU alone where the device has no clock.
    pub median_ms: f64,
    /// 95th percentile of the same.
    pub p95_ms: f64,
    /// Bytes of all buffers and textures on the device, where it tells.
    pub gpu_bytes: Option<u64>,
}

/// The part of the player's statistics that is used here.
#[derive(Deserialize)]
struct Stats {
    adapter: String,
    cpu_ms: Option<Spread>,
    frame_ms: Option<Spread>,
    gpu_bytes: Option<u64>,
}

#[derive(Deserialize)]
struct Spread {
    median: f64,
    p95: f64,
}

/// The player's program, in the folder of this one.
///
/// # Errors
/// [`BakeError::Player`] if there is none.
pub fn player() -> Result<PathBuf> {
    let beside = std::env::current_exe().ok().and_then(|path| {
        let folder = path.parent()?.to_owned();
        // Tests stand one folder deeper.
        [Some(folder.clone()), folder.parent().map(Path::to_owned)]
            .into_iter()
            .flatten()
            .map(|f| f.join(NAME))
            .find(|p| p.is_file())
    });
    beside.ok_or_else(|| {
        BakeError::Player(format!(
            "there is no `{NAME}` beside `bake`, which shows and times frames; run `make build`"
        ))
    })
}

/// How often it is asked whether the player has ended.
const POLL: Duration = Duration::from_millis(10);

const NAME: &str = if cfg!(windows) { "player.exe" } else { "player" };

impl Playing<'_> {
    /// Plays all frames without a window.
    ///
    /// # Errors
    /// [`BakeError::Player`] with what the player says; [`BakeError::Interrupted`] if the user stopped it.
    pub fn play(&self) -> Result<Played> {
        self.play_within(Duration::MAX)
    }

    /// As [`Playing::play`], but stops a player that takes longer than `limit`.
    ///
    /// # Errors
    /// As there, and [`BakeError::Player`] if it took longer.
    pub fn play_within(&self, limit: Duration) -> Result<Played> {
        let folder = tempfile::tempdir().map_err(|e| Error::output(&Place::file(std::env::temp_dir()), e))?;
        let stats = folder.path().join("stats.json");
        let [width, height] = self.size;
        let mut command = Command::new(player()?);
        command.arg(self.folder).arg("--headless").args(["--method", self.method, "--fps", "1"]);
        command.arg("--animation").arg(self.animation).args(["--count", &self.frames.to_string()]);
        command.args(["--size", &format!("{width}x{height}")]).arg("--stats").arg(&stats);
        command.args(self.exr.iter().flat_map(|pattern| ["--exr", pattern]));
        let output = output_within(command.stdin(Stdio::null()), limit)?;
        if output.status.code() == Some(130) {
            return Err(Interrupted.into());
        }
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().rfind(|line| line.starts_with("error: ")).unwrap_or("it said nothing");
            return Err(BakeError::Player(format!(
                "the player failed on {}: {}",
                self.folder.display(),
                last.trim_start_matches("error: ")
            )));
        }
        let text = std::fs::read(&stats).map_err(|e| Error::output(&Place::file(&stats), e))?;
        let stats = serde_json::from_slice(&text).map_err(|e| {
            BakeError::Player(format!("the player's statistics: {e}; build both programs anew"))
        })?;
        played(stats).ok_or_else(|| BakeError::Player("the player showed no frame".to_owned()))
    }
}

/// What `command` says, if it ends within `limit`.
fn output_within(command: &mut Command, limit: Duration) -> Result<Output> {
    let cannot = |e: std::io::Error| BakeError::Player(format!("cannot run the player: {e}"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(cannot)?;
    let start = Instant::now();
    // It says a few lines at most, which a pipe holds without a reader.
    while child.try_wait().map_err(cannot)?.is_none() {
        if start.elapsed() > limit {
            let _ = child.kill();
            let _ = child.wait();
            return Err(BakeError::Player(format!("the player took longer than {} s", limit.as_secs())));
        }
        std::thread::sleep(POLL);
    }
    child.wait_with_output().map_err(cannot)
}

fn played(stats: Stats) -> Option<Played> {
    let Stats { adapter, cpu_ms, frame_ms, gpu_bytes } = stats;
    let Spread { median, p95 } = frame_ms.or(cpu_ms)?;
    Some(Played { adapter, median_ms: median, p95_ms: p95, gpu_bytes })
}
