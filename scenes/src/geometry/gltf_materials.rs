//! The materials of a glTF file: metallic-roughness parameters, the texture of the base colour, masks and
//! emission.

use super::GltfFile;
use crate::image_file::{TextureKey, Textures};
use crate::numbering::{listed, numbered};
use crate::scene::Material;
use gltf::material::AlphaMode;
use gltf::texture::{MagFilter, WrappingMode};
use relume_formats::basis::{Filter, Texture, Wrap};
use relume_formats::counts::{counted, one_or};
use relume_formats::name::{MAX_CHARS, shows};
use relume_formats::state::{Brdf, FIXED_ROUGHNESS_MIN, Ggx, Rgb};
use relume_formats::{Place, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A material of a file, and what a material of a scene cannot say.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GltfMaterial {
    /// Its roughness may be below the least that is modelled.
    pub material: Material,
    /// Emitted radiance, W/(sr·m²); black if it only reflects.
    pub emission: Rgb,
    /// What multiplies the emission.
    pub glow: Option<Arc<Texture>>,
    /// True if its mask leaves nothing of it.
    pub invisible: bool,
}

/// The name of a material: its own, or its number.
fn name_of(material: &gltf::Material<'_>) -> String {
    let given = material.name().map(tidy_name).filter(|name| !name.is_empty());
    let number = || material.index().map_or_else(|| DEFAULT.to_owned(), |index| format!("material-{index}"));
    given.unwrap_or_else(number)
}

/// The material of primitives that name none.
const DEFAULT: &str = "material-default";

/// A name for every material of a file, the default one last; those that repeat are numbered.
pub(super) fn material_names(document: &gltf::Document) -> Vec<String> {
    numbered(
        document.materials().map(|material| name_of(&material)).chain(std::iter::once(DEFAULT.to_owned())),
    )
    .0
}

/// A name that fits on one line.
pub(crate) fn tidy_name(name: &str) -> String {
    let tidy: String = name.trim().chars().take(MAX_CHARS).map(|c| if shows(c) { c } else { ' ' }).collect();
    tidy.trim().to_owned()
}

/// Reads the materials of a file, and counts what it ignores.
pub(crate) struct MaterialReader<'a> {
    file: &'a GltfFile,
    textures: &'a mut Textures,
    /// How many materials have what is ignored.
    ignored: BTreeMap<&'static str, usize>,
    materials: usize,
    /// Names that are not those of the file, as others have them.
    renamed: Vec<String>,
}

impl<'a> MaterialReader<'a> {
    /// For the materials of `file`.
    pub fn new(file: &'a GltfFile, textures: &'a mut Textures) -> Self {
        Self { file, textures, ignored: BTreeMap::new(), materials: 0, renamed: Vec::new() }
    }

    /// Adds what was ignored to `warnings`, one line for each kind.
    pub fn finish(self, warnings: &mut Vec<String>) {
        let (place, of) = (Place::file(&self.file.path), counted(self.materials, "material", "materials"));
        if !self.renamed.is_empty() {
            warnings.push(format!("{place}: names of materials repeat; numbered {}", listed(&self.renamed)));
        }
        warnings.extend(self.ignored.iter().map(|(what, count)| {
            format!("{place}: {count} of {of} {} {what}", one_or(*count, "has", "have"))
        }));
    }

    fn ignore(&mut self, what: &'static str, present: bool) {
        if present {
            *self.ignored.entry(what).or_default() += 1;
        }
    }

