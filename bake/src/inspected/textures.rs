//! Texture coordinates and textures.

use super::out::Out;
use super::words::{grouped, list};
use super::{Described, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::Textures;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::Textures, describe, export };

#[derive(Serialize)]
struct Details {
    uvs: usize,
    /// Texels of each, width and height.
    sizes: Vec<[u32; 2]>,
}

fn describe(path: &Path) -> Result<Described> {
    let textures = Textures::read_file(path)?;
    let details = Details {
        uvs: textures.uvs.len(),
        sizes: textures.textures.iter().map(|t| t.texture.size).collect(),
    };
    let sizes = details.sizes.iter().map(|[width, height]| format!("{width} × {height}"));
    let facts = vec![("vertices", grouped(details.uvs as u64)), ("textures", list(sizes))];
    Ok(Described { facts, details: Box::new(details) })
}

/// `uvs.npy` [vertices, 2], `texture_<n>.npy` [height, width, 4], `textures.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let textures = Textures::read_file(path)?;
    out.npy("uvs.npy", &[textures.uvs.len(), 2], textures.uvs.as_flattened().iter().copied())?;
    let mut list = Vec::new();
    for (index, stored) in textures.textures.iter().enumerate() {
        let file = format!("texture_{index}.npy");
        let [width, height] = stored.texture.size.map(|n| n as usize);
        out.npy(&file, &[height, width, 4], stored.texture.texels.as_flattened().iter().copied())?;
        list.push(json!({ "file": file, "material": stored.material, "alpha_cutoff": stored.alpha_cutoff, "wrap": stored.texture.wrap }));
    }
    out.json("textures.json", &list)
}
