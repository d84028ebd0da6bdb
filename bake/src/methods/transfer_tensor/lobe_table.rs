//! Means of reflectance over texels of a coarse light, from a table.
//!
//! A texel of 6×8×8 is 14° wide in the middle of a face, about as wide as the sharpest lobe, so that the
//! reflectance at its middle says little. Functions of a material depend on three angles alone: of the
//! incoming and the outgoing direction with the normal, and of the azimuth between them. The table has their
//! means over discs around the incoming direction, weighted with the cosine, where these are above the
//! horizon; discs have the solid angles of texels, which differ by a factor of five over a face, in
//! [`SIZES`] steps. What it takes for granted is that a texel may be taken for a disc, and that what of it
//! is hidden does not depend on where in the lobe it is.
//!
//! Nodes are even in the angles with the normal. Those of azimuth crowd where the directions mirror each
//! other, for there lobes seen along the surface are narrow: node x of 0..=1 is at 2·atan(x²/(1 − x²)) from
//! that azimuth.

use super::functions::{Functions, MOST};
use crate::brdf::angles;
use crate::methods::sparse_transfer::texels::FACE_SIZE as FINE;
use glam::{DVec3, Vec3A, Vec4};
use rayon::prelude::*;
use relume_formats::basis::cubemap::{FACES, direction, solid_angles};
use std::f32::consts::FRAC_PI_2;

/// Nodes of an angle with the normal, 0° to 90°.
pub const NODES: usize = 33;
/// Nodes of azimuth.
const AZIMUTHS: usize = 33;
/// Solid angles of discs.
const SIZES: usize = 6;
/// Points of a disc.
const POINTS: usize = 128;
/// Of the last node of the outgoing direction, in nodes: functions may have a pole at the horizon.
const LAST: f32 = (NODES - 1) as f32 - 0.25;
/// Texels whose azimuths are found at once.
const CHUNK: usize = 64;

/// The angle with the normal at `node`, radians.
pub fn angle_at(node: f32) -> f32 {
    node * FRAC_PI_2 / (NODES - 1) as f32
}

/// The node before an outgoing direction of `cosine`, and the share of the node after it.
pub fn locate(cosine: f32) -> (usize, f32) {
    let at = cosine.clamp(0.0, 1.0).acos() * ((NODES - 1) as f32 / FRAC_PI_2);
    let node = (at as usize).min(NODES - 2);
    (node, (at - node as f32).min(1.0))
}

/// The outgoing direction of `node`, whose azimuth is 0.
pub fn outgoing_at(node: usize) -> Vec3A {
    let (sin, cos) = angle_at((node as f32).min(LAST)).sin_cos();
    Vec3A::new(sin, 0.0, cos)
}

/// Where an azimuth falls among the nodes, by the cosine of its distance from the mirrored one.
fn azimuth_place(cosine: f32) -> f32 {
    let [far, near] = [-cosine, cosine].map(|c| (0.5 + 0.5 * c).max(0.0).sqrt());
    (far / (far + near)).sqrt() * (AZIMUTHS - 1) as f32
}

/// The inverse: cosine and sine at `place`, 0 to 1.
pub fn azimuth_at(place: f32) -> [f32; 2] {
    let (far, near) = (place * place, 1.0 - place * place);
    let scale = (far * far + near * near).recip();
    [(near * near - far * far) * scale, 2.0 * far * near * scale]
}

/// The texels of a light as discs.
pub struct Discs {
    directions: Vec<Vec3A>,
    /// By texel, which size it has.
    sizes: Vec<usize>,
    /// Solid angles, sr.
    solid_angles: [f64; SIZES],
}

/// A texel of the light as a vertex has it.
#[derive(Debug, Clone, Copy)]
pub struct Lit {
    /// Which one.
    pub texel: u16,
    /// Of the node of the incoming angle before it in a table.
    row: u16,
    /// The share of the node after it.
    share: f32,
    /// Cosine and sine of the azimuth in the frame of the vertex.
    azimuth: [f32; 2],
    /// ∫ V·max(0, n·ω) dω over it, sr.
    pub arriving: f32,
}

