//! The `player` binary: parses the command line, passes on interrupts, reports errors.

#![forbid(unsafe_code)]

use clap::Parser as _;
use relume_formats::name::one_line;
use relume_player::Interrupt;
use relume_player::cli::{self, Cli};
use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;
#[cfg(target_os = "linux")]
use std::{path::Path, process::Command};

static INTERRUPT: Interrupt = Interrupt::new();

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    without_device_selection();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => {
            // Help and version: a reader that closes the pipe early has seen enough.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => return fail(&cli::one_line(&error), 2),
    };
    if let Some(text) = cli.described() {
        return match std::io::stdout().write_all(&text) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                fail(&format!("cannot write to stdout: {error}"), 1)
            }
            // A closed pipe is the reader's choice, not a failure.
            _ => ExitCode::SUCCESS,
        };
    }
    if let Err(error) = ctrlc::set_handler(on_interrupt) {
        return fail(&format!("cannot listen for interrupts: {error}"), 1);
    }
    if let Err(error) = outlive_file_limits() {
        return fail(&format!("cannot listen for signals: {error}"), 1);
    }
    match relume_player::run(&cli, &INTERRUPT) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error.to_string(), error.exit_code()),
    }
}

/// Starts the program afresh without Mesa's device-selection layer where no Wayland display can be. That
/// layer would ask for one even so, and libwayland would then report, as lines of `error: …` on our stderr,
/// that XDG_RUNTIME_DIR is not set. The layer only sorts adapters, which the player does for itself. The
/// layer is told by an environment variable, which a running program cannot set safely.
#[cfg(target_os = "linux")]
fn without_device_selection() {
    use std::os::unix::process::CommandExt as _;
    const SWITCH: &str = "NODEVICE_SELECT";
    let wayland_possible =
        std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute());
    if wayland_possible || std::env::var_os(SWITCH).is_some() {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        // Returns only if it fails, and then the noise is the lesser evil.
        let _ = Command::new(program).args(std::env::args_os().skip(1)).env(SWITCH, "1").exec();
    }
}

/// The first signal ends the work at its next step, the second at once: every file is written whole or not at
/// all.
fn on_interrupt() {
    if INTERRUPT.raise() {
        std::process::exit(130);
    }
}

/// From now on a write beyond the user's limit of a file's size (`ulimit -f`) fails as on a full disk,
/// instead of ending the program without a word.
fn outlive_file_limits() -> std::io::Result<()> {
    // That somebody watches is all that it takes.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default())?;
    Ok(())
}

/// Reports an error on exactly one line. Nobody listening is no reason to fail otherwise.
fn fail(message: &str, code: u8) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "error: {}", one_line(message));
    ExitCode::from(code)
}
