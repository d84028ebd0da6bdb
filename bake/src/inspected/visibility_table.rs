//! The shadows of one sphere.

use super::out::Out;
use super::words::grouped;
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::basis::cubemap;
use relume_formats::basis::two_level::{BYTES, SIDE};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::VisibilityTable;
use relume_formats::kinds::visibility_table::{
    DIRECTIONS, RADII, STORED_DIRECTIONS, radius_of, stored_directions,
};
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::VisibilityTable, describe, export };

#[derive(Serialize)]
struct Details {
    directions: usize,
    stored_directions: usize,
    radii: usize,
    /// Of a bitmap.
    texels: usize,
    /// Of the whole table as bitmaps.
    bytes_of_bitmaps: usize,
}

/// The same for all, for there is one table only.
fn describe(_: &Path) -> Result<Described> {
    let details = Details {
        directions: DIRECTIONS,
        stored_directions: STORED_DIRECTIONS,
        radii: RADII,
        texels: DIRECTIONS,
        bytes_of_bitmaps: DIRECTIONS * RADII * BYTES,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details { directions, stored_directions, radii, texels, bytes_of_bitmaps } = details;
    let [texels, directions, bytes] = [texels, directions, bytes_of_bitmaps].map(|n| grouped(*n as u64));
    vec![
        (
            "table",
            format!("a bitmap of {texels} texels for each of {directions} directions and {radii} radii"),
        ),
        ("stored", format!("{stored_directions} directions, which the symmetries of the cube make all of")),
        ("expanded", format!("{bytes} bytes")),
    ]
}

/// `visibility.npy` [136, 32, 768], the bitmaps of the stored directions; `directions.npy` [136, 3], unit;
/// `texels.npy` [136], the texels that these are the centres of; `radii.npy` [32]; `visibility.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let table = &VisibilityTable::read_file(path)?;
    let bitmaps = stored_directions()
        .flat_map(|direction| (0..RADII).flat_map(move |radius| *table.bitmap(direction, radius)));
    // All of them are on the first face.
    let direction = |texel| {
        cubemap::direction(0, SIDE, (texel % SIDE) as f64 + 0.5, (texel / SIDE) as f64 + 0.5).to_array()
    };
    out.npy("visibility.npy", &[STORED_DIRECTIONS, RADII, BYTES], bitmaps)?;
    out.npy("directions.npy", &[STORED_DIRECTIONS, 3], stored_directions().flat_map(direction))?;
    out.npy("texels.npy", &[STORED_DIRECTIONS], stored_directions().map(|texel| texel as u32))?;
    out.npy("radii.npy", &[RADII], (0..RADII).map(radius_of))?;
    out.json(
        "visibility.json",
        &json!({
            "file": "visibility.npy",
            "shape": [STORED_DIRECTIONS, RADII, BYTES],
            "rows": "a sphere in direction directions.npy[row], the centre of texel texels.npy[row] of a cube of 32 x 32 texels a face; all others are \
                     these with the axes of the cube exchanged and mirrored, and so are their bitmaps",
            "columns": "relative radii, radius over distance of the centre, radii.npy: sin((k + 1/2)/32 * 90 degrees)",
            "bits": "texel (x, y) of a face is bit x mod 8, lowest first, of byte (face*32 + y)*4 + x/8; 1 is blocked: the texel's centre is \
                     within arcsin(radius) of the direction",
        }),
    )
}
