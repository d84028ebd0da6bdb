//! The caps of spheres in the bitmaps of a group of receivers.

use super::{LANES, Lanes};
use crate::basis::cap::{FaceCone, ROW, ROWS, may_reach, row_range, tangent2};
use crate::basis::cubemap::FRAMES;
use crate::basis::two_level::SIDE;
use crate::evaluate::sphere_shadows::{Receiver, Spheres};

/// Bitmaps of a group, row by row.
pub(super) type Rows = [Lanes<u32>; ROWS];

/// Positions and normals of a group, coordinate by coordinate. A group that is not full repeats its last
/// receiver.
pub(super) struct Group {
    pub(super) position: [Lanes<f32>; 3],
    pub(super) normal: [Lanes<f32>; 3],
    pub(super) object: Lanes<u32>,
}

impl Group {
    #[inline(always)]
    pub(super) fn new(receivers: &[Receiver]) -> Self {
        let mut group = Self { position: [[0.0; LANES]; 3], normal: [[0.0; LANES]; 3], object: [0; LANES] };
        for lane in 0..LANES {
            let receiver = &receivers[lane.min(receivers.len() - 1)];
            group.object[lane] = receiver.object;
            for k in 0..3 {
                (group.position[k][lane], group.normal[k][lane]) = (receiver.position[k], receiver.normal[k]);
            }
        }
        group
    }
}

/// The receivers, a bit each, that leave out spheres of a set.
struct LeftOut {
    /// Those whose own set it is.
    own: u32,
    /// Those near whose own sphere each sphere is; empty if it is nobody's set.
    near: Vec<u32>,
}

impl LeftOut {
    fn new(receivers: &[Receiver], set: usize, spheres: &Spheres) -> Self {
        let mut found = Self { own: 0, near: Vec::new() };
        for (lane, receiver) in receivers.iter().enumerate() {
            let Some(own) = receiver.own.filter(|own| own.set as usize == set) else { continue };
            found.near.resize(spheres.now.len(), 0);
            found.own |= 1 << lane;
            let near = spheres.neighbours.get(own.sphere as usize);
            near.into_iter().flatten().for_each(|sphere| found.near[*sphere as usize] |= 1 << lane);
        }
        found
    }
}

/// Adds what spheres block of each receiver's view.
#[inline(always)]
pub(super) fn add(rows: &mut Rows, group: &Group, receivers: &[Receiver], sets: &[Spheres]) {
    for (set, spheres) in sets.iter().enumerate() {
        let left_out = LeftOut::new(receivers, set, spheres);
        for (sphere, placed) in spheres.now.iter().enumerate() {
            let near = left_out.near.get(sphere).copied().unwrap_or(0);
            add_sphere(rows, group, placed, near, left_out.own);
        }
    }
}

/// Adds a sphere that the receivers `near` leave out, and those of `own` that it holds.
#[inline(always)]
fn add_sphere(rows: &mut Rows, group: &Group, [x, y, z, radius]: &[f32; 4], near: u32, own: u32) {
    let mut offset = [[0.0; LANES]; 3];
    let (mut c2, mut cap, mut inside) = ([0.0; LANES], [0; LANES], [0; LANES]);
    let (mut any_cap, mut any_inside) = (0, 0);
    for lane in 0..LANES {
        let o = [x - group.position[0][lane], y - group.position[1][lane], z - group.position[2][lane]];
        let n = [group.normal[0][lane], group.normal[1][lane], group.normal[2][lane]];
        c2[lane] = tangent2(o, *radius);
        (offset[0][lane], offset[1][lane], offset[2][lane]) = (o[0], o[1], o[2]);
        let faces = all_if(n[0] * o[0] + n[1] * o[1] + n[2] * o[2] > -radius);
        let outside = all_if(c2[lane] > 0.0);
        let (near, own) = (all_if((near >> lane) & 1 == 1), all_if((own >> lane) & 1 == 1));
        cap[lane] = faces & outside & !near;
        inside[lane] = faces & !outside & !near & !own;
        any_cap |= cap[lane];
        any_inside |= inside[lane];
    }
    if any_inside != 0 {
        for row in rows.iter_mut() {
            for lane in 0..LANES {
                row[lane] |= inside[lane];
            }
        }
    }
    if any_cap != 0 {
        for (rows, frame) in rows.as_chunks_mut::<SIDE>().0.iter_mut().zip(&FRAMES) {
            add_to_face(rows, frame, &offset, *radius, &c2, &cap);
        }
    }
}

/// Adds the caps of the lanes that are all ones in `cap` to the rows of one face with the given frame.
#[inline(always)]
fn add_to_face(
    rows: &mut [Lanes<u32>; SIDE],
    frame: &[(usize, f32); 3],
    offset: &[Lanes<f32>; 3],
    radius: f32,
    c2: &Lanes<f32>,
    cap: &Lanes<u32>,
) {
    let (mut a, mut b, mut g) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let mut reached = [0; LANES];
    let mut any = 0;
    let [s, t, n] = frame;
    for lane in 0..LANES {
        a[lane] = s.1 * offset[s.0][lane];
        b[lane] = t.1 * offset[t.0][lane];
        g[lane] = n.1 * offset[n.0][lane];
        reached[lane] = cap[lane] & all_if(may_reach([a[lane], b[lane], g[lane]], radius));
        any |= reached[lane];
    }
    if any == 0 {
        return;
    }
    let (mut first, mut end) = (SIDE as u32, 0);
    let (mut c, mut q, mut one_over_q) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let [from, to] = row_range([a[lane], b[lane], g[lane]], radius, c2[lane]);
        first = first.min(if reached[lane] != 0 { from } else { SIDE as u32 });
        end = end.max(if reached[lane] != 0 { to } else { 0 });
        let cone = FaceCone::new([a[lane], b[lane], g[lane]], c2[lane]);
        (c[lane], q[lane], one_over_q[lane]) = (cone.c, cone.q, cone.one_over_q);
    }
    for y in first as usize..end as usize {
        let (row, place) = (&mut rows[y], &ROW[y]);
        for lane in 0..LANES {
            let cone = FaceCone {
                a: a[lane],
                b: b[lane],
                g: g[lane],
                c: c[lane],
                c2: c2[lane],
                q: q[lane],
                one_over_q: one_over_q[lane],
            };
            row[lane] |= cone.span(place) & reached[lane];
        }
    }
}

/// All bits or none.
#[inline(always)]
pub(super) fn all_if(condition: bool) -> u32 {
    if condition { u32::MAX } else { 0 }
}
