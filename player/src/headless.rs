//! Playing without a window: frames to files.

use crate::cli::{Cli, Exposure};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::interrupt::Interrupt;
use crate::output::{ContactSheet, encode_exr, encode_png, write_whole};
use crate::session::{AnimationChoice, Frame, Request, Session};
use crate::stats::{Appearance, Recorder};
use crate::stream::Limits;
use indicatif::{ProgressBar, ProgressStyle};
use relume_formats::Place;
use relume_formats::state::{Animation, CameraState, Rgb, State, ViewState};
use relume_playback::{NOT_MEASURED, PlacedAnimation, PlacedState, Progress};
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// How long to sleep when nothing has arrived.
const NAP: Duration = Duration::from_millis(1);

/// The options that make a run without a window worth it.
pub(crate) const WHAT_TO_ADD: &str =
    "--frames 'OUT/%04d.png', --exr 'OUT/%04d.exr', --contact-sheet FILE.png or --stats FILE.json";

/// Plays as `cli` says, until done or `interrupt` is raised.
pub fn play(cli: &Cli, interrupt: &Interrupt) -> Result<()> {
    let started = Instant::now();
    check_usage(cli)?;
    let mut session = Session::start(request(cli)?, || Gpu::open(cli.adapter.as_deref()))?;
    let appearance = load(&mut session, started, interrupt, |session| frame_count(cli, session).map(|_| ()))?;
    let count = frame_count(cli, &session)?;
    meter(&mut session)?;
    let recorder = render_frames(cli, &mut session, count, interrupt)?;
    match &cli.stats {
        Some(path) => write_whole(path, &recorder.finish(&session, appearance)?),
        None => Ok(()),
    }
}

fn check_usage(cli: &Cli) -> Result<()> {
    let writes_something =
        cli.frames.is_some() || cli.exr.is_some() || cli.contact_sheet.is_some() || cli.stats.is_some();
    if writes_something { Ok(()) } else { Err(Error::Usage(format!("nothing to write; add {WHAT_TO_ADD}"))) }
}

/// What `cli` asks to play.
pub(crate) fn request(cli: &Cli) -> Result<Request<'_>> {
    let mut state = match &cli.state {
        None => PlacedState::default(),
        Some(path) => PlacedState { state: State::read_file(path)?, place: Place::file(path) },
    };
    show_as_asked(cli, &mut state.state);
    let animation = match cli.animation.as_deref() {
        Some(file) if file.ends_with(".toml") => {
            let place = Place::file(file);
            Some(AnimationChoice::Own(PlacedAnimation {
                animation: Animation::read_file(Path::new(file))?,
                place,
            }))
        }
        other => other.map(AnimationChoice::Named),
    };
    Ok(Request {
        folder: cli.folder.as_deref().unwrap_or(Path::new(".")),
        method: cli.method.as_deref(),
        state,
        animation,
        environment: cli.environment.as_deref(),
        meters: cli.exposure == Some(Exposure::Auto),
        size: cli.size,
        limits: Limits { bytes: cli.bytes, bytes_per_second: cli.rate },
    })
}

/// Sets what options say of the display.
fn show_as_asked(cli: &Cli, state: &mut State) {
    if let Some(tonemap) = cli.tonemap {
        state.view = Some(ViewState { tonemap: Some(tonemap) });
    }
    if let Some(Exposure::Ev(ev)) = cli.exposure {
        state.camera = Some(CameraState { exposure_ev: Some(ev), ..state.camera.take().unwrap_or_default() });
    }
}

/// Exposes by the first frame if that is asked for.
fn meter(session: &mut Session) -> Result<()> {
    if !session.meters() {
        return Ok(());
    }
    session.render(0.0)?;
    if let (Some(ev), Some(controls)) = (session.metered_ev()?, session.player_mut().controls_mut()) {
        controls.expose(ev);
    }
    Ok(())
}

