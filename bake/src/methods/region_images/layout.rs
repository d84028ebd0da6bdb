//! What the sums of a fragment are of: light without a reflection before, and what each source sends on, by basis of
//! the eye.

use super::settings::Settings;
use super::weights::Weights;
use crate::filter::Layer;
use crate::fragments::Channels;
use crate::methods::transfer_images::{chromaticity, grey_channel};
use relume_formats::kinds::region_images::Source;
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use std::ops::Range;

/// Channels of a fragment that stand together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Basis of the eye.
    pub eye: usize,
    /// Where light was reflected before; `None` of direct light.
    pub source: Option<Source>,
    /// Which of the groups of [`Weights`] it is, of a painted source.
    pub group: Option<usize>,
    /// Rows: one, or the rank of the group.
    pub rows: usize,
    /// Channels of each: three, or one if its light has one colour.
    pub colours: usize,
    /// The first channel.
    pub start: usize,
}

impl Block {
    fn range(&self) -> Range<usize> {
        self.start..self.start + self.rows * self.colours
    }
}

/// All channels of fragments.
pub struct Layout {
    /// Of fragments of materials that vary.
    pub editable: Vec<Block>,
    /// Of fixed ones.
    pub fixed: Vec<Block>,
    /// By class, whether it is painted.
    pub painted: Vec<bool>,
    /// Bases of direct light, and of light that was reflected before.
    pub bases: [usize; 2],
    /// The one colour of all light.
    pub chromaticity: Option<Rgb>,
    /// The channel in which it is brightest.
    pub grey: usize,
}

impl Layout {
    /// Of a bake of `scene` whose regions weigh `weights`.
    pub fn new(scene: &Scene, settings: &Settings, weights: &Weights) -> Self {
        let chromaticity = chromaticity(scene);
        let vary = &scene.vary;
        let painted: Vec<bool> = vary.materials.iter().map(|m| vary.painted.contains(m)).collect();
        let textured: Vec<bool> = vary
            .materials
            .iter()
            .map(|m| !vary.painted.contains(m) && scene.materials[*m].texture.is_some())
            .collect();
        let [bases, indirect] = [settings.bases, settings.indirect_bases(scene.reflections)];
        let sources: Vec<Source> = sources(&painted, indirect);
        // A texture of the scene colours the diffuse basis of materials that are edited as wholes.
        let eye_is_grey = |eye: usize| eye > 0 || !textured.contains(&true);
        let is_grey = |source: Source| match source {
            Source::Fixed => false,
            Source::Whole { material, basis } => basis > 0 || !textured[usize::from(material)],
            Source::Painted { .. } => true,
        };
        let colours = |eye: usize, source: Option<Source>| match source {
            _ if chromaticity.is_none() => 3,
            None if eye == 0 => 3,
            Some(source) if !(eye_is_grey(eye) && is_grey(source)) => 3,
            _ => 1,
        };
        let make = |eyes: [usize; 2], is_fixed: bool| {
            let mut start = 0;
            let direct = (0..eyes[0]).map(|eye| (eye, None));
            let before = (0..eyes[1]).flat_map(|eye| sources.iter().map(move |source| (eye, Some(*source))));
            let block = |(eye, source): (usize, Option<Source>)| {
                let group = source.and_then(|source| weights.group(eye, source));
                let rows = group.map_or(1, |group| weights.groups[group].rank());
                let colours = if is_fixed { 3 } else { colours(eye, source) };
                let block = Block { eye, source, group, rows, colours, start };
                start += rows * colours;
                block
            };
            direct.chain(before).map(block).collect::<Vec<Block>>()
        };
        Self {
            editable: make([bases, indirect], false),
            fixed: make([1, indirect.min(1)], true),
            painted,
            bases: [bases, indirect],
            chromaticity,
            grey: grey_channel(chromaticity),
        }
    }

    /// Number of materials that vary.
    pub fn materials(&self) -> usize {
        self.painted.len()
    }

    /// The blocks of light of a class.
    pub fn blocks(&self, is_fixed: bool) -> &[Block] {
        if is_fixed { &self.fixed } else { &self.editable }
    }

    /// What of the channels of fragments that vary, and of fixed ones, is filtered how.
    pub fn channels(&self) -> [Channels; 2] {
        [&self.editable, &self.fixed].map(|blocks| {
            let mut channels = Channels::default();
            for block in blocks {
                let layer = if block.source.is_none() { Layer::Direct } else { Layer::Indirect };
                let ranges = &mut channels.layers[layer as usize];
                match ranges.last_mut() {
                    Some(last) if last.end == block.start => last.end = block.range().end,
                    _ => ranges.push(block.range()),
                }
                channels.count = block.range().end;
            }
            channels
        })
    }
}

/// All places where light may be reflected before, with what it wears there.
pub fn sources(painted: &[bool], bases: usize) -> Vec<Source> {
    let of = |(material, painted): (usize, &bool)| {
        let (material, painted) = (material as u16, *painted);
        (0..bases as u16).map(move |basis| match painted {
            true => Source::Painted { material, basis },
            false => Source::Whole { material, basis },
        })
    };
    let editable = painted.iter().enumerate().flat_map(of);
    std::iter::once(Source::Fixed).chain(editable).collect()
}
