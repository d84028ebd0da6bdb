//! Method `region-images`: what pixels show where materials are painted (thesis eq. 4-35).

use crate::basis::haar;
use crate::kinds::region_images::planes::{CELLS, Planes, SIDE};
use crate::kinds::region_images::{
    COVER, Entries, Head, REGION_COUNT, REGIONS, RegionImages, Row, Source, Tap,
};
use crate::kinds::{BrdfBasis, transfer_images::Fragments};
use crate::state::{Brdf, Paint, Rgb, Texel};

/// Fewest points along each side of a region that tell what its material is in the mean.
pub const LEAST_POINTS: usize = 4;

/// How an editable material is.
#[derive(Debug, Clone, Copy)]
pub enum Worn<'a> {
    /// The same everywhere.
    Whole(&'a Brdf),
    /// As textures say.
    Painted(&'a Paint),
}

/// A material that is the same everywhere, on all bases, or by region, row-major [[`REGION_COUNT`], bases].
#[derive(Debug, Clone, PartialEq)]
pub struct OnBases(pub Vec<Rgb>);

impl OnBases {
    /// That of a basis, of so many; of a region, if they differ.
    pub fn of(&self, region: usize, basis: usize, bases: usize) -> Rgb {
        self.0.get(region * bases + basis).copied().unwrap_or_default()
    }
}

/// Coefficients of what `texel` says of a material, on all bases; `None` if it is of another model than the basis.
pub fn coefficients_at(basis: &BrdfBasis, brdf: &Brdf, texel: &Texel) -> Option<Vec<Rgb>> {
    let [red, green, blue] = brdf.channels(texel);
    let mut coefficients = basis.coefficients_of(&red)?;
    if green != red || blue != red {
        let others = [basis.coefficients_of(&green)?, basis.coefficients_of(&blue)?];
        for (channel, other) in (1..).zip(&others) {
            coefficients.iter_mut().zip(other).for_each(|(c, other)| c[channel] = other[channel]);
        }
    }
    Some(coefficients)
}

/// Points along each side of a region at which textures of `texels` a side are looked at: at every texel, where
/// regions have a whole number of them.
pub fn points_of(texels: u32) -> usize {
    (texels as usize).div_ceil(REGIONS).max(LEAST_POINTS)
}

/// Mean coefficients of every region of a painted material over its points that are on a surface, or all if none is.
/// `cover` is that of the material.
pub fn region_means(basis: &BrdfBasis, paint: &Paint, cover: &[bool]) -> Option<OnBases> {
    let points = paint.size.map(points_of);
    let bases = basis.bases();
    let mut means = vec![[0.0; 3]; REGION_COUNT * bases];
    for (region, means) in means.chunks_exact_mut(bases).enumerate() {
        let corner = [region % REGIONS, region / REGIONS];
        let at = |x: usize, y: usize| {
            let place = |k: usize, i: usize| {
                let all = (REGIONS * points[k]) as f32;
                ((corner[k] * points[k] + i) as f32 + 0.5) / all
            };
            [place(0, x), place(1, y)]
        };
        let all = (0..points[1]).flat_map(|y| (0..points[0]).map(move |x| (x, y)));
        let on_surface: Vec<[f32; 2]> =
            all.clone().map(|(x, y)| at(x, y)).filter(|uv| is_covered(cover, *uv)).collect();
        let places = if on_surface.is_empty() { all.map(|(x, y)| at(x, y)).collect() } else { on_surface };
        for uv in &places {
            let here = coefficients_at(basis, &paint.brdf, &paint.at(*uv))?;
            add(means, &here, 1.0 / places.len() as f32);
        }
    }
    Some(OnBases(means))
}

fn is_covered(cover: &[bool], uv: [f32; 2]) -> bool {
    let [x, y] = uv.map(|x| ((x * COVER as f32) as usize).min(COVER - 1));
    cover.get(y * COVER + x).copied().unwrap_or(false)
}

fn add(sums: &mut [Rgb], terms: &[Rgb], weight: f32) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += weight * term);
    }
}