impl Discs {
    /// Of a light of `face_size`² texels a face, a power of two of at most 64.
    pub fn new(face_size: usize) -> Self {
        let n = face_size;
        let of_face = solid_angles(n);
        let [least, most] = [f64::min, f64::max].map(|f| of_face.iter().copied().fold(of_face[0], f));
        let step = (most / least).ln() / SIZES as f64;
        let size = |solid_angle: f64| ((solid_angle / least).ln() / step.max(1e-9)) as usize;
        Self {
            directions: middles(n),
            sizes: (0..FACES * n * n).map(|i| size(of_face[i % (n * n)]).min(SIZES - 1)).collect(),
            solid_angles: std::array::from_fn(|k| least * ((k as f64 + 0.5) * step).exp()),
        }
    }

    /// `texel` at a vertex with `normal`; if its middle is below the horizon, at the horizon.
    pub fn lit(&self, (texel, arriving): (u16, f32), normal: Vec3A) -> Lit {
        let [x, y, z] = in_frame(normal, self.directions[usize::from(texel)]).to_array();
        let (node, share) = locate(z);
        let length = (x * x + y * y).sqrt().max(f32::MIN_POSITIVE);
        let row = (self.sizes[usize::from(texel)] * NODES * NODES + node) as u16;
        Lit { texel, row, share, azimuth: [x / length, y / length], arriving }
    }
}

/// The mean direction of every texel, which in the outer ones is not that of their middle on the face: by a
/// quarter of a degree in texels of 6×8×8, where a lobe of 8° may change by 3 %.
fn middles(face_size: usize) -> Vec<Vec3A> {
    let (n, step) = (FINE, FINE / face_size);
    let of_face = solid_angles(n);
    let mut sums = vec![DVec3::ZERO; FACES * face_size * face_size];
    for (i, solid_angle) in (0..FACES).flat_map(|_| &of_face).enumerate() {
        let (row, x) = (i / n, i % n);
        let towards = direction(row / n, n, x as f64 + 0.5, (row % n) as f64 + 0.5);
        sums[row / step * face_size + x / step] += towards * *solid_angle;
    }
    sums.into_iter().map(|sum| sum.normalize().as_vec3a()).collect()
}

/// A direction in the frame of a surface of unit `normal`: along tangent, bitangent, normal.
pub fn in_frame(normal: Vec3A, direction: Vec3A) -> Vec3A {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Vec3A::new(direction.dot(tangent), direction.dot(bitangent), direction.dot(normal))
}

/// The functions of a material.
pub struct LobeTable {
    /// [sizes, nodes of the outgoing angle, of the incoming one, of azimuth, functions by four].
    values: Vec<Vec4>,
    count: usize,
}

impl LobeTable {
    /// Of `functions` over `discs`.
    pub fn new(functions: &Functions, discs: &Discs) -> Self {
        let quads = functions.count().div_ceil(4);
        let rows = 0..SIZES * NODES * NODES;
        let row = |row: usize| {
            let (size, outgoing, node) = (row / (NODES * NODES), row / NODES % NODES, row % NODES);
            let outgoing = outgoing_at(outgoing);
            let (sin, cos) = angle_at(node as f32).sin_cos();
            let of_row = (0..AZIMUTHS).flat_map(|k| {
                let [along, across] = azimuth_at(k as f32 / (AZIMUTHS - 1) as f32);
                let centre = Vec3A::new(-sin * along, sin * across, cos);
                let means = mean(functions, discs.solid_angles[size], centre, outgoing);
                (0..quads).map(move |quad| Vec4::from_slice(&means[4 * quad..]))
            });
            of_row.collect::<Vec<_>>()
        };
        let rows: Vec<Vec<Vec4>> = rows.into_par_iter().map(row).collect();
        Self { values: rows.concat(), count: functions.count() }
    }

