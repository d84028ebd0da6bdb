//! What pixels show: fragments, in the sections that every kind has them in.

use crate::container::{Sections, Writer};
use crate::error::Result;
use half::f16;

/// How far above 1 the coverages of a pixel may be in all, for their rounding to halves.
const COVERAGE_TOLERANCE: f32 = 1e-3;

/// The fragments of a film: those of editable materials first, each group in order of (pixel, class).
#[derive(Debug, Clone, PartialEq)]
pub struct Fragments {
    /// y·width + x of each.
    pub pixel: Vec<u32>,
    /// Class of each: the editable material, or their number for everything fixed.
    pub class: Vec<u16>,
    /// Coverage of each, 0..=1.
    pub coverage: Vec<f16>,
}

impl Fragments {
    /// Reads those of a film of `size` pixels that shows so many editable `materials`, of which the first
    /// `editable` ones are.
    ///
    /// # Errors
    /// `Invalid` if they do not fit the film, or each other.
    pub fn decode(
        sections: &mut Sections<'_>,
        size: [u32; 2],
        materials: usize,
        editable: usize,
    ) -> Result<Self> {
        let section = sections.take("fragments/pixel")?;
        let pixel = section.u32s()?;
        let fragments = section.length()?;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        if editable as u64 > fragments || fragments > pixels * (materials as u64 + 1) {
            return Err(section.invalid(format!("{fragments} fragments do not fit the film")));
        }
        if pixel.iter().any(|p| u64::from(*p) >= pixels) {
            return Err(section.invalid("a fragment lies outside the film"));
        }

        let section = sections.take("fragments/class")?;
        let class = section.u16s()?;
        section.expect_shape(&[fragments])?;
        let (first, fixed) = class.split_at(editable);
        let ordered = |from: usize, classes: &[u16]| {
            (1..classes.len()).all(|i| (pixel[from + i - 1], classes[i - 1]) < (pixel[from + i], classes[i]))
        };
        if first.iter().any(|c| usize::from(*c) >= materials)
            || fixed.iter().any(|c| usize::from(*c) != materials)
            || !ordered(0, first)
            || !ordered(editable, fixed)
        {
            return Err(section.invalid("fragments are not in order, or of a class that is not there"));
        }

        let section = sections.take("fragments/coverage")?;
        let coverage = section.f16s()?;
        section.expect_shape(&[fragments])?;
        if !coverage.iter().all(|c| *c > f16::ZERO && *c <= f16::ONE) {
            return Err(section.invalid("a coverage is outside 0..1"));
        }
        section.expect(fault_of_coverage(&pixel, editable, &coverage))?;
        Ok(Self { pixel, class, coverage })
    }
}

/// Writes them.
pub(crate) fn encode(out: &mut Writer, (pixel, class, coverage): (&[u32], &[u16], &[f16])) -> Result<()> {
    let fragments = pixel.len() as u64;
    out.u32s("fragments/pixel", &[fragments], pixel)?;
    out.u16s("fragments/class", &[fragments], class)?;
    out.f16s("fragments/coverage", &[fragments], coverage)
}

/// No pixel is covered more than once. Fragments of editable materials, which come first, and fixed ones are
/// each in the order of pixels.
fn fault_of_coverage(pixel: &[u32], editable: usize, coverage: &[f16]) -> Option<String> {
    let mut groups = [(0, editable), (editable, pixel.len())];
    let next = |groups: &[(usize, usize); 2]| {
        groups.iter().filter(|(at, end)| at < end).filter_map(|(at, _)| pixel.get(*at)).min().copied()
    };
    while let Some(here) = next(&groups) {
        let mut sum = 0.0;
        for (at, end) in &mut groups {
            while at < end && pixel.get(*at) == Some(&here) {
                sum += coverage.get(*at).map_or(0.0, |c| c.to_f32());
                *at += 1;
            }
        }
        if sum > 1.0 + COVERAGE_TOLERANCE {
            return Some(format!("the fragments of pixel {here} cover {sum} of it, more than all"));
        }
    }
    None
}
