//! Small environments, textures and sparse rows, made from a seed.

use super::samples::Random;
use half::f16;
use relume_formats::basis::{EquirectMap, Filter, Texture, Wrap};
use relume_formats::kinds::sparse_transfer::{Block, BlockShape, Meta, Steps};
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::kinds::{Environment, SparseTransfer, Textures};

/// Values that halves hold exactly; `bright` ones need a unit above 1.
pub fn environment(seed: u64, bright: bool) -> Environment {
    let random = &mut Random(seed);
    let [width, height] = [1 + random.below(9), 1 + random.below(5)];
    let unit = if bright { 4.0 } else { 1.0 };
    let mut value = || f16::from_f32(random.unit() * 1000.0).to_f32() * unit;
    let mut texels: Vec<[f32; 3]> = (0..width * height).map(|_| [value(), value(), value()]).collect();
    // The largest half times a unit makes that unit necessary.
    texels[0][0] = f16::MAX.to_f32() * unit;
    Environment {
        name: "päper sky.exr".to_owned(),
        map: EquirectMap { width: width as u32, height: height as u32, texels },
    }
}

pub fn textures(seed: u64) -> Textures {
    let random = &mut Random(seed);
    let count = random.below(4) as u32;
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let texture = |random: &mut Random| {
        let size = [1 + random.below(7) as u32, 1 + random.below(7) as u32];
        let texels = (0..size[0] * size[1]).map(|_| (random.bits() as u32).to_le_bytes()).collect();
        let filter = [Filter::Linear, Filter::Nearest][random.below(2)];
        Texture { size, wrap: [wraps[random.below(3)], wraps[random.below(3)]], filter, texels }
    };
    let material = |material| MaterialTexture {
        material,
        alpha_cutoff: (random.below(2) == 0).then_some(0.5),
        texture: texture(random),
    };
    let textures = (0..count).map(material).collect();
    Textures {
        uvs: (0..random.below(20)).map(|_| [random.signed() * 3.0, random.unit()]).collect(),
        textures,
    }
}

pub fn rows(seed: u64, vertices: usize, face_size: u32, rgb: bool, blocks: &[(u32, bool)]) -> SparseTransfer {
    let random = &mut Random(seed);
    let blocks: Vec<_> =
        blocks.iter().map(|(terms, wide)| BlockShape { terms: *terms, wide: *wide }).collect();
    let meta = Meta {
        vertices: vertices as u32,
        face_size,
        bounces: u32::from(rgb),
        rgb,
        unit: 1.0 / 2048.0,
        blocks,
        rays_per_texel: 4,
    };
    let block = |shape: &BlockShape| {
        let values = shape.terms as usize * vertices * meta.channels();
        let indices =
            (0..shape.terms as usize * vertices).map(|_| random.below(meta.coefficients()) as u16).collect();
        let scales = (0..vertices).map(|_| f16::from_f32(random.unit())).collect();
        let steps = match shape.wide {
            true => Steps::Wide((0..values).map(|_| random.bits() as i16).collect()),
            false => Steps::Bytes((0..values).map(|_| random.bits() as i8).collect()),
        };
        Block { indices, scales, steps }
    };
    let blocks = meta.blocks.iter().map(block).collect();
    SparseTransfer { meta, blocks }
}
