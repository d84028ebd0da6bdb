//! A bake at play: light, what vertices receive of it and show, the picture, and which of them has to be computed
//! again.

use super::bands;
use super::blurs::Blurs;
use super::clusters::Members;
use super::direct::Direct;
use super::once::{Once, largest_bytes};
use super::shown::{Shown, VISIBLE_WORDS};
use super::tables::Tables;
use super::twice::Twice;
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Light, Map, Picture, Surroundings};
use relume_formats::basis::hemisphere::TEXELS;
use relume_formats::basis::sh;
use relume_formats::bundle::Brdfs;
use relume_formats::evaluate::transfer_tensor::widths;
use relume_formats::kinds::transfer_tensor::{
    Block, FACE_SIZE, Meta, Once as StoredOnce, Twice as StoredTwice, weights,
};
use relume_formats::kinds::{BrdfBasis, BrdfTensor, Environment};
use relume_formats::state::Rgb;
use relume_formats::{Error as FormatError, Place};
use std::ops::Range;
use wgpu::{Buffer, BufferUsages};

/// Everything that comes before the main file.
pub(super) struct Waiting {
    pub(super) surroundings: Surroundings,
    /// One for every model that materials have.
    pub(super) spaces: Vec<BrdfTensor>,
    /// One for every model that varying materials have, where light is reflected more than once.
    pub(super) bases: Vec<BrdfBasis>,
}

/// Everything that it takes to draw a frame.
pub(super) struct Stage {
    meta: Meta,
    /// Names of materials, in the order of the scene.
    materials: Vec<String>,
    bases: Vec<BrdfBasis>,
    blurs: Blurs,
    light: Light,
    bands: Vec<Band>,
    direct: Direct,
    /// By band, as soon as there is reflected light.
    members: Vec<Members>,
    once: Option<Once>,
    twice: Option<Twice>,
    has_seen: bool,
    /// What materials make of sources, and of pairs of them.
    weights: Buffer,
    pair_weights: Buffer,
    tables: Tables,
    shown: Shown,
    pub(super) picture: Picture,
    gain: Rgb,
    /// What is set now.
    set: Option<([f32; 3], u64)>,
    changed: Changed,
}

/// Vertices, and what is known of them.
pub(super) struct Band {
    pub(super) vertices: Range<u32>,
    /// [columns, vertices] four floats: direct light before the gain.
    pub(super) direct: Buffer,
    /// [17, vertices] four floats: harmonics after one reflection, and irradiance over π after two.
    pub(super) arriving: Buffer,
    /// [columns, vertices] four floats: all of it in columns.
    pub(super) received: Buffer,
    /// [vertices, texels] bytes.
    pub(super) seen: Buffer,
}

/// What the next frame has to compute again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Changed {
    /// Map or rotation.
    pub(super) light: bool,
    /// What materials are, and so what is reflected.
    pub(super) materials: bool,
    /// Blocks of direct light.
    pub(super) blocks: bool,
    /// Reflected light.
    pub(super) reflected: bool,
    /// Where the eye is, or what vertices see.
    pub(super) eye: bool,
}

impl Band {
    fn new(gpu: &Gpu, meta: &Meta, vertices: Range<u32>) -> Self {
        let count = vertices.len() as u64;
        let wide = |label, rows: u64| {
            gpu.buffer(label, count * rows * size_of::<[f32; 4]>() as u64, BufferUsages::STORAGE)
        };
        let columns = u64::from(meta.columns);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Self {
            vertices,
            direct: wide("direct light", columns),
            arriving: wide("arriving light", sh::COUNT as u64 + 1),
            received: wide("received light", columns),
            seen: gpu.buffer("seen", count * TEXELS as u64, usage),
        }
    }
}

