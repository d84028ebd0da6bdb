//! What a chart says, in figures: `chart.json` and the types behind it.

use jiff::{Timestamp, tz::TimeZone};
use relume_formats::state::read_text;
use relume_formats::{Error, Place, Result, kinds::scene::MAX_SIDE};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

/// The figures, all of them.
pub const JSON: &str = "chart.json";
/// The same as a table, a row a point.
pub const CSV: &str = "chart.csv";
/// The same as a picture.
pub const SVG: &str = "chart.svg";
/// Images beside their references; [`run`](crate::chart::run) makes it, from what the figures do not hold.
pub const PICTURE: &str = "picture.png";
/// More points than that cannot be told apart in a picture.
const MAX_POINTS: usize = 400;
/// Longest name or label, in bytes.
const MAX_TEXT: usize = 200;
/// Most settings of a point.
const MAX_SETTINGS: usize = 64;

/// One figure over the states; infinite if an image held something that is no number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverStates {
    /// The middle one, or the mean of the two in the middle.
    #[serde(with = "maybe_infinite")]
    pub median: f64,
    /// The largest.
    #[serde(with = "maybe_infinite")]
    pub worst: f64,
}

/// How far images are from their references; none has a unit. [`super::metrics`] defines them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageErrors {
    /// Length of the difference over length of the reference.
    pub relative_l2: OverStates,
    /// Mean square of the difference relative to the reference's own, pixel by pixel.
    pub rel_mse: OverStates,
    /// Mean FLIP of the displayed images, 0 to 1.
    pub flip: OverStates,
    /// Largest difference over the mean of the reference.
    pub maximum: OverStates,
}

/// How long a frame takes, all states of the chart taken together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameTime {
    /// Median, milliseconds.
    pub median_ms: f64,
    /// 95th percentile, milliseconds.
    pub p95_ms: f64,
    /// This point's frame time over the baseline's, the two measured in turns.
    pub ratio: f64,
    /// `ratio_low..ratio_high` holds 95 % of what a second run would print.
    pub ratio_low: f64,
    /// See `ratio_low`.
    pub ratio_high: f64,
}

/// One method with one choice of settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Name of the method.
    pub method: String,
    /// Points of one method and series are joined by a line, in the order of the chart.
    pub series: String,
    /// Short, such as `6 bases`; with method and series it names the point.
    pub label: String,
    /// The settings that make the point.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Against the reference.
    pub errors: ImageErrors,
    /// What a frame costs.
    pub frame: FrameTime,
    /// Length of the files that a player reads.
    pub bytes_on_disk: u64,
    /// What the method keeps in memory while it plays.
    pub bytes_in_memory: u64,
    /// Wall-clock seconds of the bake.
    pub bake_seconds: f64,
}

impl Point {
    /// Method, series and label: what tells the point from all others.
    pub fn name(&self) -> String {
        format!("{}, {}, {}", self.method, self.series, self.label)
    }
}

/// What `picture.png` beside a chart shows: a point's images, the reference and the difference, for a few
/// states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// [`Point::name`] of the point.
    pub point: String,
    /// What the difference is multiplied by.
    pub factor: f32,
}

/// Everything that was measured on one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// Name of the scene.
    pub scene: String,
    /// Of the images, in pixels.
    pub size: [u32; 2],
    /// Number of random states that every point is measured on.
    pub states: u32,
    /// Samples a pixel of a reference.
    pub reference_samples: u32,
    /// Wall-clock seconds for all references together.
    pub reference_seconds: f64,
    /// How far the references themselves are from the truth.
    pub noise: ImageErrors,
    /// What drew the frames.
    pub adapter: String,
    /// [`Point::name`] of the point whose ratio is 1.
    pub baseline: String,
    /// What the picture beside the chart shows.
    pub picture: Picture,
    /// See [`machine`].
    pub machine: String,
    /// Day of the measurement, see [`today`].
    pub date: String,
    /// Name and version of the program.
    pub program: String,
    /// What was measured, method by method, along each sweep.
    pub points: Vec<Point>,
}

