//! Tables of BRDF spaces and of the materials in them, all in one buffer of wide words.

use super::blurs::{Blurs, write};
use super::dispatches::uniform;
use super::gpu_data::{Cone as ConeData, MAX_CONES, Mirror, Space, Spaces};
use crate::gpu::Gpu;
use crate::lit::Bound;
use relume_formats::basis::sh;
use relume_formats::bundle::Brdfs;
use relume_formats::evaluate::transfer_tensor::{Lobes, cone_points, harmonic_weights};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::Cone;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use relume_formats::kinds::scene::StoredMaterial;
use wgpu::{Buffer, TextureView};

/// A row of a table: numbers, or their bits.
type Word = [u32; 4];
/// As many as there are models.
pub(super) const SPACES: usize = 3;

/// The tables, and where what is in them.
pub(super) struct Tables {
    spaces: Vec<BrdfTensor>,
    materials: Vec<Material>,
    /// Where they are.
    known: Buffer,
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
    /// Cones, and what each reflects by angle, for what is drawn.
    mirror: Buffer,
    cones: TextureView,
    cones_size: [u32; 2],
}

fn numbers([a, b, c, d]: [f32; 4]) -> Word {
    [a.to_bits(), b.to_bits(), c.to_bits(), d.to_bits()]
}

fn single(value: f32) -> Word {
    numbers([value, 0.0, 0.0, 0.0])
}

impl Material {
    /// Of `spaces` it has the one of its model; its tables begin at `first`.
    fn new(gpu: &Gpu, material: &StoredMaterial, spaces: &[BrdfTensor], blurs: &Blurs, first: usize) -> Self {
        let space = spaces.iter().position(|space| space.meta.model == material.brdf.model());
        let (profiles, cones) = space
            .and_then(|space| spaces.get(space))
            .map_or((0, &[][..]), |space| (space.orders.len(), space.cones.as_slice()));
        let shares = first + NODES * profiles;
        let mut mirror: Mirror = bytemuck::Zeroable::zeroed();
        mirror.count = cones.len().min(MAX_CONES) as u32;
        for (place, cone) in mirror.cones.iter_mut().zip(cones) {
            *place = cone_data(cone, blurs);
        }
        let cones_size = [cones.len().max(1) as u32, NODES as u32];
        let dark = vec![[0.0_f32; 4]; cones.len().max(1) * NODES];
        let format = wgpu::TextureFormat::Rgba32Float;
        Self {
            name: material.name.clone(),
            space,
            weights: first,
            shares,
            end: shares + NODES * cones.len(),
            mirror: uniform(gpu, "mirror", &mirror),
            cones: gpu.texture("cones", cones_size, format, bytemuck::cast_slice(&dark)),
            cones_size,
        }
    }
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
            let placed = Material::new(gpu, material, &spaces, blurs, end);
            end = placed.end;
            placed
        };
        let materials: Vec<Material> = materials.iter().map(&mut place).collect();
        let mut words = vec![Word::default(); end];
        let directions = words.len() as u32;
        words.extend(sh::directions().map(|direction| numbers(direction.extend(0.0).to_array())));
        let mut of_spaces: [Space; SPACES] = bytemuck::Zeroable::zeroed();
        for (place, space) in of_spaces.iter_mut().zip(&spaces) {
            *place = add_space(&mut words, space, blurs);
        }
        let known = Spaces { spaces: of_spaces, directions };
        let known = uniform(gpu, "spaces", &known);
        Self { buffer: gpu.storage("tables", &words), spaces, materials, known }
    }

    /// What shaders take of them, by number of the binding.
    pub(super) fn bound(&self) -> [(u32, &Buffer); 2] {
        [(10, &self.known), (11, &self.buffer)]
    }

    /// By material what points are drawn with, by number of the binding.
    pub(super) fn of_materials(&self) -> Vec<Vec<(u32, Bound)>> {
        let bound = |material: &Material| {
            vec![(1, Bound::Buffer(material.mirror.clone())), (2, Bound::Texture(material.cones.clone()))]
        };
        self.materials.iter().map(bound).collect()
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
        for material in &self.materials {
            // A row of cones for each angle, as the tables have them.
            let shares = words.get(material.shares..material.end).unwrap_or_default();
            let shares: Vec<[f32; 4]> = shares.iter().map(|word| word.map(f32::from_bits)).collect();
            write(gpu, &material.cones, material.cones_size, &shares);
        }
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

/// Sine and cosine of a cone's tilt, sine and cosine of what it is turned to the side.
fn turned(cone: &Cone) -> [f32; 4] {
    let ((sin_tilt, cos_tilt), (sin_side, cos_side)) =
        (cone.tilt_deg.to_radians().sin_cos(), cone.side_deg.to_radians().sin_cos());
    [sin_tilt, cos_tilt, sin_side, cos_side]
}

/// A cone as points are drawn with it.
fn cone_data(cone: &Cone, blurs: &Blurs) -> ConeData {
    let [row, width, height] = blurs.place(cone.width_deg);
    ConeData { turned: turned(cone), map: [row, width, height, cone.count() as u32] }
}

/// A cone in the words that the shader makes one of.
fn of_cone(cone: &Cone, blurs: &Blurs) -> [Word; 5] {
    // About an axis: one that stands for itself, seven, or seven times seven.
    let points: Vec<_> = cone_points(glam::Vec3::Z, cone.width_deg).collect();
    let again = if points.len() > 7 { 7 } else { 1 };
    let ring = |number: usize| {
        let point = points.get(number).map_or(glam::Vec3::Z, |(point, _)| *point);
        [point.truncate().length(), point.z]
    };
    let ([sin, cos], [sin_again, cos_again]) = (ring(again), ring(if again > 1 { 1 } else { 0 }));
    let [row, width, height] =
        blurs.place(points.first().map_or(cone.width_deg, |(_, width_deg)| *width_deg));
    let variance = cone.width_deg.to_radians().powi(2);
    let shrunk = [0.0, 1.0, 2.0, 3.0].map(|band: f32| (-0.5 * band * (band + 1.0) * variance).exp());
    [
        numbers(turned(cone)),
        numbers([sin, cos, sin_again, cos_again]),
        [points.len() / again, again, cone.count(), 0].map(|count| count as u32),
        [row, width, height, 0],
        numbers(shrunk),
    ]
}