/// Takes in everything that comes, rendering once as soon as anything can be seen and once at the end.
/// `check` sees the session when the controls are known, before the long part of the wait.
pub(crate) fn load(
    session: &mut Session,
    started: Instant,
    interrupt: &Interrupt,
    check: impl Fn(&Session) -> Result<()>,
) -> Result<Appearance> {
    let mut appearance = Appearance::default();
    let mut checked = false;
    loop {
        stop_if(interrupt)?;
        let progress = session.advance()?;
        if !checked && session.player().controls().is_some() {
            check(session)?;
            checked = true;
        }
        match progress {
            Progress::Waiting => std::thread::sleep(NAP),
            Progress::Arrived if appearance.first_s.is_none() && session.player().is_ready() => {
                session.render(0.0)?;
                appearance.first_s = Some(started.elapsed().as_secs_f64());
            }
            Progress::Arrived => {}
            Progress::Loaded { complete: false } => return Ok(appearance),
            Progress::Loaded { complete: true } => {
                session.render(0.0)?;
                appearance.full_s = Some(started.elapsed().as_secs_f64());
                return Ok(appearance);
            }
        }
    }
}

fn stop_if(interrupt: &Interrupt) -> Result<()> {
    if interrupt.is_raised() { Err(Error::Interrupted) } else { Ok(()) }
}

/// Frames a second.
fn fps(cli: &Cli) -> f32 {
    cli.fps.unwrap_or(30.0)
}

/// How many frames to render. Fails if their names would be the same.
fn frame_count(cli: &Cli, session: &Session) -> Result<usize> {
    let of_animation = session.player().controls().map_or(1, |controls| controls.frame_count(fps(cli)));
    let count = cli.count.map_or(of_animation, |count| count as usize);
    let plain = cli.frames.iter().chain(&cli.exr).find(|path| !path.is_numbered());
    match plain {
        Some(path) if count > 1 => {
            let name = path.of(0).display().to_string();
            Err(Error::Usage(format!(
                "`{name}` would be overwritten by each of {count} frames; put %04d into the name, or add --count 1"
            )))
        }
        _ => Ok(count),
    }
}

fn render_frames(cli: &Cli, session: &mut Session, count: usize, interrupt: &Interrupt) -> Result<Recorder> {
    let size = session.player().film().map_or([0, 0], |film| film.size);
    let bar = progress_bar(count);
    let mut recorder = Recorder::default();
    let mut sheet = ContactSheet::new(count);
    let mut from_outside = false;
    for index in 0..count {
        stop_if(interrupt)?;
        let frame = session.render(index as f64 / f64::from(fps(cli)))?;
        recorder.add(&frame.cost);
        from_outside |= session.player().shows_map_from_outside();
        write_frame(cli, size, index, &frame, &mut sheet)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    if from_outside {
        // Nobody listening is no reason to fail.
        let _ = writeln!(std::io::stderr(), "warning: {NOT_MEASURED}");
    }
    if let Some(path) = &cli.contact_sheet {
        write_whole(path, &sheet.encode()?)?;
    }
    Ok(recorder)
}

fn write_frame(
    cli: &Cli,
    size: [u32; 2],
    index: usize,
    frame: &Frame,
    sheet: &mut ContactSheet,
) -> Result<()> {
    if let Some(path) = &cli.exr {
        write_whole(&path.of(index), &encode_exr(size, &frame.radiance)?)?;
    }
    let on_sheet = cli.contact_sheet.is_some() && sheet.wants(index);
    if cli.frames.is_none() && !on_sheet {
        return Ok(());
    }
    let display: Vec<Rgb> = frame.radiance.iter().map(|radiance| frame.display.shown(*radiance)).collect();
    if on_sheet {
        sheet.add(size, &display);
    }
    match &cli.frames {
        Some(path) => write_whole(&path.of(index), &encode_png(size, &display)?),
        None => Ok(()),
    }
}

/// A bar on a terminal's stderr; nothing elsewhere, and nothing for a single frame.
fn progress_bar(count: usize) -> ProgressBar {
    if count < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} frame {pos} of {len}, {eta} left");
    ProgressBar::new(count as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
