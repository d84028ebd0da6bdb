//! `chart.svg`: error against frame time, bytes and seconds of baking, in three panels, one below the other.
//!
//! Written without a plotting library: those at hand have no labels that keep out of each other's way, which
//! is most of this drawing, and axes are little beside that.

mod axis;
mod labels;
mod panel;
mod pen;
mod style;
mod text;

use super::digits::{percent, seconds};
use super::figures::{Chart, Point};
use panel::{Axis, Panel};
use pen::{Align, Pen};
use relume_formats::Result;
use style::{FAINT_INK, FRONT, INK, LINE, Style, TEXT, hex};

/// Width of the drawing in pixels, at which all text is easily read.
const WIDTH: f64 = 1200.0;
/// Room at the sides.
const SIDE: f64 = 34.0;
const TITLE: f64 = 25.0;

/// The three panels.
const AXES: [Axis; 3] = [
    Axis {
        title: "Error against frame time",
        subtitle: "milliseconds a frame, median",
        value: |p| p.frame.median_ms,
        format: super::digits::milliseconds,
    },
    Axis {
        title: "Error against size",
        subtitle: "bytes on disk",
        value: |p| p.bytes_on_disk as f64,
        format: super::digits::bytes,
    },
    Axis {
        title: "Error against baking",
        subtitle: "seconds of baking",
        value: |p| p.bake_seconds,
        format: seconds,
    },
];

/// The drawing. The same chart always makes the same bytes.
///
/// # Errors
/// If it cannot be written, which does not happen in memory.
pub fn draw(chart: &Chart) -> Result<String> {
    let methods = methods(chart);
    let facts = text::wrapped(&facts(chart), TEXT, WIDTH - 2.0 * SIDE);
    let legend = legend(&methods);
    let legend_top = SIDE + TITLE + 10.0 + LINE * facts.len() as f64;
    let mut top = legend_top + LINE * (1 + legend.last().map_or(0, |entry| entry.row)) as f64 + 8.0;
    let mut panels = Vec::new();
    for axis in &AXES {
        let panel = Panel::new(chart, axis, &methods, [SIDE, top, WIDTH - SIDE]);
        top = panel.bottom();
        panels.push(panel);
    }
    let mut pen = Pen::new(WIDTH, top + 0.5 * SIDE);
    pen.text(
        [SIDE, SIDE + 14.0],
        TITLE,
        Align::Left,
        &format!("{}: speed against accuracy", chart.scene),
        &[("font-weight", "bold")],
    );
    for (number, line) in facts.iter().enumerate() {
        pen.text(
            [SIDE, SIDE + TITLE + 16.0 + LINE * number as f64],
            TEXT,
            Align::Left,
            line,
            &[("fill", FAINT_INK)],
        );
    }
    legend.iter().for_each(|entry| entry.draw(&mut pen, legend_top));
    panels.iter().for_each(|panel| panel.draw(&mut pen));
    pen.finish()
}

/// Names of the methods as they first come.
fn methods(chart: &Chart) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for Point { method, .. } in &chart.points {
        if !names.contains(&method.as_str()) {
            names.push(method);
        }
    }
    names
}

/// What was measured, how, on what and when.
fn facts(chart: &Chart) -> String {
    let [width, height] = chart.size;
    format!(
        "{width}×{height} pixels, {} random states, references of {} samples a pixel traced in {}. Error: relative L2 against the reference, median over the states; the references' \
         own is {}. Frames on {}; {}; {}; {}. Time ratios in chart.csv are to {}.",
        chart.states,
        chart.reference_samples,
        seconds(chart.reference_seconds),
        percent(chart.noise.relative_l2.median),
        chart.adapter,
        chart.machine,
        chart.date,
        chart.program,
        chart.baseline
    )
}

/// What stands before the text of an entry.
#[derive(Clone, Copy)]
enum Sample {
    Method(Style),
    Front,
    Noise,
}

/// An entry of the legend.
struct Entry {
    sample: Sample,
    text: String,
    left: f64,
    row: usize,
}

const SAMPLE: f64 = 38.0;

fn legend(methods: &[&str]) -> Vec<Entry> {
    let own =
        methods.iter().enumerate().map(|(at, name)| (Sample::Method(Style::of(at)), (*name).to_owned()));
    let front =
        (Sample::Front, "Pareto front, marks filled: nothing is both cheaper and more exact".to_owned());
    let noise = (Sample::Noise, "noise of the reference".to_owned());
    let (mut left, mut row) = (SIDE, 0);
    let place = |(sample, text): (Sample, String)| {
        let width = SAMPLE + 8.0 + text::width(&text, TEXT);
        if left > SIDE && left + width > WIDTH - SIDE {
            (left, row) = (SIDE, row + 1);
        }
        let entry = Entry { sample, text, left, row };
        left += width + 26.0;
        entry
    };
    own.chain([front, noise]).map(place).collect()
}

impl Entry {
    fn draw(&self, pen: &mut Pen, top: f64) {
        let y = top + LINE * self.row as f64 + 5.0;
        let line = [[self.left, y], [self.left + SAMPLE, y]];
        match self.sample {
            Sample::Method(style) => {
                pen.lines(&line, &hex(style.colour), 1.5, &[]);
                pen.mark([self.left + 0.5 * SAMPLE, y], style, true);
            }
            Sample::Front => pen.lines(&line, FRONT, panel::FRONT_WIDTH, &[]),
            Sample::Noise => pen.lines(&line, INK, 1.5, &[("stroke-dasharray", panel::DASHES)]),
        }
        pen.text([self.left + SAMPLE + 8.0, y + 5.0], TEXT, Align::Left, &self.text, &[]);
    }
}

#[cfg(test)]
mod tests;
