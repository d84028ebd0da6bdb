//! Tables of BRDF spaces and of the materials in them, all in one buffer of wide words.

use super::blurs::{self, Blurs};
use super::dispatches::uniform;
use super::gpu_data::{Space, Spaces};
use crate::gpu::Gpu;
use relume_formats::basis::sh;
use relume_formats::bundle::Brdfs;
use relume_formats::evaluate::transfer_tensor::{Lobes, cone_points, harmonic_weights};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::Cone;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use relume_formats::kinds::scene::StoredMaterial;
use wgpu::Buffer;

/// A row of a table: numbers, or their bits.
type Word = [u32; 4];
/// As many as there are models.
pub(super) const SPACES: usize = 3;

/// The tables, and where what is in them.
pub(super) struct Tables {
    spaces: Vec<BrdfTensor>,
    materials: Vec<Material>,
    /// Where they are, and how the light is turned.
    known: Spaces,
    known_buffer: Buffer,
    /// All words.
    buffer: Buffer,
}

/// A material, and where its tables are.
struct Material {
    name: String,
    /// Index of its space, if it has one.
    space: Option<usize>,
    weights: usize,
    shares: usize,
    end: usize,
}

fn numbers([a, b, c, d]: [f32; 4]) -> Word {
    [a.to_bits(), b.to_bits(), c.to_bits(), d.to_bits()]
}

fn single(value: f32) -> Word {
    numbers([value, 0.0, 0.0, 0.0])
}

impl Tables {
    /// Those of `materials` in `spaces`, at most [`SPACES`]; filtered maps are where `blurs` says.
    pub(super) fn new(
        gpu: &Gpu,
        materials: &[StoredMaterial],
        spaces: Vec<BrdfTensor>,
        blurs: &Blurs,
    ) -> Self {
        let mut end = materials.len();
        let mut place = |material: &StoredMaterial| {
            let model = material.brdf.model();
            let space = spaces.iter().position(|space| space.meta.model == model);
            let [profiles, cones] = space
                .and_then(|space| spaces.get(space))
                .map_or([0; 2], |space| [space.orders.len(), space.cones.len()]);
            let (weights, shares) = (end, end + NODES * profiles);
            end = shares + NODES * cones;
            Material { name: material.name.clone(), space, weights, shares, end }
        };
        let materials: Vec<Material> = materials.iter().map(&mut place).collect();
        let mut words = vec![Word::default(); end];
        let directions = words.len() as u32;
        words.extend(sh::directions().map(|direction| numbers(direction.extend(0.0).to_array())));
        let mut of_spaces: [Space; SPACES] = bytemuck::Zeroable::zeroed();
        for (place, space) in of_spaces.iter_mut().zip(&spaces) {
            *place = add_space(&mut words, space, blurs);
        }
        let known = Spaces { sin_rotation: 0.0, cos_rotation: 1.0, directions, unused: 0, spaces: of_spaces };
        let known_buffer = uniform(gpu, "spaces", &known);
        Self { buffer: gpu.storage("tables", &words), spaces, materials, known, known_buffer }
    }

    /// What shaders take of them, by number of the binding.
    pub(super) fn bound(&self) -> [(u32, &Buffer); 2] {
        [(10, &self.known_buffer), (11, &self.buffer)]
    }

    /// Sets how far the light is turned.
    pub(super) fn set_rotation(&mut self, gpu: &Gpu, rotation_deg: f32) {
        (self.known.sin_rotation, self.known.cos_rotation) = rotation_deg.to_radians().sin_cos();
        gpu.queue.write_buffer(&self.known_buffer, 0, bytemuck::bytes_of(&self.known));
    }

    /// Writes what is of materials.
    pub(super) fn set_materials(&self, gpu: &Gpu, brdfs: &Brdfs) {
        let mut words: Vec<Word> = Vec::new();
        let lobes = |material: &Material| {
            let space = self.spaces.get(material.space?)?;
            Lobes::new(space, brdfs.get(&material.name)?)
        };
        let lobes: Vec<Option<Lobes>> = self.materials.iter().map(lobes).collect();
        for (material, lobes) in self.materials.iter().zip(&lobes) {
            let space = material.space.filter(|_| lobes.is_some()).unwrap_or(SPACES);
            words.push([space, material.weights, material.shares, 0].map(|place| place as u32));
        }
        for (material, lobes) in self.materials.iter().zip(&lobes) {
            if let Some(Lobes { profiles, cones }) = lobes {
                words.extend(coloured(profiles));
                words.extend(coloured(cones));
            }
            words.resize(material.end, Word::default());
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&words));
    }
}

/// The rows of a table that there is for each channel.
fn coloured([red, green, blue]: &[Vec<f32>; 3]) -> impl Iterator<Item = Word> {
    red.iter().zip(green).zip(blue).map(|((r, g), b)| numbers([*r, *g, *b, 0.0]))
}

/// Appends the tables of a space, as the shaders' `Space` says.
fn add_space(words: &mut Vec<Word>, space: &BrdfTensor, blurs: &Blurs) -> Space {
    let mut add = |rows: &mut dyn Iterator<Item = Word>| {
        let first = words.len() as u32;
        words.extend(rows);
        first
    };
    Space {
        columns: space.columns() as u32,
        profiles: space.orders.len() as u32,
        cones: space.cones.len() as u32,
        harmonics: add(&mut harmonic_weights(space).into_iter().map(single)),
        orders: add(&mut space.orders.iter().map(|order| [*order, 0, 0, 0])),
        even: add(&mut space.even.iter().map(|share| numbers([*share; 4]))),
        first_cone: add(&mut space.cones.iter().flat_map(|cone| of_cone(cone, blurs))),
        unused: 0,
    }
}

/// A cone in the words that the shader makes one of.
fn of_cone(cone: &Cone, blurs: &Blurs) -> [Word; 4] {
    let ((sin_tilt, cos_tilt), (sin_side, cos_side)) =
        (cone.tilt_deg.to_radians().sin_cos(), cone.side_deg.to_radians().sin_cos());
    let nowhere = blurs::Place { first: 0, width: 1, height: 1 };
    let blurs::Place { first, width, height } = blurs.place(cone.width_deg).unwrap_or(nowhere);
    // About an axis, the sine and cosine of the angle that the others are away from the middle.
    let points: Vec<_> = cone_points(glam::Vec3::Z, cone.width_deg).collect();
    let aside = points.last().copied().unwrap_or(glam::Vec3::Z);
    let variance = cone.width_deg.to_radians().powi(2);
    let shrunk = [0.0, 1.0, 2.0, 3.0].map(|band: f32| (-0.5 * band * (band + 1.0) * variance).exp());
    let ring = [aside.truncate().length().to_bits(), aside.z.to_bits(), points.len() as u32, 0];
    [
        numbers([sin_tilt, cos_tilt, sin_side, cos_side]),
        [first, width, height, cone.count() as u32],
        ring,
        numbers(shrunk),
    ]
}
