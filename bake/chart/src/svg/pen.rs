//! Writes SVG elements, one after another, each on a line of its own. The same calls make the same bytes.

use super::style::{CARD, INK, MARK_RADIUS, Style, hex};
use super::text::FONTS;
use quick_xml::Writer;
use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};
use relume_formats::{Error, Place, Result};

/// A drawing under way.
pub struct Pen {
    writer: Writer<Vec<u8>>,
    /// The first thing that went wrong; told at the end.
    result: std::io::Result<()>,
}

/// Where text stands on its anchor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// The anchor is at its left.
    Left,
    /// The anchor is its middle.
    Middle,
    /// The anchor is at its right.
    Right,
}

/// One decimal is enough for pixels, and hides what other processors round otherwise.
fn number(value: f64) -> String {
    // No `-0.0`.
    format!("{:.1}", value + 0.0).replace("-0.0", "0.0")
}

fn points(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{},{}", number(*x), number(*y))).collect::<Vec<_>>().join(" ")
}

impl Pen {
    /// A card of the given size with nothing on it.
    pub fn new(width: f64, height: f64) -> Self {
        let mut pen = Self { writer: Writer::new_with_indent(Vec::new(), b' ', 1), result: Ok(()) };
        let view = format!("0 0 {} {}", number(width), number(height));
        let root = [
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("viewBox", &view),
            ("width", &number(width)),
            ("height", &number(height)),
        ];
        let root = BytesStart::new("svg")
            .with_attributes(root.into_iter().chain([("font-family", FONTS), ("fill", INK)]));
        pen.event(Event::Start(root));
        pen.rect([0.0, 0.0, width, height], &[("fill", CARD)]);
        pen
    }

    fn event(&mut self, event: Event<'_>) {
        if self.result.is_ok() {
            self.result = self.writer.write_event(event);
        }
    }

    fn empty(&mut self, name: &str, own: &[(&str, String)], more: &[(&str, &str)]) {
        let own = own.iter().map(|(name, value)| (*name, value.as_str()));
        self.event(Event::Empty(BytesStart::new(name).with_attributes(own.chain(more.iter().copied()))));
    }

    /// A rectangle between two corners: left, top, right, bottom.
    pub fn rect(&mut self, [x0, y0, x1, y1]: [f64; 4], more: &[(&str, &str)]) {
        let own =
            [("x", number(x0)), ("y", number(y0)), ("width", number(x1 - x0)), ("height", number(y1 - y0))];
        self.empty("rect", &own, more);
    }

    /// Connected lines.
    pub fn lines(&mut self, at: &[[f64; 2]], colour: &str, width: f64, more: &[(&str, &str)]) {
        let own = [
            ("points", points(at)),
            ("fill", "none".to_owned()),
            ("stroke", colour.to_owned()),
            ("stroke-width", number(width)),
        ];
        self.empty("polyline", &own, more);
    }

    /// A method's mark, filled or as an outline.
    pub fn mark(&mut self, at: [f64; 2], style: Style, filled: bool) {
        let colour = hex(style.colour);
        let look = [
            ("fill", if filled { colour.as_str() } else { CARD }),
            ("stroke", &colour),
            ("stroke-width", "2"),
        ];
        match style.corners(at) {
            Some(corners) => self.empty("polygon", &[("points", points(&corners))], &look),
            None => self.empty(
                "circle",
                &[("cx", number(at[0])), ("cy", number(at[1])), ("r", number(MARK_RADIUS))],
                &look,
            ),
        }
    }

    /// A line of text that stands on `at`.
    pub fn text(&mut self, at: [f64; 2], size: f64, align: Align, text: &str, more: &[(&str, &str)]) {
        let anchor = match align {
            Align::Left => "start",
            Align::Middle => "middle",
            Align::Right => "end",
        };
        let own = [("x", number(at[0])), ("y", number(at[1])), ("font-size", number(size))];
        let own = own.iter().map(|(name, value)| (*name, value.as_str())).chain([("text-anchor", anchor)]);
        self.event(Event::Start(BytesStart::new("text").with_attributes(own.chain(more.iter().copied()))));
        self.event(Event::Text(BytesText::new(text)));
        self.event(Event::End(BytesEnd::new("text")));
    }

    /// The whole file.
    ///
    /// # Errors
    /// If something could not be written, which does not happen in memory.
    pub fn finish(mut self) -> Result<String> {
        self.event(Event::End(BytesEnd::new("svg")));
        let failed = |e: std::io::Error| Error::output(&Place::file("chart.svg"), e);
        self.result.map_err(failed)?;
        let text =
            String::from_utf8(self.writer.into_inner()).map_err(|e| failed(std::io::Error::other(e)))?;
        Ok(text + "\n")
    }
}
