//! The images of light that was reflected before: what each is of, and what it is in a fragment.

use super::layout::{Block, Layout};
use super::weights::Weights;
use relume_formats::kinds::region_images::{Row, Source};
use relume_formats::state::Rgb;

/// One image, of a basis of the eye.
#[derive(Debug, Clone, Copy)]
pub struct RowOf {
    /// Whose light it is.
    pub source: Source,
    /// Which group of the weights and which of its components, of a painted source.
    pub component: Option<(usize, usize)>,
    /// What part of the colour.
    part: Part,
    /// Where it is in the records of fragments that vary, and of fixed ones: the first channel, and their number.
    channels: [Option<(usize, usize)>; 2],
    /// Mean square over states of what a unit of it shows of a channel.
    pub square: f64,
}

/// What part of the colour of light an image holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// The light, by its brightest channel.
    Grey,
    /// What a channel has beyond its share of that.
    Rest(usize),
}

/// The images of every basis of the eye.
pub fn rows_of(layout: &Layout, weights: &Weights) -> Vec<Vec<RowOf>> {
    let rests = (0..3).filter(|channel| *channel != layout.grey).map(Part::Rest);
    let parts: Vec<Part> = std::iter::once(Part::Grey).chain(rests).collect();
    (0..layout.bases[1])
        .map(|eye| {
            let of_eye = |blocks: &[Block]| {
                blocks
                    .iter()
                    .copied()
                    .filter(move |block| block.eye == eye && block.source.is_some())
                    .collect::<Vec<_>>()
            };
            let (editable, fixed) = (of_eye(&layout.editable), of_eye(&layout.fixed));
            let mut rows = Vec::new();
            for (number, block) in editable.iter().enumerate() {
                let of_fixed = fixed.get(number);
                let Some(source) = block.source else { continue };
                let is_grey = block.colours == 1 && of_fixed.is_none();
                for component in 0..block.rows {
                    for part in &parts[..if is_grey { 1 } else { 3 }] {
                        let channels =
                            |block: &Block| (block.start + component * block.colours, block.colours);
                        rows.push(RowOf {
                            source,
                            component: block.group.map(|group| (group, component)),
                            part: *part,
                            channels: [Some(channels(block)), of_fixed.map(channels)],
                            square: square(source, eye, weights),
                        });
                    }
                }
            }
            rows
        })
        .collect()
}

/// See [`RowOf::square`]. Factors of painted sources have a mean square of 1.
fn square(source: Source, eye: usize, weights: &Weights) -> f64 {
    let of_source = match source {
        Source::Fixed | Source::Painted { .. } => 1.0,
        Source::Whole { basis, .. } => weights.squares[usize::from(basis)],
    };
    of_source * weights.squares[eye]
}

impl RowOf {
    /// What it is in the record of a fragment, of a class that is fixed or not.
    pub fn value(&self, layout: &Layout, is_fixed: bool, record: &[f32]) -> f32 {
        let Some((start, colours)) = self.channels[usize::from(is_fixed)] else { return 0.0 };
        match (self.part, &record[start..start + colours]) {
            (Part::Grey, [grey]) => *grey,
            (Part::Rest(_), [_]) => 0.0,
            (Part::Grey, colour) => colour[layout.grey],
            (Part::Rest(channel), colour) => {
                colour[channel] - layout.chromaticity.unwrap_or([1.0; 3])[channel] * colour[layout.grey]
            }
        }
    }

    /// The colour of its light.
    pub fn colour(&self, layout: &Layout) -> Rgb {
        match self.part {
            Part::Grey => layout.chromaticity.unwrap_or([1.0; 3]),
            Part::Rest(channel) => std::array::from_fn(|k| if k == channel { 1.0 } else { 0.0 }),
        }
    }

    /// As files have it.
    pub fn stored(&self, layout: &Layout, step: f32) -> Row {
        Row { source: self.source, colour: self.colour(layout), step }
    }
}
