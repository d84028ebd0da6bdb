//! The command line of `player`.

use crate::output::FramePath;
use clap::{CommandFactory as _, Parser};
use relume_formats::display::Tonemap;
use relume_formats::error::in_plain_words;
use relume_formats::state::MAX_EXPOSURE_EV;
use std::path::PathBuf;

/// Plays a bundle that `bake run` wrote: light transport computed beforehand, and what the scene lets vary
/// free to change.
///
/// Opens a window in which materials, light, view and shapes are changed and animations played, as far as they vary;
/// its panel and its bottom line tell how. With --headless it writes frames to files instead.
///
/// A state names what differs from the scene's defaults; an animation is applied on top of it. Frame i shows
/// the state at i/fps seconds, and a looping animation starts again after its end. EXR frames are linear
/// radiance; PNG frames are exposed, brought into the range of a display by a curve (tone mapping), and
/// sRGB-encoded.
///
/// Exit codes: 0 done, 1 failed at run time, 2 wrong usage or bad input, 130 interrupted.
#[derive(Debug, Clone, Parser)]
#[command(name = "player", version = env!("RELUME_VERSION"), max_term_width = 120)]
pub struct Cli {
    /// Folder of the bundle
    #[arg(value_name = "DIR", required_unless_present_any = ["list_adapters", "completions", "man"])]
    pub folder: Option<PathBuf>,
    /// Method to play, for a bundle that has several [default: the one it prefers]
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,
    /// Animation to play: the name of one in the bundle, or a file that ends in .toml; a window offers the
    /// others, too, that the method can play
    #[arg(long, value_name = "NAME|FILE")]
    pub animation: Option<String>,
    /// State to start from: what differs from the scene's defaults
    #[arg(long, value_name = "STATE.toml")]
    pub state: Option<PathBuf>,
    /// Environment map to light the scene by, over the state's: an equirectangular .exr or .hdr; for bundles
    /// whose light varies
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Curve from radiance to the display, over the state's: clamp, neutral or agx [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = parse_tonemap)]
    pub tonemap: Option<Tonemap>,
    /// Exposure in EV, over the state's, or `auto`, which brings the geometric mean of the first frame's
    /// luminance to 0.18 [default: the scene's]
    #[arg(long, value_name = "EV|auto", value_parser = parse_exposure, allow_negative_numbers = true)]
    pub exposure: Option<Exposure>,
    /// Size of the frames [default: the scene's; in a window what the picture covers]; the images of
    /// transfer-images are baked at one size, so it must be that one
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// GPU adapter to use: any part of its name, in any case; `cpu` does without, for methods that can
    /// [default: the fastest kind there is; `cpu` where that is faster than a software adapter]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// List the GPU adapters of this machine and stop
    #[arg(long)]
    pub list_adapters: bool,
    /// Print what completes `player` in a shell, and stop
    #[arg(long, value_name = "SHELL")]
    pub completions: Option<clap_complete::Shell>,
    /// Print the manual page of `player`, and stop
    #[arg(long)]
    pub man: bool,
    /// Play only what fits in the first N bytes of the bundle's files, in playback order
    #[arg(long, value_name = "N")]
    pub bytes: Option<u64>,
    /// Read at most N bytes a second
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub rate: Option<u64>,
    /// Render to files, without a window: --frames, --exr, --contact-sheet or --stats say which
    #[arg(long)]
    pub headless: bool,
    /// Write PNG frames; the number of the frame replaces %d or %04d
    #[arg(long, value_name = "OUT/%04d.png", value_parser = parse_png)]
    pub frames: Option<FramePath>,
    /// Write EXR frames: linear radiance, before exposure and curve
    #[arg(long, value_name = "OUT/%04d.exr", value_parser = parse_exr)]
    pub exr: Option<FramePath>,
    /// Frames a second of the animation [default: 30]
    #[arg(long, value_name = "N", value_parser = parse_fps)]
    pub fps: Option<f32>,
    /// Number of frames [default: the whole animation once, or 1 without an animation]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub count: Option<u32>,
    /// Write timings and sizes as JSON; with a window, when it is closed
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Write up to 12 evenly spaced frames as one PNG
    #[arg(long, value_name = "FILE.png")]
    pub contact_sheet: Option<PathBuf>,
}

