//! Kind `textures`, version 0: what methods that draw meshes need of a textured scene besides kind `scene`.
//!
//! | section        | type | shape              | content |
//! |----------------|------|--------------------|---------|
//! | `meta`         | u8   | record             | one [`TextureMeta`] per texture |
//! | `uvs`          | f32  | [vertices, 2]      | texture coordinates of the scene's vertices; (0, 0) where a mesh has none |
//! | `texture/NNNN` | u8   | [height, width, 4] | sRGB-encoded red, green, blue, and linear alpha, the first row at v = 0 |

use crate::basis::{Filter, Texture, Wrap};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::Result;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Most textures of one scene.
pub const MAX_TEXTURES: usize = 16;
/// Largest side of a texture: its bytes fit a section with room to spare.
pub const MAX_SIDE: u32 = 4096;

/// Texture coordinates and textures of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Textures {
    /// One pair per vertex of the scene.
    pub uvs: Vec<[f32; 2]>,
    /// At most [`MAX_TEXTURES`].
    pub textures: Vec<MaterialTexture>,
}

/// The texture of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialTexture {
    /// Index into the scene's materials.
    pub material: u32,
    /// Where alpha is below this, there is no surface.
    pub alpha_cutoff: Option<f32>,
    /// What multiplies the material's diffuse albedo.
    pub texture: Texture,
}

/// Everything of a texture but its texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct TextureMeta {
    material: u32,
    alpha_cutoff: Option<f32>,
    wrap: [Wrap; 2],
    filter: Filter,
}

fn texture_name(index: usize) -> String {
    format!("texture/{index:04}")
}

impl TextureMeta {
    fn decode(self, section: &Section) -> Result<MaterialTexture> {
        let side = |n: u64| u32::try_from(n).ok().filter(|n| (1..=MAX_SIDE).contains(n));
        let size = match section.info.shape[..] {
            [height, width, 4] => side(width).zip(side(height)),
            _ => None,
        };
        let (width, height) = size.ok_or_else(|| {
            section.invalid(format!(
                "has shape {:?}, expected [height, width, 4] of at most {MAX_SIDE} a side",
                section.info.shape
            ))
        })?;
        if self.alpha_cutoff.is_some_and(|cutoff| !(cutoff > 0.0 && cutoff <= 1.0)) {
            return Err(section.invalid("its alpha cutoff is outside 0..1"));
        }
        let texels = section.u8s()?.as_chunks().0.to_vec();
        let texture = Texture { size: [width, height], wrap: self.wrap, filter: self.filter, texels };
        Ok(MaterialTexture { material: self.material, alpha_cutoff: self.alpha_cutoff, texture })
    }
}

impl Stored for Textures {
    const KIND: Kind = Kind::Textures;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let meta = |t: &MaterialTexture| TextureMeta {
            material: t.material,
            alpha_cutoff: t.alpha_cutoff,
            wrap: t.texture.wrap,
            filter: t.texture.filter,
        };
        out.record("meta", &self.textures.iter().map(meta).collect::<Vec<_>>())?;
        out.f32s("uvs", &[self.uvs.len() as u64, 2], self.uvs.as_flattened())?;
        for (index, MaterialTexture { texture, .. }) in self.textures.iter().enumerate() {
            let [width, height] = texture.size.map(u64::from);
            out.u8s(&texture_name(index), &[height, width, 4], texture.texels.as_flattened())?;
        }
        Ok(())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Vec<TextureMeta> = section.record()?;
        if meta.len() > MAX_TEXTURES {
            return Err(
                section.invalid(format!("{} textures, at most {MAX_TEXTURES} are allowed", meta.len()))
            );
        }
        if meta.iter().map(|m| m.material).collect::<BTreeSet<_>>().len() != meta.len() {
            return Err(section.invalid("two textures are of one material"));
        }
        let section = sections.take("uvs")?;
        let uvs: Vec<[f32; 2]> = section.f32_rows()?;
        section.expect_finite(uvs.as_flattened())?;
        let texture =
            |(index, meta): (usize, TextureMeta)| meta.decode(&sections.take(&texture_name(index))?);
        Ok(Self { uvs, textures: meta.into_iter().enumerate().map(texture).collect::<Result<_>>()? })
    }
}