impl Chart {
    /// Reads the chart.json in `folder`.
    ///
    /// # Errors
    /// If there is none, or it is not what [`write`](crate::files::write) writes.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(JSON);
        let place = Place::file(&path);
        let refuse = |reason: String| Error::invalid(&place, format!("{reason}; {}", remedy(folder)));
        let text = read_text(&path).map_err(|error| match error {
            Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                refuse("there is no chart here".to_owned())
            }
            other => other,
        })?;
        let chart: Self = serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))?;
        chart.validate(&place)?;
        Ok(chart)
    }

    /// Checks what drawing relies on.
    ///
    /// # Errors
    /// With the first thing found wrong.
    pub(crate) fn validate(&self, place: &Place) -> Result<()> {
        let remedy = remedy(place.file.parent().unwrap_or(Path::new("")));
        let refuse = |what: String| Err(Error::invalid(place, format!("{what}; {remedy}")));
        if !self.size.iter().all(|n| (1..=MAX_SIDE).contains(n)) {
            return refuse(format!("images of {}×{} pixels", self.size[0], self.size[1]));
        }
        if self.points.is_empty() || self.points.len() > MAX_POINTS {
            return refuse(format!("{} points, where 1 to {MAX_POINTS} can be shown", self.points.len()));
        }
        if let Some(text) =
            self.texts().find(|text| text.len() > MAX_TEXT || text.chars().any(char::is_control))
        {
            return refuse(format!(
                "`{:.40}…` is longer than {MAX_TEXT} bytes or not one line",
                text.escape_default().to_string()
            ));
        }
        if let Some((what, value)) = self.numbers().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            return refuse(format!("{what} is {value}"));
        }
        if let Some((what, value)) = self.errors().find(|(_, value)| value.is_nan() || *value < 0.0) {
            return refuse(format!("an error of {what} is {value}"));
        }
        if let Some(point) = self.points.iter().find(|p| p.settings.len() > MAX_SETTINGS) {
            return refuse(format!(
                "{} has {} settings, at most {MAX_SETTINGS} are expected",
                point.name(),
                point.settings.len()
            ));
        }
        let mut names: Vec<String> = self.points.iter().map(Point::name).collect();
        names.sort();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => refuse(format!("two points are called {}", pair[0])),
            None => Ok(()),
        }
    }

    fn texts(&self) -> impl Iterator<Item = &str> {
        let own = [
            &self.scene,
            &self.adapter,
            &self.baseline,
            &self.picture.point,
            &self.machine,
            &self.date,
            &self.program,
        ];
        own.into_iter()
            .chain(self.points.iter().flat_map(|p| [&p.method, &p.series, &p.label]))
            .map(String::as_str)
    }

    /// What has to be finite.
    fn numbers(&self) -> impl Iterator<Item = (String, f64)> {
        let of = |p: &Point| {
            let FrameTime { median_ms, p95_ms, ratio, ratio_low, ratio_high } = p.frame;
            let name = p.name();
            [median_ms, p95_ms, ratio, ratio_low, ratio_high, p.bake_seconds]
                .map(|value| (format!("a time of {name}"), value))
        };
        let own = [
            ("reference_seconds", self.reference_seconds),
            ("the picture's factor", f64::from(self.picture.factor)),
        ];
        own.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(self.points.iter().flat_map(of))
    }

    /// What may also be infinite.
    fn errors(&self) -> impl Iterator<Item = (String, f64)> {
        let of = |name: String, e: &ImageErrors| {
            [e.relative_l2, e.rel_mse, e.flip, e.maximum]
                .into_iter()
                .flat_map(move |o| [(name.clone(), o.median), (name.clone(), o.worst)])
        };
        of("the reference".to_owned(), &self.noise)
            .chain(self.points.iter().flat_map(move |p| of(p.name(), &p.errors)))
    }
}

fn remedy(folder: &Path) -> String {
    format!("make it anew with `bake chart SCENE -o {}`", folder.display())
}

/// The machine in a line: processor, cores, memory.
pub fn machine() -> String {
    let wanted = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let Ok(system) = System::new_with_specifics(wanted) else {
        return format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    };
    let cpus = system.cpus();
    let model = cpus.first().map_or(std::env::consts::ARCH, |cpu| cpu.brand().trim());
    let gib = system.total_memory() as f64 / f64::from(1 << 30);
    format!("{model}, {} cores, {gib:.0} GiB", cpus.len())
}

/// Today in UTC, as ISO 8601 has it: 2026-01-31.
pub fn today() -> String {
    Timestamp::now().to_zoned(TimeZone::UTC).date().to_string()
}

/// JSON has no infinity; an infinite error is the text `infinite`.
mod maybe_infinite {
    use serde::{Deserialize, Deserializer, Serializer, de::Error as _};

    const INFINITE: &str = "infinite";

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        Number(f64),
        Text(String),
    }

    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    pub fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        if *value == f64::INFINITY { to.serialize_str(INFINITE) } else { to.serialize_f64(*value) }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        match Written::deserialize(from)? {
            Written::Number(value) => Ok(value),
            Written::Text(text) if text == INFINITE => Ok(f64::INFINITY),
            Written::Text(text) => Err(D::Error::custom(format!("an error is `{}`", text.escape_default()))),
        }
    }
}
