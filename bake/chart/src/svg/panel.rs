//! One panel: axes, the noise of the reference, the front, the series, marks and labels, and below it what
//! could not be drawn.

use super::super::digits::percent;
use super::super::figures::{Chart, Point};
use super::super::pareto::front;
use super::axis::LogAxis;
use super::labels::{Label, Rect, Segment, Surroundings, place};
use super::pen::{Align, Pen};
use super::style::{CARD, FAINT_INK, FRONT, GRID, INK, LINE, MARK_REACH, Style, TEXT, darker, hex};
use super::text::{ASCENT, DESCENT, width, wrapped};
use std::collections::BTreeMap;

/// Width of the Pareto front.
pub const FRONT_WIDTH: f64 = 7.0;
/// How the line of the noise is dashed.
pub const DASHES: &str = "7 5";
/// Height between the axes.
const HEIGHT: f64 = 400.0;
/// Room for the title above and the ticks at the left and below.
const ABOVE: f64 = 44.0;
const LEFT: f64 = 72.0;
const BELOW: f64 = 30.0;
const TITLE: f64 = 17.0;
const TICK: f64 = 13.5;
const LABEL: f64 = 13.0;
/// More room between labels side by side than between lines of them.
const BETWEEN: f64 = 6.0;
/// The noise is on the axis unless it is further below the least error than this factor.
const NOISE_IN_SIGHT: f64 = 30.0;
/// Most ticks beside the axes.
const TICKS: [usize; 2] = [11, 9];

/// What a panel has across.
pub struct Axis {
    /// Title of the panel.
    pub title: &'static str,
    /// What is across, with its unit.
    pub subtitle: &'static str,
    /// The value of a point.
    pub value: fn(&Point) -> f64,
    /// The value as text.
    pub format: fn(f64) -> String,
}

/// A point that can be drawn.
struct Dot<'a> {
    point: &'a Point,
    style: Style,
    at: [f64; 2],
    on_front: bool,
    /// What is written beside it.
    text: String,
    label: Label,
    /// Its number if its label is short or nowhere.
    number: usize,
}

/// The line of a series, from point to point.
type Line = (Style, Vec<[f64; 2]>);

/// A panel, laid out.
pub struct Panel<'a> {
    axis: &'a Axis,
    frame: Rect,
    across: LogAxis,
    up: LogAxis,
    dots: Vec<Dot<'a>>,
    /// Corners of the front's stairs.
    front: Vec<[f64; 2]>,
    /// Lines that join the points of a series.
    series: Vec<Line>,
    /// Height and text of the line of the noise, and where the text is.
    noise: Option<(f64, String, Rect)>,
    /// Lines of text below.
    notes: Vec<String>,
}

/// Whether a logarithmic axis has a place for it.
fn on_axis(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn error(point: &Point) -> f64 {
    point.errors.relative_l2.median
}

/// The label of a point; with the series at the end of its line, if another series of the method has the same
/// label.
fn shown(point: &Point, all: &[Point]) -> String {
    let of_method = || all.iter().filter(|p| p.method == point.method);
    let is_shared = of_method().any(|p| p.series != point.series && p.label == point.label);
    let ends = of_method().rfind(|p| p.series == point.series).is_some_and(|last| last.label == point.label);
    if is_shared && ends { format!("{}, {}", point.label, point.series) } else { point.label.clone() }
}

fn segments(lines: &[[f64; 2]]) -> impl Iterator<Item = Segment> + '_ {
    lines.windows(2).filter_map(|pair| Some([*pair.first()?, *pair.get(1)?]))
}

impl<'a> Panel<'a> {
    /// The panel of `chart` for `axis`, between `left` and `right` from `top` down.
    pub fn new(chart: &'a Chart, axis: &'a Axis, methods: &[&str], [left, top, right]: [f64; 3]) -> Self {
        let frame = Rect { low: [left + LEFT, top + ABOVE], high: [right, top + ABOVE + HEIGHT] };
        let (drawn, left_out): (Vec<&Point>, Vec<&Point>) =
            chart.points.iter().partition(|p| on_axis((axis.value)(p)) && on_axis(error(p)));
        let across = LogAxis::new(drawn.iter().map(|p| (axis.value)(p)), [frame.low[0], frame.high[0]]);
        let least = drawn.iter().map(|p| error(p)).fold(f64::INFINITY, f64::min);
        let noise = Some(chart.noise.relative_l2.median)
            .filter(|noise| on_axis(*noise) && noise * NOISE_IN_SIGHT >= least);
        let up = LogAxis::new(drawn.iter().map(|p| error(p)).chain(noise), [frame.high[1], frame.low[1]]);
        let costs: Vec<[f64; 2]> = drawn.iter().map(|p| [(axis.value)(p), error(p)]).collect();
        let on_front = front(&costs);
        let style = |p: &Point| Style::of(methods.iter().position(|m| *m == p.method).unwrap_or(0));
        let dot = |(number, point): (usize, &&'a Point)| Dot {
            point,
            style: style(point),
            at: [across.place((axis.value)(point)), up.place(error(point))],
            on_front: on_front.contains(&number),
            text: shown(point, &chart.points),
            label: Label::Nowhere,
            number: 0,
        };
        let dots: Vec<Dot<'a>> = drawn.iter().enumerate().map(dot).collect();
        let front = stairs(&on_front.iter().map(|number| dots[*number].at).collect::<Vec<_>>(), &frame);
        let noise_line = noise.map(|noise| noise_line(noise, up.place(noise), &frame, &dots));
        let series = series(&dots);
        let mut panel =
            Self { axis, frame, across, up, dots, front, series, noise: noise_line, notes: Vec::new() };
        panel.label();
        panel.note(&left_out, chart.noise.relative_l2.median, noise.is_some());
        panel
    }