    /// Adds `share` of the light that is reflected from the `lit` texels of a vertex to `outgoing`, in its
    /// frame, to `planes`, [functions, `texels`].
    pub fn add(&self, outgoing: Vec3A, lit: &[Lit], share: f32, planes: &mut [f32], texels: usize) {
        if self.count <= 4 {
            self.add_quads::<1>(outgoing, lit, share, planes, texels);
        } else {
            self.add_quads::<2>(outgoing, lit, share, planes, texels);
        }
    }

    fn add_quads<const QUADS: usize>(
        &self,
        outgoing: Vec3A,
        lit: &[Lit],
        share: f32,
        planes: &mut [f32],
        texels: usize,
    ) {
        let (node, of_next) = locate(outgoing.z);
        let length = (outgoing.x * outgoing.x + outgoing.y * outgoing.y).sqrt().max(f32::MIN_POSITIVE);
        let mirrored = [-outgoing.x / length, -outgoing.y / length];
        let of_outgoing = [share * (1.0 - of_next), share * of_next];
        for lit in lit.chunks(CHUNK) {
            let mut places = [0.0; CHUNK];
            for (place, lit) in places.iter_mut().zip(lit) {
                *place = azimuth_place(lit.azimuth[0] * mirrored[0] + lit.azimuth[1] * mirrored[1]);
            }
            for (place, lit) in places.iter().zip(lit) {
                let azimuth = (*place as usize).min(AZIMUTHS - 2);
                let of_next = place - azimuth as f32;
                let of_azimuth = [1.0 - of_next, of_next];
                let first = (usize::from(lit.row) + node * NODES) * AZIMUTHS + azimuth;
                let mut sums = [Vec4::ZERO; QUADS];
                for (k, of_outgoing) in of_outgoing.into_iter().enumerate() {
                    for (j, of_incoming) in [1.0 - lit.share, lit.share].into_iter().enumerate() {
                        let at = QUADS * (first + (k * NODES + j) * AZIMUTHS);
                        let weight = of_outgoing * of_incoming * lit.arriving;
                        let both = &self.values[at..at + 2 * QUADS];
                        for quad in 0..QUADS {
                            let [a, b] = of_azimuth.map(|of| of * weight);
                            sums[quad] += both[quad] * a + both[QUADS + quad] * b;
                        }
                    }
                }
                for function in 0..self.count {
                    planes[function * texels + usize::from(lit.texel)] += sums[function / 4][function % 4];
                }
            }
        }
    }
}

/// Means over the disc of `solid_angle` around `centre`, weighted with the cosine.
fn mean(functions: &Functions, solid_angle: f64, centre: Vec3A, outgoing: Vec3A) -> [f32; MOST] {
    /// Turns from point to point: the golden section leaves no gaps.
    const TURN: f32 = 2.399_963_2;
    let height = (solid_angle / std::f64::consts::TAU) as f32;
    let (tangent, bitangent) = centre.any_orthonormal_pair();
    let (mut sums, mut total) = ([0.0; MOST], 0.0);
    for k in 0..POINTS {
        let lower = height * (k as f32 + 0.5) / POINTS as f32;
        let sin = (lower * (2.0 - lower)).sqrt();
        let (sin_phi, cos_phi) = (TURN * k as f32).sin_cos();
        let incoming = centre * (1.0 - lower) + (tangent * cos_phi + bitangent * sin_phi) * sin;
        if incoming.z > 0.0 {
            let values = functions.evaluate(&angles(incoming, outgoing, Vec3A::Z));
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += incoming.z * value);
            total += incoming.z;
        }
    }
    if total > 0.0 { sums.map(|sum| sum / total) } else { sums }
}

#[cfg(test)]
pub(super) mod tests;
