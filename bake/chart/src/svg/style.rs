//! Colours and marks. The colours are those of Okabe and Ito (2008), which people with any kind of colour
//! blindness tell apart, less the yellow, which is too light for lines on white. Every method also has a mark
//! of its own shape.

/// A colour, red, green, blue.
pub type Colour = [u8; 3];

const COLOURS: [Colour; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0], [0, 0, 0]];
/// What everything stands on.
pub const CARD: &str = "#fcfcfa";
/// Text.
pub const INK: &str = "#222222";
/// Text and lines that matter less.
pub const FAINT_INK: &str = "#555555";
/// Lines of the grid.
pub const GRID: &str = "#e2e2de";
/// The Pareto front.
pub const FRONT: &str = "#c8c8c0";

/// Corners of the marks in units of their radius; none is a circle. All have about the same area.
const MARKS: [&[[f64; 2]]; 6] = [
    &[],
    &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
    &[[0.0, -1.25], [1.2, 0.85], [-1.2, 0.85]],
    &[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]],
    &[[0.0, 1.25], [-1.2, -0.85], [1.2, -0.85]],
    &[[0.0, -1.15], [1.1, -0.35], [0.7, 0.95], [-0.7, 0.95], [-1.1, -0.35]],
];
/// Radius of a mark.
pub const MARK_RADIUS: f64 = 6.0;
/// Half the side of the square that holds any mark with its outline; labels keep out of it.
pub const MARK_REACH: f64 = 1.25 * MARK_RADIUS + 1.0;

/// Size of text, but the title.
pub const TEXT: f64 = 14.0;
/// From one line of text to the next.
pub const LINE: f64 = 21.0;

/// How a method looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Of marks and lines.
    pub colour: Colour,
    /// Which of the marks.
    mark: usize,
}

impl Style {
    /// The look of the method that comes as number `index`; 42 are different.
    pub fn of(index: usize) -> Self {
        Self { colour: COLOURS[index % COLOURS.len()], mark: index % MARKS.len() }
    }

    /// Corners of the mark around `at`; `None` for a circle.
    pub fn corners(self, [x, y]: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        let corners = MARKS[self.mark];
        (!corners.is_empty())
            .then(|| corners.iter().map(|[dx, dy]| [x + MARK_RADIUS * dx, y + MARK_RADIUS * dy]).collect())
    }
}

/// As SVG writes it.
pub fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Dark enough for small text on the card.
pub fn darker(colour: Colour) -> Colour {
    colour.map(|c| (u16::from(c) * 3 / 5) as u8)
}
