//! Kind `visibility-table`, version 0: the texels that one sphere blocks, for 6 × 32 × 32 directions and 32 sizes (sphere shadows §3.3).
//!
//! | section | type | shape       | content |
//! |---------|------|-------------|---------|
//! | `rings` | u8   | [136, 6144] | for each stored direction and texel the number of the narrowest cap that blocks the texel, 32 if none does |
//!
//! A sphere of radius R about a centre P − p away from the receiver is a cap: direction v, relative radius r = R/|P − p| below 1, half angle α = asin r.
//! A texel is **blocked** if its centre direction d has d·v ≥ cos α = √(1 − r²). A blocked bit is 1, the order of bits that of
//! [`crate::basis::two_level`].
//!
//! **Directions** are the centres of the texels of a cube of 32 × 32 a face ([`crate::basis::cubemap`]); a direction counts as that of the texel it points
//! into. **Sizes** are uniform in half angle: α_k = (k + ½)/32 · 90°, k = 0..32. A half angle counts as the nearest of these and 0, which blocks nothing:
//! k stands for k/32 · 90° ≤ α < (k + 1)/32 · 90°, but 0 for α₀/2 ≤ α only. α₀ is 1.4°, the half angle of a cap as large as a texel is on average, so
//! what is left out is smaller than half that width.
//!
//! **What is stored.** Wider caps block what narrower ones do, so a number for each texel says all about the 32 bitmaps of a direction. And
//! the 48 symmetries of the cube make all directions of 136, those of face +X with y ≥ z > 0, in the order of their texels: a symmetry that takes one
//! direction to another takes the blocked texels along. That is exact, ties included, because all centres are multiples of 1/32 before they are
//! normalised: products and squared lengths are exact in double precision, and only such are compared. No texel lies on the edge of a cap, for
//! cos² α_k is irrational (Niven 1956) and the squared cosine of the angle between two centres is not.
//!
//! There is one such table, and a reader compares every value with it. Expanded it has 144 MiB.

mod symmetry;

use crate::basis::cubemap::{self, FACES};
use crate::basis::two_level::{BYTES, SIDE};
use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use glam::Vec3;
use std::f64::consts::FRAC_PI_2;
use symmetry::{Image, Symmetry};

/// Directions, and texels of a bitmap.
pub const DIRECTIONS: usize = FACES * SIDE * SIDE;
/// Bitmaps of a direction.
pub const RADII: usize = 32;
/// Directions stored: one of each that the cube's symmetries take to each other.
pub const STORED_DIRECTIONS: usize = 136;
/// Of the stored section.
const SHAPE: [u64; 2] = [STORED_DIRECTIONS as u64, DIRECTIONS as u64];

/// The texels that one sphere blocks, for every direction and size of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibilityTable {
    /// [[`DIRECTIONS`], [`RADII`]], neither more nor fewer.
    bitmaps: Vec<[u8; BYTES]>,
}

impl VisibilityTable {
    /// Computes the table.
    pub fn bake() -> Self {
        Self::expand(&bake_rings())
    }

    /// The blocked texels of a sphere in the direction of texel `direction` whose relative radius is
    /// [`radius_of`]\(`radius`).
    ///
    /// # Panics
    /// If `direction` is not below [`DIRECTIONS`] or `radius` not below [`RADII`].
    pub fn bitmap(&self, direction: usize, radius: usize) -> &[u8; BYTES] {
        assert!(radius < RADII, "a radius of the table");
        &self.bitmaps[direction * RADII + radius]
    }

    /// The blocked texels of a sphere in `direction`, of any length, of relative radius `r`, by the nearest
    /// direction and half angle of the table; `None` if the sphere counts as nothing, as it does with `r` not
    /// above 0.
    ///
    /// From r = 1 on the receiver is inside, which the caller must see to: the widest cap of the table leaves
    /// half of all texels free.
    pub fn look_up(&self, direction: Vec3, r: f32) -> Option<&[u8; BYTES]> {
        let steps = f64::from(r).clamp(0.0, 1.0).asin() / FRAC_PI_2 * RADII as f64;
        // Not so either with NaN.
        (steps >= 0.25)
            .then(|| self.bitmap(cubemap::texel_of(direction, SIDE), (steps as usize).min(RADII - 1)))
    }