/// What each editable material is to light that it reflects on its way to the eye's surface; `None` if one is of
/// another model than the basis.
pub fn before_eye(head: &Head, basis: &BrdfBasis, worn: &[Worn<'_>]) -> Option<Vec<OnBases>> {
    let mut cover = head.cover.iter();
    worn.iter()
        .map(|worn| match worn {
            Worn::Whole(brdf) => basis.coefficients_of(brdf).map(OnBases),
            Worn::Painted(paint) => region_means(basis, paint, cover.next().map_or(&[], Vec::as_slice)),
        })
        .collect()
}

/// What materials make of each row, by basis of the eye: α times its colour and step.
pub fn row_factors(head: &Head, bases: usize, materials: &[OnBases]) -> Vec<Vec<Rgb>> {
    let mut weights = head.weights.iter();
    let mut alpha = |row: &Row| -> Rgb {
        match row.source {
            Source::Fixed => [1.0; 3],
            Source::Whole { material, basis } => {
                materials[usize::from(material)].of(0, usize::from(basis), bases)
            }
            Source::Painted { material, basis } => {
                let weights = weights.next().map_or(&[][..], Vec::as_slice);
                let mut sum = [0.0; 3];
                for (region, weight) in weights.iter().enumerate() {
                    let c = materials[usize::from(material)].of(region, usize::from(basis), bases);
                    add(std::slice::from_mut(&mut sum), &[c], weight.to_f32());
                }
                sum
            }
        }
    };
    let mut factor = |row: &Row| {
        let alpha = alpha(row);
        std::array::from_fn(|k| alpha[k] * row.colour[k] * row.step)
    };
    head.rows.iter().map(|rows| rows.iter().map(&mut factor).collect()).collect()
}

/// Light that was reflected before, by cell of the planes, on one basis of the eye.
pub fn indirect(entries: &Entries, factors: &[Rgb]) -> Vec<Rgb> {
    let mut planes = vec![[0.0; 3]; entries.places()];
    let (mut channel, mut scratch) = (vec![0.0; CELLS], Vec::new());
    for (tile, cells) in planes.chunks_exact_mut(CELLS).enumerate() {
        for k in 0..3 {
            for (place, sum) in channel.iter_mut().enumerate() {
                let terms = entries.at(tile * CELLS + place);
                *sum = terms.map(|(row, steps)| factors[usize::from(row)][k] * f32::from(steps)).sum();
            }
            haar::inverse(&mut channel, SIDE, &mut scratch);
            cells.iter_mut().zip(&channel).for_each(|(cell, value)| cell[k] = *value);
        }
    }
    planes
}

/// Linear radiance of every pixel, row by row; `worn` are the editable materials in the order of the file. `None` if
/// one is of another model than the basis.
pub fn evaluate(images: &RegionImages, basis: &BrdfBasis, worn: &[Worn<'_>]) -> Option<Vec<Rgb>> {
    let head = &images.head;
    let factors = row_factors(head, basis.bases(), &before_eye(head, basis, worn)?);
    let planes: Vec<Vec<Rgb>> =
        images.indirect.iter().zip(&factors).map(|(entries, factors)| indirect(entries, factors)).collect();
    let Planes { cells, .. } = head.planes();
    let Fragments { pixel, coverage, .. } = &head.fragments;
    let at_eye = at_fragments(head, basis, worn)?;
    let mut film = vec![[0.0; 3]; head.meta.size[0] as usize * head.meta.size[1] as usize];
    for (fragment, coefficients) in at_eye.iter().enumerate() {
        let share = coverage[fragment].to_f32();
        for (e, c) in coefficients.iter().enumerate() {
            let direct = direct_light(images, e, fragment);
            let before = planes.get(e).map_or([0.0; 3], |plane| plane[cells[fragment] as usize]);
            let out = &mut film[pixel[fragment] as usize];
            (0..3).for_each(|k| out[k] += c[k] * (direct[k] + before[k] * share));
        }
    }
    Some(film)
}

/// Coefficients of every fragment on the bases of the eye: fixed ones have one basis, in which their BRDF is.
pub fn at_fragments(head: &Head, basis: &BrdfBasis, worn: &[Worn<'_>]) -> Option<Vec<Vec<Rgb>>> {
    let whole = |worn: &Worn<'_>| match worn {
        Worn::Whole(brdf) => basis.coefficients_of(brdf),
        Worn::Painted(_) => None,
    };
    let wholes: Vec<Option<Vec<Rgb>>> = worn.iter().map(whole).collect();
    let mut taps = head.taps.iter();
    let mut of = |class: &u16| match worn.get(usize::from(*class)) {
        None => Some(vec![[1.0; 3]]),
        Some(Worn::Whole(_)) => wholes[usize::from(*class)].clone(),
        Some(Worn::Painted(paint)) => at_taps(basis, paint, taps.next()?),
    };
    head.fragments.class.iter().map(&mut of).collect()
}

/// Mean coefficients of a painted material at what a fragment shows of it.
fn at_taps(basis: &BrdfBasis, paint: &Paint, taps: &[Tap]) -> Option<Vec<Rgb>> {
    let all: f32 = taps.iter().map(|tap| f32::from(tap.weight)).sum();
    let mut mean = vec![[0.0; 3]; basis.bases()];
    for tap in taps.iter().filter(|tap| tap.weight > 0) {
        let here = coefficients_at(basis, &paint.brdf, &paint.at(tap.uv()))?;
        add(&mut mean, &here, f32::from(tap.weight) / all);
    }
    Some(mean)
}

/// Of a fragment on a basis of the eye.
fn direct_light(images: &RegionImages, basis: usize, fragment: usize) -> Rgb {
    let head = &images.head;
    let (count, halves) = (head.direct_fragments(basis), &images.direct[basis]);
    let value = |channel: usize| halves[channel * count + fragment].to_f32() * head.scales[basis];
    if head.meta.is_rgb(basis) {
        std::array::from_fn(value)
    } else {
        head.meta.chromaticity.unwrap_or([1.0; 3]).map(|colour| colour * value(0))
    }
}
