//! Method `sphere-shadows`: the radiance of a white diffuse surface under a map of light that spheres (sphere
//! shadows §3.3-§4.1) or triangles of the meshes ([`casters`], ours) block.
//!
//! Radiance is ∫ L·ρ̃·V, with L the light, ρ̃ = max(0, n·ω)/π·dω the lobe of the receiver's normal and V its
//! visibility, 1 where nothing blocks the centre of a texel. What blocks is OR-ed as bitmaps; the product is
//! summed from Haar coefficients by the three cases of [`triple`]:
//!
//! * cases 1, 2 and the two parts of 3 in which ρ̃ is one of the equal wavelets run over the kept terms of
//!   ρ̃, the other factors whole;
//! * the part of case 3 in which L and V are the equal wavelets runs over the kept terms of L, with the means
//!   of ρ̃.
//!
//! How fine V is in these is [`Levels`]. The source leaves open which level case 2 uses; here it is that of
//! the other sums over terms of ρ̃.
//!
//! **Whose spheres block whom** is ours, the source has no self-shadowing. A receiver on an object that has spheres
//! leaves out of that object's set the sphere of its own cluster, every sphere that overlaps that one at
//! rest, and any that holds it now: these reach beyond the surface right where it is. Spheres of other
//! objects always count, and inside one of them all is blocked. A sphere that is wholly below the horizon of
//! the normal counts nowhere: there the lobe is 0, and what its blend or its kept terms have there is error.

mod casters;
mod placing;

pub use casters::{CasterMeshes, CasterTriangle, Casters, Sides, Spheres, Triangle, neighbours};
pub use placing::receivers;

use crate::basis::approximate::{by_size, largest};
use crate::basis::cap::{self, Bitmap, ROWS, add_sphere};
use crate::basis::psum::psum;
use crate::basis::span;
use crate::basis::triple::{Operand, of_equals, with_terms};
use crate::basis::two_level::{SIDE, two_level};
use crate::kinds::HaarTable;
use crate::kinds::sphere_shadows::Meta;
use crate::state::Rgb;
use glam::Vec3;

/// Coefficients of a face.
const FACE: usize = SIDE * SIDE;
/// Of these, the coefficients of the first level, which the 8 × 8 tiles of a face give.
pub(crate) const FIRST_LEVEL: usize = FACE / 16;

/// What the visibility is rounded to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Levels {
    /// Its first level everywhere, the means over 4 × 4 texels (the source's "I").
    One,
    /// Its first level, but both in the sum over terms of light (the source's "II").
    Two,
    /// All of it everywhere: with all terms the product is exact.
    All,
}

/// How exactly the product is summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detail {
    /// Coefficients kept of the light and of each lobe, over the whole cube; all of them if none is given.
    pub terms: Option<usize>,
    /// Levels of visibility.
    pub levels: Levels,
}

impl Detail {
    /// What a bake asks to be shown with.
    pub fn of(meta: &Meta) -> Self {
        Self {
            terms: Some(meta.terms as usize),
            levels: if meta.second_level { Levels::Two } else { Levels::One },
        }
    }
}

/// A factor of the product: its coefficients, the means that they make, and the terms that are kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    coefficients: Vec<f32>,
    psums: Vec<f32>,
    terms: Vec<(u32, f32)>,
}

impl Function {
    fn new(coefficients: Vec<f32>, kept: &[u32]) -> Self {
        let terms =
            kept.iter().filter_map(|index| Some((*index, *coefficients.get(*index as usize)?))).collect();
        Self { psums: psum(&coefficients, SIDE), coefficients, terms }
    }

    /// Haar coefficients, [6·32·32].
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// Means over squares, in the order of [`crate::basis::psum`].
    pub fn psums(&self) -> &[f32] {
        &self.psums
    }

    /// Index and value of the coefficients that are kept, by index.
    pub fn terms(&self) -> &[(u32, f32)] {
        &self.terms
    }

    fn operand(&self) -> Operand<'_, f32> {
        Operand { coefficients: &self.coefficients, psums: &self.psums }
    }
}

