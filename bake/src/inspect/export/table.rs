//! The table of 4 × 4 bitmaps as an array.

use super::out::Out;
use relume_formats::Result;
use relume_formats::kinds::HaarTable;
use serde_json::json;

/// `table.npy` [65536, 16], `table.json`.
pub(super) fn export(table: &HaarTable, out: &mut Out) -> Result<()> {
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
