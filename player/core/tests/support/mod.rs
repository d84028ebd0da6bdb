//! A synthetic bundle: every number random, every case present that a real bake may hold.
#![allow(dead_code, reason = "each test binary uses its own part")]
#![allow(clippy::panic, reason = "a test fails by panicking")]

pub mod shadows;
pub mod sparse;
pub mod tensors;

use half::f16;
use relume_formats::Place;
use relume_formats::basis::lobe_table;
use relume_formats::basis::microfacet::Facets;
use relume_formats::bundle::Scope;
use relume_formats::container::Stored;
use relume_formats::display::Tonemap;
use relume_formats::kinds::brdf_basis::{Functions, model_of};
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry};
use relume_formats::kinds::scene::{self, StoredMaterial, StoredObject, StoredScene};
use relume_formats::kinds::transfer_images::{Head, Image, LARGEST_HALF, Meta, TransferImages};
use relume_formats::kinds::{BrdfBasis, brdf_basis};
use relume_formats::method::TRANSFER_IMAGES;
use relume_formats::state::{Animation, BlinnPhong, Brdf, Camera, CookTorrance, Ggx};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

pub const SIZE: [u32; 2] = [37, 23];
pub const PIXELS: usize = 37 * 23;
const BASES: usize = 4;
/// A pixel that no fragment covers.
pub const EMPTY_PIXEL: usize = 100;

pub const ANIMATION: &str = "duration_s = 0.5\nloop = true\n[[key]]\nt_s = 0\nmaterials.a.kd = [0.1, 0.2, 0.3]\n\
                             [[key]]\nt_s = 0.25\nmaterials.a.kd = [0.5, 0.2, 0.0]\n[[key]]\nt_s = 0.5\nmaterials.a.kd = [0.1, 0.2, 0.3]\n";

/// Ends, and drives the exposure.
pub const FADE: &str = "duration_s = 2.0\n[[key]]\nt_s = 0\ncamera.exposure_ev = 0.0\n[[key]]\nt_s = 2\ncamera.exposure_ev = -4.0\n";

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Mostly up to the largest half of an image, at times negative if it may be `signed`, tiny (a subnormal
    /// half) or zero.
    fn half(&mut self, signed: bool) -> f16 {
        let value = self.unit();
        f16::from_f32(match self.bits() % 8 {
            0 if signed => -value * LARGEST_HALF,
            1 => value * 1e-5,
            2 => 0.0,
            _ => value * LARGEST_HALF,
        })
    }
}

fn material(name: &str, varies: bool, level: f32) -> StoredMaterial {
    let brdf = Brdf::BlinnPhong(BlinnPhong {
        kd: [level, 0.5 * level, 0.2],
        ks: [0.3, 0.3, 0.2],
        shininess: 40.0 * level + 5.0,
    });
    let sharpest = brdf.model().usual_sharpest();
    StoredMaterial { name: name.to_owned(), brdf, varies, textured: false, sharpest }
}

/// Two editable materials, listed in another order than the images do, and a fixed one.
pub fn scene_meta() -> scene::Meta {
    scene::Meta {
        name: "synthetic".to_owned(),
        camera: Camera { position: [0.0, 1.0, 4.0], target: [0.0; 3], fov_deg: 40.0, exposure_ev: 0.5 },
        tonemap: Tonemap::Neutral,
        size: SIZE,
        varies_light: false,
        varies_view: false,
        varies_shape: false,
        environment: None,
        materials: vec![material("fixed", false, 0.5), material("b", true, 0.2), material("a", true, 0.4)],
        objects: vec![StoredObject { name: "thing".to_owned(), material: 0, triangles: 1 }],
        shapes: Vec::new(),
    }
}

/// What may be set of `scene` when images are played.
pub fn scope(scene: scene::Meta) -> Scope {
    Scope { scene, card: &TRANSFER_IMAGES, maps: Vec::new() }
}

pub fn scene() -> StoredScene {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    StoredScene {
        meta: scene_meta(),
        normals: vec![[0.0, 0.0, 1.0]; 3],
        positions,
        triangles: vec![[0, 1, 2]],
    }
}

/// States how far the lobes are off, which are those of no model.
pub fn honest(mut basis: BrdfBasis) -> BrdfBasis {
    basis.meta.error_between.worst = basis.largest_error();
    basis
}

pub fn basis() -> BrdfBasis {
    let mut random = Random(7);
    let error = brdf_basis::BasisError { mean: 0.0, worst: 0.0, worst_at: 1.0 };
    honest(BrdfBasis {
        meta: brdf_basis::Meta { shared_diffuse: true, error_at_samples: error, error_between: error },
        parameters: vec![1.0, 20.0, 200.0],
        coefficients: (0..3 * BASES).map(|_| 2.0 * random.unit() - 0.7).collect(),
        functions: Functions::BlinnPhong { lobes: vec![0.25; (BASES - 1) * lobe_table::NODES] },
    })
}