    /// Where the next panel may start.
    pub fn bottom(&self) -> f64 {
        self.frame.high[1] + BELOW + LINE * self.notes.len() as f64 + 10.0
    }

    /// Finds places for the labels, and numbers those that have none.
    fn label(&mut self) {
        let lines = self.series.iter().flat_map(|(_, line)| segments(line)).chain(segments(&self.front));
        let noise = self.noise.iter().map(|(y, ..)| [[self.frame.low[0], *y], [self.frame.high[0], *y]]);
        let around = Surroundings {
            frame: self.frame,
            marks: self.dots.iter().map(|dot| dot.at).collect(),
            reach: MARK_REACH,
            taken: self.noise.iter().map(|(_, _, rect)| *rect).collect(),
            lines: lines.chain(noise).collect(),
        };
        let size = |text: &str| [width(text, LABEL) + BETWEEN, LABEL * (ASCENT + DESCENT)];
        let sizes: Vec<[f64; 2]> = self.dots.iter().map(|dot| size(&dot.text)).collect();
        let labels = place(&around, &sizes, size(&format!("{}", self.dots.len())));
        let mut number = 0;
        for (dot, label) in self.dots.iter_mut().zip(labels) {
            dot.label = label;
            if !matches!(label, Label::Whole(_)) {
                number += 1;
                dot.number = number;
            }
        }
    }

    /// Says below the panel what is not in it.
    fn note(&mut self, left_out: &[&Point], noise: f64, noise_drawn: bool) {
        let value = |p: &Point| {
            format!(
                "{} at {}, error {}",
                p.name(),
                (self.axis.format)((self.axis.value)(p)),
                percent(error(p))
            )
        };
        let numbered = |dot: &Dot<'_>| match dot.label {
            Label::Whole(_) => None,
            Label::Short(_) => Some(format!("{}: {}", dot.number, value(dot.point))),
            Label::Nowhere => Some(format!("without a label: {}", value(dot.point))),
        };
        let mut notes: Vec<String> = self.dots.iter().filter_map(numbered).collect();
        notes.extend(left_out.iter().map(|p| format!("not on the axes: {}", value(p))));
        if !noise_drawn {
            notes.push(format!("below the axis: the noise of the reference, {}", percent(noise)));
        }
        let text = notes.join("  ·  ");
        if !text.is_empty() {
            self.notes = wrapped(&text, LABEL, self.frame.high[0] - self.frame.low[0]);
        }
    }

    /// Draws it all, what is least first.
    pub fn draw(&self, pen: &mut Pen) {
        self.draw_axes(pen);
        pen.lines(
            &self.front,
            FRONT,
            FRONT_WIDTH,
            &[("stroke-linejoin", "round"), ("stroke-linecap", "round")],
        );
        if let Some((y, text, rect)) = &self.noise {
            pen.lines(
                &[[self.frame.low[0], *y], [self.frame.high[0], *y]],
                INK,
                1.5,
                &[("stroke-dasharray", DASHES)],
            );
            draw_text(pen, rect, text, INK);
        }
        self.series.iter().for_each(|(style, line)| pen.lines(line, &hex(style.colour), 1.5, &[]));
        for (dot, [from, to]) in self.dots.iter().filter_map(|dot| Some((dot, dot.label.placed()?.leader?))) {
            pen.lines(&[from, to], &hex(darker(dot.style.colour)), 0.8, &[]);
        }
        self.dots.iter().for_each(|dot| dot.draw(pen));
        for (number, line) in self.notes.iter().enumerate() {
            let y = self.frame.high[1] + BELOW + LINE * number as f64 + TEXT;
            pen.text([self.frame.low[0], y], LABEL, Align::Left, line, &[("fill", FAINT_INK)]);
        }
    }

    fn draw_axes(&self, pen: &mut Pen) {
        let Rect { low, high } = self.frame;
        let left = low[0] - LEFT;
        pen.text([left, low[1] - 14.0], TITLE, Align::Left, self.axis.title, &[("font-weight", "bold")]);
        let beside = left + 1.15 * width(self.axis.title, TITLE) + 14.0;
        let subtitle = format!(
            "across: {}; up: relative L2; both logarithmic; better is down and left",
            self.axis.subtitle
        );
        pen.text([beside, low[1] - 14.0], TEXT, Align::Left, &subtitle, &[("fill", FAINT_INK)]);
        for value in self.across.ticks(TICKS[0]) {
            let x = self.across.place(value);
            pen.lines(&[[x, low[1]], [x, high[1]]], GRID, 1.0, &[]);
            pen.text([x, high[1] + 20.0], TICK, Align::Middle, &(self.axis.format)(value), &[]);
        }
        for value in self.up.ticks(TICKS[1]) {
            let y = self.up.place(value);
            pen.lines(&[[low[0], y], [high[0], y]], GRID, 1.0, &[]);
            pen.text([low[0] - 8.0, y + 0.36 * TICK], TICK, Align::Right, &percent(value), &[]);
        }
        pen.rect(
            [low[0], low[1], high[0], high[1]],
            &[("fill", "none"), ("stroke", FAINT_INK), ("stroke-width", "1")],
        );
    }
}