    /// The material called `name`, which is `source`.
    pub fn read(&mut self, name: &str, source: &gltf::Material<'_>) -> Result<GltfMaterial> {
        self.materials += 1;
        if name_of(source) != name {
            self.renamed.push(name.to_owned());
        }
        self.ignore("a normal texture, which is ignored", source.normal_texture().is_some());
        self.ignore("an occlusion texture, which is ignored", source.occlusion_texture().is_some());
        self.ignore(
            "KHR_materials_unlit, which is lit here like any other: the light is what is played",
            source.unlit(),
        );
        let pbr = source.pbr_metallic_roughness();
        let [r, g, b, alpha] = pbr.base_color_factor();
        let (mut metallic, mut roughness) = (pbr.metallic_factor(), pbr.roughness_factor());
        if let Some(info) = pbr.metallic_roughness_texture()
            && let Some(texture) = self.texture(&info.texture())?
        {
            self.ignore("a metallic-roughness texture, whose mean is taken", true);
            let [_, green, blue] = mean(&texture);
            (metallic, roughness) = (metallic * blue, roughness * green);
        }
        let ggx = Ggx { base_color: [r, g, b], metallic, roughness };
        let place = Place::file(&self.file.path);
        // Roughness below the least is raised later, when it is known whether the material varies.
        Brdf::Ggx(Ggx { roughness: roughness.max(FIXED_ROUGHNESS_MIN), ..ggx }).validate(name, &place)?;
        let texture =
            pbr.base_color_texture().map(|info| self.texture(&info.texture())).transpose()?.flatten();
        let (alpha_cutoff, invisible) = self.mask(source, alpha, texture.is_some());
        let (emission, glow) = self.emission(source)?;
        let material =
            Material { name: name.to_owned(), brdf: Brdf::Ggx(ggx), texture, paint: None, alpha_cutoff };
        Ok(GltfMaterial { material, emission, glow, invisible })
    }

    /// The cut-off on the texture's alpha, and whether nothing is left of the surface. Surfaces are where
    /// factor · alpha ≥ cutoff.
    fn mask(&mut self, source: &gltf::Material<'_>, factor: f32, textured: bool) -> (Option<f32>, bool) {
        self.ignore("alpha mode BLEND, which is shown opaque", source.alpha_mode() == AlphaMode::Blend);
        let cutoff = source.alpha_cutoff().unwrap_or(0.5);
        if source.alpha_mode() != AlphaMode::Mask || cutoff <= 0.0 {
            return (None, false);
        }
        let cutoff_of_texture = cutoff / factor.max(0.0);
        if cutoff_of_texture > 1.0 { (None, true) } else { (textured.then_some(cutoff_of_texture), false) }
    }

    /// Emitted radiance, and what multiplies it; black if nothing shines.
    fn emission(&mut self, source: &gltf::Material<'_>) -> Result<(Rgb, Option<Arc<Texture>>)> {
        let strength = source.emissive_strength().unwrap_or(1.0);
        let factor = source.emissive_factor().map(|x| x * strength);
        let Some(info) = source.emissive_texture().filter(|_| factor != [0.0; 3]) else {
            return Ok((factor, None));
        };
        let glow = self.texture(&info.texture())?;
        let shines =
            |texture: &Arc<Texture>| texture.texels.iter().any(|[r, g, b, _]| [*r, *g, *b] != [0; 3]);
        Ok(if glow.as_ref().is_none_or(shines) { (factor, glow) } else { ([0.0; 3], None) })
    }

    /// None if its picture is of a kind that only an extension names.
    fn texture(&mut self, source: &gltf::Texture<'_>) -> Result<Option<Arc<Texture>>> {
        let json = self.file.document.as_json();
        // Not the crate's own way, which takes a missing picture for a bug.
        let index = json
            .textures
            .get(source.index())
            .map(|texture| texture.source.value())
            .filter(|index| *index < json.images.len());
        let Some(index) = index else {
            self.ignore("a texture whose picture is of a kind that is not read, which is ignored", true);
            return Ok(None);
        };
        let sampler = source.sampler();
        let filter =
            if sampler.mag_filter() == Some(MagFilter::Nearest) { Filter::Nearest } else { Filter::Linear };
        let wrap = [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())];
        let key = TextureKey { file: self.file.path.clone(), image: Some(index), wrap, filter };
        let place = Place::file(&self.file.path).part(format!("image {index}"));
        self.textures.get_or_decode(key, &place, || self.file.image_bytes(index, &place)).map(Some)
    }
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    }
}

/// The mean of a texture's red, green and blue as plain numbers.
fn mean(texture: &Texture) -> Rgb {
    let channel = |k: usize| texture.texels.iter().map(|texel| u64::from(texel[k])).sum::<u64>();
    std::array::from_fn(|k| (channel(k) as f64 / 255.0 / texture.texels.len() as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_short() {
        for (name, tidy) in [
            ("  a\u{1b}[2J\nb\t ", "a [2J b"),
            ("a\u{202E}b\u{200B}c\u{2028}d", "a b c d"),
            ("\u{FEFF}", ""),
            ("päper 纸/x", "päper 纸/x"),
        ] {
            assert_eq!(tidy_name(name), tidy);
        }
        assert_eq!(tidy_name(&"ä".repeat(200_000)), "ä".repeat(128));
    }
}
