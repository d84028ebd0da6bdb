//! From the files of a bundle to receivers.

use super::{Own, Receiver};
use crate::basis::diffuse::blend;
use crate::kinds::sphere_shadows::{Casts, NO_ROW};
use crate::kinds::{SphereSet, SphereShadows};
use glam::Vec3;

/// The receivers of a bundle whose vertices have unit `normals` and receive light at `places`, world space, as
/// [`Rims`](crate::shape::Rims) has them. `sets` are the sphere sets of the objects that cast by one, in the
/// order of the objects, which is that of [`Own::set`]. Lobes of rows that are not blended are the row alone.
pub fn receivers(
    shadows: &SphereShadows,
    sets: &[SphereSet],
    places: &[[f32; 3]],
    normals: &[[f32; 3]],
) -> Vec<Receiver> {
    let mut next_set = 0..;
    let mut owners: Vec<(u32, Option<Own>)> = Vec::with_capacity(places.len());
    for (number, object) in (0..).zip(&shadows.meta.objects) {
        let own = (object.casts == Casts::Spheres).then(|| next_set.next()).flatten();
        let clusters = own.and_then(|set: u32| sets.get(set as usize)).map(|set| &set.clusters);
        let of = |vertex: u32| Some(Own { set: own?, sphere: *clusters?.get(vertex as usize)? });
        owners.extend((0..object.vertices).map(|vertex| (number, of(vertex))));
    }
    let lobes = |row: u32, normal: Vec3| {
        if row == NO_ROW { blend(normal) } else { [(row, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)] }
    };
    let places = places.iter().zip(normals).map(|(place, normal)| (Vec3::from(*place), Vec3::from(*normal)));
    let vertices = places.zip(shadows.rows.iter().zip(owners));
    vertices
        .map(|((position, normal), (row, (object, own)))| Receiver {
            position,
            normal,
            lobes: lobes(*row, normal),
            object,
            own,
        })
        .collect()
}