/// A lobe of the `coefficients` that [`crate::basis::diffuse::lobe`] makes, with its `terms` of largest size,
/// the scaling functions first.
///
/// # Panics
/// If `coefficients` are no whole faces of 32 × 32.
pub fn lobe(coefficients: Vec<f32>, terms: Option<usize>) -> Function {
    let kept = kept(&coefficients, terms);
    Function::new(coefficients, &kept)
}

/// Light of the `coefficients` of red, green and blue, with the terms whose norm over the three is largest,
/// the scaling functions first.
///
/// # Panics
/// If the channels are not of one length, whole faces of 32 × 32.
pub fn light(coefficients: [Vec<f32>; 3], terms: Option<usize>) -> [Function; 3] {
    let [r, g, b] = &coefficients;
    let norms: Vec<f32> = (0..r.len()).map(|i| (r[i] * r[i] + g[i] * g[i] + b[i] * b[i]).sqrt()).collect();
    let kept = kept(&norms, terms);
    coefficients.map(|channel| Function::new(channel, &kept))
}

/// Indices of what is kept, in order.
fn kept(sizes: &[f32], terms: Option<usize>) -> Vec<u32> {
    let first = |index: usize| if index.is_multiple_of(FACE) { f32::MAX } else { by_size(index) };
    let mut kept: Vec<u32> =
        largest(sizes, terms.unwrap_or(sizes.len()), first).into_iter().map(|(index, _)| index).collect();
    kept.sort_unstable();
    kept
}

/// Where a receiver belongs among the spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Own {
    /// The set of its object.
    pub set: u32,
    /// The sphere of its cluster.
    pub sphere: u32,
}

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// World space, metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Lobes whose weighted sum is that of the normal, as [`crate::basis::diffuse::blend`] gives them; weight
    /// 0 for those not needed.
    pub lobes: [(u32, f32); 4],
    /// Its object, in the order of the scene.
    pub object: u32,
    /// Set if its object casts by spheres.
    pub own: Option<Own>,
}

impl Receiver {
    /// Whether a sphere of its own object is left out: the `sphere`th of `spheres`, at `offset` from it.
    fn leaves_out(&self, spheres: &Spheres, own: Own, sphere: usize, offset: Vec3) -> bool {
        let near = spheres
            .neighbours
            .get(own.sphere as usize)
            .is_some_and(|near| near.binary_search(&(sphere as u32)).is_ok());
        near || cap::tangent2(offset.to_array(), spheres.now[sphere][3]) <= 0.0
    }

    /// Adds what `triangle` blocks of its view, if it counts and any of it is above the horizon.
    fn add_triangle(&self, bitmap: &mut Bitmap, triangle: &Triangle) {
        let offsets = triangle.corners.map(|corner| Vec3::from(corner) - self.position);
        let height = Triangle::height(triangle.normal, offsets[0].to_array());
        let sides = triangle.sides[usize::from(triangle.object != self.object)];
        if sides.count_from(height) && offsets.iter().any(|offset| self.normal.dot(*offset) > 0.0) {
            span::add_triangle(bitmap, offsets, if height > 0.0 { 1.0 } else { -1.0 });
        }
    }

    /// Whether any of a sphere is above its horizon.
    fn faces(&self, offset: Vec3, radius: f32) -> bool {
        self.normal.dot(offset) > -radius
    }
}

/// The texels in which a receiver's view is blocked.
pub fn blocked(receiver: &Receiver, casters: &Casters) -> Bitmap {
    let mut bitmap = [0; ROWS];
    casters.triangles.iter().for_each(|triangle| receiver.add_triangle(&mut bitmap, triangle));
    for (set, spheres) in casters.spheres.iter().enumerate() {
        let own = receiver.own.filter(|own| own.set as usize == set);
        for (sphere, [x, y, z, radius]) in spheres.now.iter().enumerate() {
            let offset = Vec3::new(*x, *y, *z) - receiver.position;
            if receiver.faces(offset, *radius)
                && !own.is_some_and(|own| receiver.leaves_out(spheres, own, sphere, offset))
            {
                add_sphere(&mut bitmap, offset, *radius);
            }
        }
    }
    bitmap
}