/// The materials of [`Bundle::write_cook_torrance`].
pub const COOK_TORRANCE: CookTorrance =
    CookTorrance { kd: [0.2, 0.3, 0.1], ks: [0.6, 0.5, 0.4], fresnel: 0.7, roughness: 0.35 };

/// A basis of a space of microfacets, of as many functions as [`basis`] has.
fn microfacet_basis(facets: Facets) -> BrdfBasis {
    let mut random = Random(8);
    let roughness = vec![0.4, 0.8];
    let weights = (0..(BASES - 1) * (1 + 2 * roughness.len())).map(|_| random.unit()).collect();
    honest(BrdfBasis {
        parameters: vec![model_of(facets).usual_sharpest(), 0.5, 1.0],
        coefficients: (0..3 * 2 * BASES).map(|_| 2.0 * random.unit() - 0.7).collect(),
        functions: Functions::Microfacet { facets, roughness, weights },
        ..basis()
    })
}

/// (pixel, class) of all fragments, editable ones first. Pixels have one fragment, several, or none at all.
fn fragments(random: &mut Random) -> (Vec<(u32, u16)>, usize) {
    let (mut editable, mut fixed) = (Vec::new(), Vec::new());
    for pixel in (0..PIXELS as u32).filter(|p| *p as usize != EMPTY_PIXEL) {
        let classes: &[u16] = match random.bits() % 6 {
            0 => &[0],
            1 => &[1],
            2 => &[0, 1],
            3 => &[0, 1, 2],
            4 => &[1, 2],
            _ => &[2],
        };
        for class in classes {
            if *class == 2 { fixed.push((pixel, *class)) } else { editable.push((pixel, *class)) }
        }
    }
    // Odd counts make the padding of planes matter.
    if editable.len() % 2 == 0 {
        editable.pop();
    }
    if (editable.len() + fixed.len()) % 2 == 0 {
        fixed.pop();
    }
    let count = editable.len();
    editable.extend(fixed);
    (editable, count)
}

/// Each fragment covers as much of its pixel as the others there.
fn coverage(fragments: &[(u32, u16)]) -> Vec<f16> {
    let mut counts = [0u32; PIXELS];
    fragments.iter().for_each(|(pixel, _)| counts[*pixel as usize] += 1);
    fragments.iter().map(|(pixel, _)| f16::from_f32(1.0 / counts[*pixel as usize] as f32)).collect()
}

/// Random images for the materials a and b.
pub fn images(one_colour: bool) -> TransferImages {
    let mut random = Random(if one_colour { 1 } else { 2 });
    let (fragments, editable) = fragments(&mut random);
    let meta = Meta {
        size: SIZE,
        materials: vec!["a".to_owned(), "b".to_owned()],
        bases: BASES as u32,
        chromaticity: one_colour.then_some([1.0, 0.7, 0.4]),
        samples: 16,
        seed: 1,
        editable_fragments: editable as u32,
    };
    let mut head = Head {
        meta,
        later: None,
        pixel: fragments.iter().map(|f| f.0).collect(),
        class: fragments.iter().map(|f| f.1).collect(),
        coverage: coverage(&fragments),
        scales: Vec::new(),
    };
    let layout = head.layout();
    head.scales = layout.slots.iter().map(|_| 0.5f32.powi(14 + (random.bits() % 3) as i32)).collect();
    // The order of importance is not that of the slots.
    let mut order: Vec<usize> = (0..layout.slots.len()).collect();
    order.sort_by_key(|slot| slot * 7 % 31);
    let image = |slot: usize| {
        let count = layout.slots[slot].channels() * head.fragments_of(&layout.slots[slot]);
        Image { slot, values: (0..count).map(|_| random.half(!layout.slots[slot].is_positive())).collect() }
    };
    let images = order.into_iter().map(image).collect();
    TransferImages { head: Arc::new(head), images }
}

/// A bundle on disk, removed with this value.
pub struct Bundle {
    folder: tempfile::TempDir,
    pub images: TransferImages,
    pub basis: BrdfBasis,
    pub manifest: Manifest,
}

impl Bundle {
    /// Writes a bundle with an animation `glow`; `one_colour` decides between the two layouts of slots.
    pub fn write(one_colour: bool) -> Self {
        Self::of(&scene(), images(one_colour), basis())
    }

    /// A bundle whose material a, textured, and b are GGX, and which has no animation.
    pub fn write_ggx() -> Self {
        let mut scene = scene();
        for material in &mut scene.meta.materials {
            let metallic = if material.name == "a" { 0.0 } else { 0.7 };
            material.brdf = Brdf::Ggx(Ggx { base_color: [0.8, 0.5, 0.2], metallic, roughness: 0.45 });
            material.textured = material.name == "a";
            material.sharpest = material.brdf.model().usual_sharpest();
        }
        Self::still(&scene, microfacet_basis(Facets::Ggx))
    }

    /// A bundle whose materials a, textured, and b are Cook and Torrance's, and which has no animation.
    pub fn write_cook_torrance() -> Self {
        let mut scene = scene();
        for material in &mut scene.meta.materials {
            material.brdf = Brdf::CookTorrance(COOK_TORRANCE);
            material.textured = material.name == "a";
            material.sharpest = material.brdf.model().usual_sharpest();
        }
        Self::still(&scene, microfacet_basis(Facets::CookTorrance))
    }

