//! The table of 4 × 4 bitmaps.

use super::out::Out;
use super::words::grouped;
use super::{Described, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::HaarTable;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::HaarTable, describe, export };

#[derive(Serialize)]
struct Details {
    bitmaps: u64,
    coefficients: u64,
}

/// The same for all, for there is one table only.
fn describe(_: &Path) -> Result<Described> {
    let details = Details { bitmaps: 65_536, coefficients: 16 };
    let table = format!(
        "{} Haar coefficients of each of {} bitmaps of 4 × 4",
        details.coefficients,
        grouped(details.bitmaps)
    );
    Ok(Described { facts: vec![("table", table)], details: Box::new(details) })
}

/// `table.npy` [65536, 16], `table.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let table = HaarTable::read_file(path)?;
    out.npy("table.npy", &[table.coefficients().len() / 16, 16], table.coefficients().iter().copied())?;
    out.json(
        "table.json",
        &json!({
            "file": "table.npy",
            "shape": [65536, 16],
            "rows": "bitmaps of 4 x 4 texels: bit 4y + x of the row's number is texel (x, y), y down; a set bit is 1, else 0",
            "columns": "orthonormal Haar coefficients: 0 the scaling function 1/4, then 4^l*m + j*2^l + i of level l, type m, square (i, j), \
                        with the value 2^l/4 on its square, in m = 1 positive left and negative right, in m = 2 positive above and negative \
                        below, in m = 3 the product of both signs",
        }),
    )
}