impl Dot<'_> {
    fn draw(&self, pen: &mut Pen) {
        pen.mark(self.at, self.style, self.on_front);
        let number = self.number.to_string();
        match &self.label {
            Label::Whole(placed) => draw_text(pen, &placed.rect, &self.text, &hex(darker(self.style.colour))),
            Label::Short(placed) => draw_text(pen, &placed.rect, &number, &hex(darker(self.style.colour))),
            Label::Nowhere => {}
        }
    }
}

/// Text in its box, on a patch of card that lifts it off the lines below.
fn draw_text(pen: &mut Pen, rect: &Rect, text: &str, colour: &str) {
    let Rect { low, high } = *rect;
    pen.rect([low[0] - 1.0, low[1], high[0] + 1.0, high[1]], &[("fill", CARD), ("fill-opacity", "0.8")]);
    // In the middle, as a narrower font than the widest leaves room on both sides.
    pen.text(
        [0.5 * (low[0] + high[0]), low[1] + LABEL * ASCENT],
        LABEL,
        Align::Middle,
        text,
        &[("fill", colour)],
    );
}

/// The border of what the points of the front beat: from the top above the cheapest, down and to the right,
/// to the right end from the most exact.
fn stairs(front: &[[f64; 2]], frame: &Rect) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (front.first(), front.last()) else { return Vec::new() };
    let mut stairs = vec![[first[0], frame.low[1]], *first];
    for pair in segments(front) {
        stairs.extend([[pair[1][0], pair[0][1]], pair[1]]);
    }
    stairs.push([frame.high[0], last[1]]);
    stairs
}

/// The points of each series in the order of the chart.
fn series(dots: &[Dot<'_>]) -> Vec<Line> {
    let mut lines: BTreeMap<(&str, &str), Line> = BTreeMap::new();
    for dot in dots {
        let key = (dot.point.method.as_str(), dot.point.series.as_str());
        lines.entry(key).or_insert_with(|| (dot.style, Vec::new())).1.push(dot.at);
    }
    lines.into_values().filter(|(_, line)| line.len() > 1).collect()
}

/// The text of the noise's line: above or below the line, at the end where it covers fewer marks.
fn noise_line(noise: f64, y: f64, frame: &Rect, dots: &[Dot<'_>]) -> (f64, String, Rect) {
    let text = format!("noise of the reference, {}", percent(noise));
    let half = [0.5 * width(&text, LABEL), 0.5 * LABEL * (ASCENT + DESCENT)];
    let at = |x: f64, side: f64| Rect::around([x, y + side * (half[1] + 4.0)], half);
    let [left, right] = [frame.low[0] + half[0] + 8.0, frame.high[0] - half[0] - 8.0];
    // Along the whole line, from the left end on.
    let steps = 24;
    let places = (0..=steps).flat_map(|step| {
        [1.0, -1.0].map(|side| at(left + (right - left) * f64::from(step) / f64::from(steps), side))
    });
    let covered = |rect: &Rect| {
        dots.iter().filter(|dot| Rect::around(dot.at, [MARK_REACH + 2.0; 2]).overlaps(rect)).count()
    };
    let best = places.filter(|rect| frame.holds(rect)).min_by_key(covered).unwrap_or(at(left, 1.0));
    (y, text, best)
}