    fn still(scene: &StoredScene, basis: BrdfBasis) -> Self {
        let mut bundle = Self::of(scene, images(false), basis);
        bundle.manifest.animations.clear();
        bundle.manifest.write(bundle.folder()).unwrap();
        bundle
    }

    pub fn of(scene: &StoredScene, images: TransferImages, basis: BrdfBasis) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let entry = |name: &str, bytes: Vec<u8>| FileEntry::of(name, &bytes);
        let at = |name: &str| folder.path().join(name);
        let animation = Animation::parse("glow", ANIMATION, &Place::file("glow")).unwrap();
        let manifest = Manifest {
            version: 0,
            scene: "synthetic".to_owned(),
            scene_hash: "0".repeat(32),
            scene_file: entry("scene.relume", scene.write_file(&at("scene.relume")).unwrap()),
            animations: BTreeMap::from([(
                "glow".to_owned(),
                entry("glow.relume", animation.write_file(&at("glow.relume")).unwrap()),
            )]),
            sphere_sets: BTreeMap::new(),
            methods: vec![MethodEntry {
                reads: "0".repeat(32),
                name: "transfer-images".to_owned(),
                files: vec![
                    (
                        "brdf-basis".to_owned(),
                        entry("basis.relume", basis.write_file(&at("basis.relume")).unwrap()),
                    ),
                    (
                        "transfer-images".to_owned(),
                        entry("images.relume", images.write_file(&at("images.relume")).unwrap()),
                    ),
                ],
                settings: BTreeMap::new(),
                errors: BTreeMap::new(),
                measured_on: String::new(),
            }],
        };
        manifest.write(folder.path()).unwrap();
        Self { folder, images, basis, manifest }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Puts the files of `other` in the place of this bundle's, as a bake does: the manifest is away meanwhile.
    pub fn bake_again(&self, other: &Self) {
        let manifest = self.folder().join(manifest::FILE_NAME);
        std::fs::remove_file(&manifest).unwrap();
        for entry in other.manifest.entries() {
            let new = self.folder().join(format!("new-{}", entry.file));
            std::fs::copy(other.folder().join(&entry.file), &new).unwrap();
            std::fs::rename(new, self.folder().join(&entry.file)).unwrap();
        }
        other.manifest.write(self.folder()).unwrap();
    }

    /// The scene as the bundle has it.
    pub fn scene_meta(&self) -> scene::Meta {
        StoredScene::read_file(&self.folder().join("scene.relume")).unwrap().meta
    }

    /// Bytes of all files together, the animation included.
    pub fn playlist_bytes(&self) -> u64 {
        self.manifest.entries().map(|entry| entry.bytes).sum()
    }

    /// The CPU's answer for the given materials a and b, from the images that `keep` lets through.
    pub fn evaluate(&self, materials: &[Brdf; 2], keep: impl Fn(usize) -> bool) -> Vec<[f32; 3]> {
        let images = self.images.images.iter().filter(|image| keep(image.slot)).cloned().collect();
        let kept = TransferImages { head: self.images.head.clone(), images };
        relume_formats::evaluate::transfer_images::evaluate(
            &kept,
            &materials.map(|brdf| self.basis.coefficients_of(&brdf).unwrap()),
        )
    }
}

/// Default parameters of the materials a and b.
pub fn default_materials() -> [Brdf; 2] {
    let meta = scene_meta();
    ["a", "b"].map(|name| meta.materials.iter().find(|m| m.name == name).unwrap().brdf)
}

/// The parameters of a Blinn-Phong material.
pub fn blinn_phong(brdf: Brdf) -> BlinnPhong {
    let Brdf::BlinnPhong(parameters) = brdf else { panic!("{brdf:?} is not Blinn-Phong") };
    parameters
}

/// Largest difference between two images, relative to the largest value of the second.
pub fn largest_difference(ours: &[[f32; 3]], theirs: &[[f32; 3]]) -> f32 {
    assert_eq!(ours.len(), theirs.len());
    let largest = theirs.iter().flatten().fold(0.0_f32, |m, v| m.max(v.abs()));
    let difference =
        ours.iter().flatten().zip(theirs.iter().flatten()).fold(0.0_f32, |m, (a, b)| m.max((a - b).abs()));
    assert!(largest > 0.0 && ours.iter().flatten().all(|v| v.is_finite()));
    difference / largest
}

/// Whether tests may use a GPU. Without one they are skipped aloud, or fail if `RELUME_REQUIRE_GPU` is 1.
pub fn gpu_there(list: impl FnOnce() -> Result<(), String>) -> bool {
    match list() {
        Ok(()) => true,
        Err(reason) => {
            assert!(
                std::env::var("RELUME_REQUIRE_GPU").as_deref() != Ok("1"),
                "RELUME_REQUIRE_GPU=1, but: {reason}"
            );
            eprintln!("skipped: {reason}");
            false
        }
    }
}