/// How the exposure is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exposure {
    /// By value, EV.
    Ev(f32),
    /// By the picture.
    Auto,
}

fn parse_tonemap(text: &str) -> Result<Tonemap, String> {
    Tonemap::of_name(text).ok_or_else(|| format!("give {}", Tonemap::ALL.map(Tonemap::name).join(", ")))
}

fn parse_exposure(text: &str) -> Result<Exposure, String> {
    match text.parse::<f32>() {
        _ if text == "auto" => Ok(Exposure::Auto),
        Ok(ev) if (-MAX_EXPOSURE_EV..=MAX_EXPOSURE_EV).contains(&ev) => Ok(Exposure::Ev(ev)),
        _ => Err(format!("give a number of -{MAX_EXPOSURE_EV} to {MAX_EXPOSURE_EV}, or auto")),
    }
}

impl Cli {
    /// What completes this command line in a shell, or its manual page, if that is all that is asked for.
    pub fn described(&self) -> Option<Vec<u8>> {
        let mut text = Vec::new();
        match self.completions {
            Some(shell) => clap_complete::generate(shell, &mut Self::command(), "player", &mut text),
            None if self.man => clap_mangen::Man::new(Self::command()).render(&mut text).ok()?,
            None => return None,
        }
        Some(text)
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|size| !size.contains(&0)).ok_or_else(|| "give WIDTHxHEIGHT such as 512x512".to_owned())
}

fn parse_png(text: &str) -> Result<FramePath, String> {
    parse_frames(text, ".png")
}

fn parse_exr(text: &str) -> Result<FramePath, String> {
    parse_frames(text, ".exr")
}

/// A name says what is in the file.
fn parse_frames(text: &str, ending: &str) -> Result<FramePath, String> {
    let path = text.parse::<FramePath>()?;
    if text.to_ascii_lowercase().ends_with(ending) {
        Ok(path)
    } else {
        Err(format!("end the name in {ending}, which is what is written"))
    }
}

fn parse_fps(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(fps) if fps > 0.0 && fps <= 1e6 => Ok(fps),
        _ => Err("give a number above 0 and at most 1000000".to_owned()),
    }
}

/// clap's report on one line: what is wrong, without the usage that follows it.
pub fn one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let report = text.split("\nUsage:").next().unwrap_or(&text);
    let report = report.split("\nFor more information").next().unwrap_or(report);
    let flat = report.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("{}; see `player --help`", in_plain_words(flat.strip_prefix("error: ").unwrap_or(&flat)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn usage_errors_take_one_line() {
        for (arguments, part) in [
            (vec!["player"], "DIR"),
            (vec!["player", "d", "--fps", "0"], "above 0"),
            (vec!["player", "d", "--tonemap", "aces"], "give clamp, neutral, agx"),
            (vec!["player", "d", "--exposure", "33"], "give a number of -32 to 32, or auto"),
            (vec!["player", "d", "--count", "0"], "--count"),
            (vec!["player", "d", "--frames", "%d%d.png"], "exactly one"),
            (vec!["player", "d", "--frames", "%d.jpg"], "end the name in .png"),
            (vec!["player", "d", "--exr", "f.png"], "end the name in .exr"),
            (vec!["player", "d", "--framse", "%d.png"], "--frames"),
        ] {
            let message = one_line(&Cli::try_parse_from(arguments).unwrap_err());
            assert!(
                message.contains(part) && !message.contains('\n') && !message.starts_with("error"),
                "{message}"
            );
        }
    }
}