impl Stage {
    /// Of what was `waiting` for the main file that says `meta`.
    ///
    /// # Errors
    /// If there are more vertices or clusters than the GPU can bind.
    pub(super) fn new(gpu: &Gpu, waiting: Waiting, meta: Meta, place: &Place) -> Result<Self> {
        let Waiting { mut surroundings, spaces, bases } = waiting;
        let too_much = |bytes: u64| {
            let (name, most) = (&gpu.name, gpu.binding_bytes);
            let reason = format!("needs {bytes} bytes in one piece, GPU {name} binds at most {most}");
            FormatError::unsupported(
                place,
                format!("{reason}; use a coarser mesh, or bake fewer materials that vary"),
            )
        };
        let ranges = bands::cut(&meta, gpu.binding_bytes).map_err(too_much)?;
        let words = u64::from(meta.vertices) * VISIBLE_WORDS as u64;
        let whole = largest_bytes(&meta).max(words * size_of::<[f32; 4]>() as u64);
        if whole > gpu.binding_bytes {
            return Err(too_much(whole).into());
        }
        let blurs = Blurs::new(gpu, widths(&spaces), surroundings.take_environments());
        let light = surroundings.light(gpu, FACE_SIZE as u32, true);
        let materials = &surroundings.scene.meta.materials;
        let tables = Tables::new(gpu, materials, spaces, &blurs);
        let bands: Vec<Band> = ranges.iter().map(|range| Band::new(gpu, &meta, range.clone())).collect();
        let direct: Vec<Buffer> = bands.iter().map(|band| band.direct.clone()).collect();
        let shown = Shown::new(gpu, &surroundings.scene, &bands, &tables, &blurs);
        let surface = shown.surface(&tables, &blurs);
        let wide = |label, rows: usize| {
            let bytes = (rows * size_of::<[f32; 4]>()) as u64;
            gpu.buffer(label, bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST)
        };
        Ok(Self {
            materials: materials.iter().map(|material| material.name.clone()).collect(),
            direct: Direct::new(gpu, &meta, &ranges, light.coefficients(), &direct),
            weights: wide("weights", meta.sources.len()),
            pair_weights: wide("weights of pairs", meta.pairs().len()),
            picture: surroundings.picture(gpu, surface, &light),
            members: Vec::new(),
            once: None,
            twice: None,
            has_seen: false,
            gain: [1.0; 3],
            set: None,
            changed: Changed::default(),
            meta,
            bases,
            blurs,
            light,
            bands,
            tables,
            shown,
        })
    }

    /// Takes the next block.
    pub(super) fn block_arrived(&mut self, gpu: &Gpu, block: &Block) {
        self.direct.block_arrived(gpu, &self.meta, block);
        self.changed.blocks = true;
    }

    /// Takes what vertices see, [vertices, texels].
    pub(super) fn seen_arrived(&mut self, gpu: &Gpu, seen: &[u8]) {
        for band in &self.bands {
            let [first, end] =
                [band.vertices.start, band.vertices.end].map(|vertex| vertex as usize * TEXELS);
            gpu.write(&band.seen, 0, seen.get(first..end).unwrap_or_default());
        }
        self.has_seen = true;
        self.changed.eye = true;
    }

    /// Takes light that was reflected once.
    pub(super) fn once_arrived(&mut self, gpu: &Gpu, stored: &StoredOnce) {
        let members = |band: &Band| Members::new(gpu, &band.vertices, &stored.clusters);
        self.members = self.bands.iter().map(members).collect();
        let under = (self.light.coefficients(), &self.weights);
        self.once = Some(Once::new(gpu, &self.meta, stored, (&self.members, &self.arriving()), under));
        self.changed.reflected = true;
    }

    /// Takes light that was reflected twice.
    pub(super) fn twice_arrived(&mut self, gpu: &Gpu, stored: &StoredTwice) {
        let under = (self.light.coefficients(), &self.pair_weights);
        self.twice = Some(Twice::new(gpu, &self.meta, stored, (&self.members, &self.arriving()), under));
        self.changed.reflected = true;
    }

    fn arriving(&self) -> Vec<Buffer> {
        self.bands.iter().map(|band| band.arriving.clone()).collect()
    }

    /// Adds an environment map, or puts it in the place of the one that has its name.
    pub(super) fn add_map(&mut self, gpu: &Gpu, map: &Environment) {
        let index = self.light.add(gpu, Map::new(gpu, map));
        self.picture.set_map(gpu, index, &self.light);
        self.blurs.set(index, map);
    }

