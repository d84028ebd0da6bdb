//! Small bases of all models, transfer images, and random numbers for all samples.

use half::f16;
use relume_formats::basis::lobe_table;
use relume_formats::basis::microfacet::Facets;
use relume_formats::kinds::brdf_basis::{BasisError, Functions, MAX_SAMPLES, Meta as BasisMeta};
use relume_formats::kinds::transfer_images::{Head, Image, LARGEST_HALF, Later, Meta as ImagesMeta, Slot};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{BlinnPhong, CookTorrance, Ggx, ROUGHNESS_MIN, SLOPE_MIN};
use std::sync::Arc;

/// SplitMix64 (Steele et al. 2014): tests must not change with the version of a crate.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In 0..1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// In -1..1.
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Any half of an image: all exponents up to the largest, subnormals, and all signs if it may be
    /// `signed`.
    fn half(&mut self, signed: bool) -> f16 {
        let value = f16::from_bits(self.bits() as u16);
        let value = if value.to_f32().abs() <= LARGEST_HALF { value } else { f16::ONE };
        if signed { value } else { f16::from_bits(value.to_bits() & 0x7fff) }
    }

    pub fn blinn_phong(&mut self) -> BlinnPhong {
        let kd = [self.unit(), self.unit(), self.unit()];
        let share = self.unit();
        BlinnPhong { kd, ks: kd.map(|v| (1.0 - v) * share), shininess: 1.0 + 199.0 * self.unit() }
    }

    /// Within the range of materials that vary.
    pub fn ggx(&mut self) -> Ggx {
        let base_color = [self.unit(), self.unit(), self.unit()];
        Ggx {
            base_color,
            metallic: self.unit(),
            roughness: ROUGHNESS_MIN + (1.0 - ROUGHNESS_MIN) * self.unit(),
        }
    }

    /// Within the range of materials that vary.
    pub fn cook_torrance(&mut self) -> CookTorrance {
        let BlinnPhong { kd, ks, .. } = self.blinn_phong();
        let roughness = SLOPE_MIN + (1.0 - SLOPE_MIN) * self.unit();
        CookTorrance { kd, ks, fresnel: self.unit(), roughness }
    }
}

fn basis_meta(random: &mut Random) -> BasisMeta {
    let mut error = || {
        let (a, b) = (f64::from(random.unit()), f64::from(random.unit()));
        BasisError { mean: a.min(b), worst: a.max(b), worst_at: 3.5 }
    };
    BasisMeta { shared_diffuse: true, error_at_samples: error(), error_between: error() }
}

/// States how far the lobes are off, which are those of no model.
fn honest(mut basis: BrdfBasis) -> BrdfBasis {
    if matches!(&basis.functions, Functions::Microfacet { roughness, .. } if roughness.len() > MAX_SAMPLES) {
        return basis;
    }
    basis.meta.error_between.worst = basis.largest_error();
    basis.meta.error_between.mean = 0.5 * basis.meta.error_between.worst;
    basis
}

/// Of the Blinn-Phong space; `smooth` lobes compress to a few hundred bytes, others do not.
pub fn basis(seed: u64, bases: usize, smooth: bool) -> BrdfBasis {
    let random = &mut Random(seed);
    let nodes = 2 + random.below(6);
    let lobe =
        |random: &mut Random, i: usize| if smooth { (i / 1024) as f32 * 0.25 } else { random.signed() };
    honest(BrdfBasis {
        meta: basis_meta(random),
        parameters: (0..nodes).map(|i| 1.0 + 199.0 * i as f32 / (nodes - 1) as f32).collect(),
        coefficients: (0..nodes * bases).map(|_| random.signed()).collect(),
        functions: Functions::BlinnPhong {
            lobes: (0..(bases - 1) * lobe_table::NODES).map(|i| lobe(random, i)).collect(),
        },
    })
}

/// Of the GGX space.
pub fn ggx_basis(seed: u64, bases: usize, samples: usize) -> BrdfBasis {
    microfacet_basis(Facets::Ggx, ROUGHNESS_MIN, seed, bases, samples)
}

/// Of Cook and Torrance's space.
pub fn cook_torrance_basis(seed: u64, bases: usize, samples: usize) -> BrdfBasis {
    microfacet_basis(Facets::CookTorrance, SLOPE_MIN, seed, bases, samples)
}

