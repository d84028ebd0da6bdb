//! The materials of a glTF file: metallic-roughness parameters, the texture of the base colour, masks and emission.

use super::GltfFile;
use crate::image_file::{TextureKey, Textures};
use crate::scene::Material;
use gltf::material::AlphaMode;
use gltf::texture::WrappingMode;
use relume_formats::basis::{Texture, Wrap, linear_from_srgb};
use relume_formats::state::{Brdf, FIXED_ROUGHNESS_MIN, Ggx, Rgb};
use relume_formats::{Place, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Extensions whose content is used; all others are named in a warning.
const USED_EXTENSIONS: [&str; 3] = ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_texture_transform"];

/// A material of a file, and what a material of a scene cannot say.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GltfMaterial {
    /// Its roughness may be below the least that is modelled.
    pub material: Material,
    /// Emitted radiance, W/(sr·m²); black if it only reflects.
    pub emission: Rgb,
    /// True if its mask leaves nothing of it.
    pub invisible: bool,
}

/// The name of a material: its own, or its number.
pub(super) fn name_of(material: &gltf::Material<'_>) -> String {
    let given = material.name().map(tidy_name).filter(|name| !name.is_empty());
    let number = || material.index().map_or_else(|| "material-default".to_owned(), |index| format!("material-{index}"));
    given.unwrap_or_else(number)
}

/// A name that fits on one line.
pub(crate) fn tidy_name(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().trim().to_owned()
}

/// The materials called `names`, each with its name, in file order. Adds what is ignored to `warnings`, one line for each kind.
pub(crate) fn read_materials(
    file: &GltfFile,
    names: &[String],
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Vec<(String, GltfMaterial)>> {
    let mut reader = Reader { file, textures, ignored: BTreeMap::new() };
    let default = || file.document.meshes().flat_map(|mesh| mesh.primitives()).map(|p| p.material()).find(|m| m.index().is_none());
    let all = file.document.materials().chain(names.iter().any(|name| name == "material-default").then(default).flatten());
    let wanted = all.map(|m| (name_of(&m), m)).filter(|(name, _)| names.contains(name));
    let materials: Vec<_> = wanted.map(|(name, m)| Ok((name.clone(), reader.material(&name, &m)?))).collect::<Result<_>>()?;
    let (place, of) = (Place::file(&file.path), materials.len());
    warnings.extend(reader.ignored.iter().map(|(what, count)| format!("{place}: {count} of {of} materials have {what}")));
    let strange: Vec<String> = file.document.extensions_used().filter(|name| !USED_EXTENSIONS.contains(name)).map(tidy_name).collect();
    if !strange.is_empty() {
        warnings.push(format!("{place}: the file uses {}, which is ignored", strange.join(", ")));
    }
    Ok(materials)
}

struct Reader<'a> {
    file: &'a GltfFile,
    textures: &'a mut Textures,
    /// How many materials have what is ignored.
    ignored: BTreeMap<&'static str, usize>,
}

impl Reader<'_> {
    fn ignore(&mut self, what: &'static str, present: bool) {
        if present {
            *self.ignored.entry(what).or_default() += 1;
        }
    }

    fn material(&mut self, name: &str, source: &gltf::Material<'_>) -> Result<GltfMaterial> {
        self.ignore("a normal texture, which is ignored", source.normal_texture().is_some());
        self.ignore("an occlusion texture, which is ignored", source.occlusion_texture().is_some());
        let pbr = source.pbr_metallic_roughness();
        let [r, g, b, alpha] = pbr.base_color_factor();
        let (mut metallic, mut roughness) = (pbr.metallic_factor(), pbr.roughness_factor());
        if let Some(info) = pbr.metallic_roughness_texture() {
            self.ignore("a metallic-roughness texture, whose mean is taken", true);
            let [_, green, blue] = mean(&*self.texture(&info.texture())?, |byte| f32::from(byte) / 255.0);
            (metallic, roughness) = (metallic * blue, roughness * green);
        }
        let ggx = Ggx { base_color: [r, g, b], metallic, roughness };
        let place = Place::file(&self.file.path);
        // Roughness below the least is raised later, when it is known whether the material varies.
        Brdf::Ggx(Ggx { roughness: roughness.max(FIXED_ROUGHNESS_MIN), ..ggx }).validate(name, &place)?;
        let texture = pbr.base_color_texture().map(|info| self.texture(&info.texture())).transpose()?;
        let (alpha_cutoff, invisible) = self.mask(source, alpha, texture.is_some());
        let emission = self.emission(source)?;
        Ok(GltfMaterial { material: Material { name: name.to_owned(), brdf: Brdf::Ggx(ggx), texture, alpha_cutoff }, emission, invisible })
    }

    /// The cut-off on the texture's alpha, and whether nothing is left of the surface. Surfaces are where factor · alpha ≥ cutoff.
    fn mask(&mut self, source: &gltf::Material<'_>, factor: f32, textured: bool) -> (Option<f32>, bool) {
        self.ignore("alpha mode BLEND, which is shown opaque", source.alpha_mode() == AlphaMode::Blend);
        let cutoff = source.alpha_cutoff().unwrap_or(0.5);
        if source.alpha_mode() != AlphaMode::Mask || cutoff <= 0.0 {
            return (None, false);
        }
        let cutoff_of_texture = cutoff / factor.max(0.0);
        if cutoff_of_texture > 1.0 { (None, true) } else { (textured.then_some(cutoff_of_texture), false) }
    }

    fn emission(&mut self, source: &gltf::Material<'_>) -> Result<Rgb> {
        let strength = source.emissive_strength().unwrap_or(1.0);
        let factor = source.emissive_factor().map(|x| x * strength);
        match source.emissive_texture() {
            Some(info) if factor != [0.0; 3] => {
                self.ignore("an emissive texture, whose mean is taken", true);
                let colour = mean(&*self.texture(&info.texture())?, linear_from_srgb);
                Ok(std::array::from_fn(|k| factor[k] * colour[k]))
            }
            _ => Ok(factor),
        }
    }

    fn texture(&mut self, source: &gltf::Texture<'_>) -> Result<Arc<Texture>> {
        let sampler = source.sampler();
        // Not the crate's `source().source()`, see `image_bytes`.
        let index = source.source().index();
        let key = TextureKey { file: self.file.path.clone(), image: Some(index), wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())] };
        let place = Place::file(&self.file.path).part(format!("image {index}"));
        self.textures.get_or_decode(key, &place, || self.file.image_bytes(index, &place))
    }
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    }
}

/// The mean of a texture's red, green and blue, each as `decode` takes it.
fn mean(texture: &Texture, decode: impl Fn(u8) -> f32) -> Rgb {
    let channel = |k: usize| texture.texels.iter().map(|texel| f64::from(decode(texel[k]))).sum::<f64>();
    std::array::from_fn(|k| (channel(k) / texture.texels.len() as f64) as f32)
}