    /// Sets how things look.
    pub(super) fn update(&mut self, gpu: &Gpu, look: &Look) {
        if let Some(environment) = &look.environment {
            if self.light.set(gpu, environment) {
                self.picture.set_suns(gpu, &self.light);
                self.blurs.shine(gpu, self.light.map(), environment.rotation_deg);
                self.changed.light = true;
            }
            self.gain = environment.gain;
        }
        let (eye, revision) = (look.camera.position, look.materials.revision());
        let before = self.set.replace((eye, revision));
        if before.is_none_or(|(_, materials)| materials != revision) {
            self.set_materials(gpu, &look.materials);
        }
        if before.is_none_or(|(position, _)| position != eye) {
            self.shown.set_eye(gpu, eye);
            self.changed.eye = true;
        }
        self.picture.set(gpu, &look.camera, self.gain);
    }

    fn set_materials(&mut self, gpu: &Gpu, brdfs: &Brdfs) {
        let coefficients = |material: u32| {
            let brdf = brdfs.get(self.materials.get(material as usize)?)?;
            self.bases.iter().find(|basis| basis.functions.model() == brdf.model())?.coefficients_of(brdf)
        };
        let weights = weights(&self.meta.sources, coefficients);
        let of_pair = |[first, second]: [usize; 2]| {
            let product = |c: usize| Some(weights.get(first)?[c] * weights.get(second)?[c]);
            [0, 1, 2].map(|c| product(c).unwrap_or_default())
        };
        let pairs: Vec<Rgb> = self.meta.pairs().into_iter().map(of_pair).collect();
        for (buffer, values) in [(&self.weights, &weights), (&self.pair_weights, &pairs)] {
            let wide: Vec<[f32; 4]> = values.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect();
            gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&wide));
        }
        self.tables.set_materials(gpu, brdfs);
        self.picture.set_materials(gpu, brdfs);
        self.changed.materials = true;
    }

    /// Encodes a frame, and of what comes before the picture no more than has changed.
    pub(super) fn encode(&mut self, passes: &mut Passes<'_>) {
        let Changed { light, materials, blocks, reflected, eye } = std::mem::take(&mut self.changed);
        if light {
            self.light.encode(passes);
        }
        if light || blocks {
            self.direct.encode(passes);
        }
        if let Some(once) = &self.once {
            if light || reflected {
                once.encode_light(passes);
            }
            if light || reflected || materials {
                once.encode(passes);
            }
        }
        if let Some(twice) = self.twice.as_ref().filter(|_| light || reflected || materials) {
            twice.encode(passes);
        }
        let receives = light || blocks || reflected || (materials && self.once.is_some());
        if receives {
            self.shown.encode_received(passes);
        }
        if receives || materials || eye {
            self.shown.encode(passes);
        }
        self.picture.encode(self.light.map(), passes);
    }

    /// What the diffuse parts of vertices show, and the gain.
    pub(super) fn vertex_radiance(&self) -> (&Buffer, Rgb) {
        (&self.shown.radiance, self.gain)
    }

    /// What the file announces.
    pub(super) fn meta(&self) -> &Meta {
        &self.meta
    }

    /// Whether each of the pieces is there: blocks, the first with what vertices see, then light reflected once
    /// and twice.
    pub(super) fn arrived(&self) -> Vec<bool> {
        let blocks = (0..self.meta.blocks.len())
            .map(|number| number < self.direct.arrived() && (number > 0 || self.has_seen));
        let reflected = [self.once.is_some(), self.twice.is_some()];
        blocks.chain(reflected.into_iter().take(self.meta.reflections as usize - 1)).collect()
    }

    /// Bytes that a frame reads at most.
    pub(super) fn bytes_per_frame(&self) -> u64 {
        let seen: u64 = self.bands.iter().map(|band| band.seen.size()).sum();
        let reflected =
            self.once.as_ref().map_or(0, Once::bytes) + self.twice.as_ref().map_or(0, Twice::bytes);
        self.direct.bytes(&self.meta) + seen + reflected
    }

    /// The film.
    pub(super) fn film(&self) -> &Film {
        self.picture.film()
    }
}

#[cfg(test)]
impl Stage {
    pub(super) fn changed(&self) -> Changed {
        self.changed
    }

    pub(super) fn shown(&self) -> &Shown {
        &self.shown
    }
}