fn microfacet_basis(facets: Facets, least: f32, seed: u64, bases: usize, samples: usize) -> BrdfBasis {
    let random = &mut Random(seed);
    let nodes = 2 + random.below(6);
    honest(BrdfBasis {
        meta: basis_meta(random),
        parameters: (0..nodes).map(|i| least + (1.0 - least) * i as f32 / (nodes - 1) as f32).collect(),
        coefficients: (0..nodes * 2 * bases).map(|_| random.signed()).collect(),
        functions: Functions::Microfacet {
            facets,
            roughness: (0..samples).map(|_| random.ggx().roughness).collect(),
            weights: (0..(bases - 1) * (1 + 2 * samples)).map(|_| random.signed()).collect(),
        },
    })
}

pub fn images(seed: u64, materials: usize, bases: usize, one_colour: bool, size: [u32; 2]) -> TransferImages {
    images_with(None, seed, materials, bases, one_colour, size)
}

/// With all reflections.
pub fn images_of_all(
    seed: u64,
    materials: usize,
    bases: usize,
    one_colour: bool,
    size: [u32; 2],
) -> TransferImages {
    let random = &mut Random(seed ^ 2);
    let share = |random: &mut Random| random.unit() / materials as f32;
    let eye_bases = 1 + random.below(bases) as u32;
    let lobes = random.below(bases) as u32;
    let later = Later {
        degree: 1 + random.below(2) as u32,
        eye_bases,
        lobes,
        lobe_eye_bases: if lobes > 0 { 1 + random.below(eye_bases as usize) as u32 } else { 0 },
        albedos: (0..bases).map(|_| random.signed()).collect(),
        textures: (0..materials).map(|_| [random.unit(), random.unit(), 1.0]).collect(),
        returns: (0..3 * materials * materials).map(|_| share(random)).collect(),
    };
    images_with(Some(later), seed, materials, bases, one_colour, size)
}

fn images_with(
    later: Option<Later>,
    seed: u64,
    materials: usize,
    bases: usize,
    one_colour: bool,
    size: [u32; 2],
) -> TransferImages {
    let random = &mut Random(seed);
    let fragments: Vec<(u32, u16)> = (0..size[0] * size[1])
        .flat_map(|pixel| (0..=materials as u16).map(move |class| (pixel, class)))
        .filter(|_| random.below(3) > 0)
        .collect();
    let (editable, fixed): (Vec<_>, Vec<_>) =
        fragments.into_iter().partition(|f| usize::from(f.1) < materials);
    let (pixel, class): (Vec<u32>, Vec<u16>) = editable.iter().chain(&fixed).copied().unzip();
    let meta = ImagesMeta {
        size,
        materials: (0..materials).map(|i| format!("m{i}")).collect(),
        bases: bases as u32,
        chromaticity: one_colour.then_some([1.0, 0.75, 0.3]),
        samples: 64,
        seed,
        editable_fragments: editable.len() as u32,
    };
    let coverage = pixel
        .iter()
        .map(|_| f16::from_f32((1 + random.below(64)) as f32 / (64 * (materials + 1)) as f32))
        .collect();
    let mut head = Head { meta, later, pixel, class, coverage, scales: Vec::new() };
    let layout = head.layout();
    let image = |slot: usize, s: &Slot, random: &mut Random| {
        let mut values: Vec<f16> =
            (0..s.channels() * head.fragments_of(s)).map(|_| random.half(!s.is_positive())).collect();
        // The range is made use of.
        if let Some(value) = values.last_mut() {
            *value = f16::from_f32(LARGEST_HALF * (0.5 + 0.5 * random.unit()));
        }
        Image { slot, values }
    };
    let mut images: Vec<_> =
        layout.slots.iter().enumerate().map(|(slot, s)| image(slot, s, random)).collect();
    let scale = |image: &Image, random: &mut Random| {
        if image.values.is_empty() { 0.0 } else { 0.5f32.powi(random.below(24) as i32) }
    };
    head.scales = images.iter().map(|image| scale(image, random)).collect();
    // Any order of importance is legal.
    images.sort_by_cached_key(|_| random.bits());
    TransferImages { head: Arc::new(head), images }
}