/// Linear radiance that a white diffuse surface shows at each receiver, W/(sr·m²). `lobes` and `light` carry
/// the terms of [`Detail::terms`].
///
/// # Panics
/// If a receiver has a lobe, of weight other than 0, beyond `lobes`.
pub fn radiance(
    receivers: &[Receiver],
    casters: &Casters,
    lobes: &[Function],
    light: &[Function; 3],
    levels: Levels,
    table: &HaarTable,
) -> Vec<Rgb> {
    let of = |receiver: &Receiver| {
        let visibility = Visibility::new(&blocked(receiver, casters).map(|row| !row), table);
        let used = receiver.lobes.iter().filter(|(_, weight)| *weight != 0.0);
        used.fold([0.0; 3], |sum: Rgb, (lobe, weight)| {
            std::array::from_fn(|c| {
                sum[c] + weight * product(&light[c], &lobes[*lobe as usize], &visibility, levels)
            })
        })
    };
    receivers.iter().map(of).collect()
}

/// V at both levels.
struct Visibility {
    all: Function,
    first_level: Function,
}

impl Visibility {
    fn new(visible: &Bitmap, table: &HaarTable) -> Self {
        let mut all = vec![0.0; ROWS * SIDE];
        two_level(&cap::bytes(visible), table, &mut all);
        let mut first_level = all.clone();
        first_level.chunks_exact_mut(FACE).for_each(|face| face[FIRST_LEVEL..].fill(0.0));
        Self { all: Function::new(all, &[]), first_level: Function::new(first_level, &[]) }
    }
}

/// Σ L·ρ̃·V over all texels.
fn product(light: &Function, lobe: &Function, visibility: &Visibility, levels: Levels) -> f32 {
    let Visibility { all, first_level } = visibility;
    let (with_lobe, with_light) = match levels {
        Levels::One => (first_level, first_level),
        Levels::Two => (first_level, all),
        Levels::All => (all, all),
    };
    with_terms(&lobe.terms, &light.operand(), &with_lobe.operand(), SIDE)
        + of_equals(&light.terms, &with_light.coefficients, &lobe.psums, SIDE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::haar::index;

    /// Case 2 is a sum over six assignments of three types to three factors; the source prints five.
    #[test]
    fn three_types_count_in_all_six_orders() {
        let wavelet = |level: u32, m: usize| {
            let mut coefficients = vec![0.0; 6 * FACE];
            coefficients[2 * FACE + index(level, m, 0, 0)] = 1.0;
            lobe(coefficients, None)
        };
        for level in 0..5 {
            for (l, p, v) in [(1, 2, 3), (1, 3, 2), (2, 1, 3), (2, 3, 1), (3, 1, 2), (3, 2, 1)] {
                let visible = wavelet(level, v);
                let none = lobe(vec![0.0; 6 * FACE], None);
                let both = if level < 3 { visible.clone() } else { none };
                let visibility = Visibility { all: visible, first_level: both };
                let expected = (1 << level) as f32 / 32.0;
                assert_eq!(
                    product(&wavelet(level, l), &wavelet(level, p), &visibility, Levels::All),
                    expected
                );
                let first = if level < 3 { expected } else { 0.0 };
                assert_eq!(product(&wavelet(level, l), &wavelet(level, p), &visibility, Levels::One), first);
            }
        }
    }

    #[test]
    fn the_scaling_functions_are_kept_first() {
        let mut coefficients: Vec<f32> = (0..6 * FACE).map(|i| (i % 97) as f32).collect();
        coefficients.iter_mut().step_by(FACE).for_each(|c| *c = 1e-3);
        let kept = lobe(coefficients, Some(8));
        assert_eq!(kept.terms.len(), 8);
        assert!((0..6).all(|face| kept.terms.contains(&(face * 1024, 1e-3))));
        assert_eq!(kept.terms.iter().filter(|(_, value)| *value == 96.0).count(), 2);
    }
}