    /// The whole table from its stored form.
    fn expand(rings: &[u8]) -> Self {
        let mut bitmaps = vec![[0; BYTES]; DIRECTIONS * RADII];
        for (texel, rings) in stored_directions().zip(rings.as_chunks::<DIRECTIONS>().0) {
            let image = Image::new(rings);
            for symmetry in Symmetry::all() {
                let to = symmetry.texel(texel) * RADII;
                image.write(&symmetry, &mut bitmaps[to..to + RADII]);
            }
        }
        Self { bitmaps }
    }

    /// The stored form.
    fn rings(&self) -> Vec<u8> {
        let blocked =
            |direction, radius, texel| self.bitmap(direction, radius)[texel / 8] >> (texel % 8) & 1 == 1;
        let free = |direction, texel| {
            (0..RADII).take_while(|radius| !blocked(direction, *radius, texel)).count() as u8
        };
        stored_directions()
            .flat_map(|direction| (0..DIRECTIONS).map(move |texel| free(direction, texel)))
            .collect()
    }
}

/// The relative radius of the spheres that bitmap number `radius` of a direction is made for: sin((`radius` +
/// ½)/32 · 90°).
pub fn radius_of(radius: usize) -> f64 {
    half_angle(radius).sin()
}

/// In radians.
fn half_angle(radius: usize) -> f64 {
    (radius as f64 + 0.5) / RADII as f64 * FRAC_PI_2
}

/// The texels whose directions are stored, in the order of the file.
pub fn stored_directions() -> impl Iterator<Item = usize> {
    // The triangle above the diagonal of the upper left quarter of +X.
    (0..SIDE / 2).flat_map(|y| (y..SIDE / 2).map(move |x| y * SIDE + x))
}

/// The stored form, [[`STORED_DIRECTIONS`], [`DIRECTIONS`]].
fn bake_rings() -> Vec<u8> {
    let squared_cosines: [f64; RADII] = std::array::from_fn(|radius| half_angle(radius).cos().powi(2));
    let centres: Vec<[f64; 3]> = (0..DIRECTIONS).map(symmetry::centre).collect();
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let ring = |v: [f64; 3], d: [f64; 3]| {
        let (cosine, lengths) = (dot(v, d), dot(v, v) * dot(d, d));
        // Caps are narrower than a hemisphere.
        if cosine > 0.0 {
            squared_cosines.partition_point(|least| cosine * cosine < least * lengths) as u8
        } else {
            RADII as u8
        }
    };
    stored_directions()
        .flat_map(|v| centres.iter().map(|d| ring(centres[v], *d)).collect::<Vec<_>>())
        .collect()
}

/// The stored form, compared with what it must be.
fn rings(sections: &mut Sections<'_>) -> Result<Vec<u8>> {
    let section = sections.take("rings")?;
    section.expect_shape(&SHAPE)?;
    let rings = section.u8s()?;
    match rings.iter().zip(&bake_rings()).position(|(stored, right)| stored != right) {
        None => Ok(rings),
        Some(at) => Err(section.invalid(format!(
            "texel {} of stored direction {} is wrong",
            at % DIRECTIONS,
            at / DIRECTIONS
        ))),
    }
}

impl Stored for VisibilityTable {
    const KIND: Kind = Kind::VisibilityTable;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        out.u8s("rings", &SHAPE, &self.rings())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        rings(sections).map(|rings| Self::expand(&rings))
    }

    fn check(sections: &mut Sections<'_>) -> Result<()> {
        rings(sections).map(drop)
    }
}
