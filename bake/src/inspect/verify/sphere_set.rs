//! What a sphere set promises besides being well-formed.

use relume_formats::kinds::{SphereSet, StoredScene};
use relume_formats::{Error, Place, Result};

/// How far outside its sphere a point may lie for roundings, in parts of the diagonal.
const TOLERANCE: f64 = 1e-5;
/// How far the end of the history may be from E/V(T): it is rounded to f32.
const HISTORY_TOLERANCE: f64 = 1e-6;

/// Every point lies in its sphere, as far as the set promises, and the history ends with what the set has,
/// unless it is one of poses too.
pub(super) fn verify(set: &SphereSet, place: &Place) -> Result<()> {
    let meta = &set.meta;
    let allowed = (f64::from(meta.tight) + TOLERANCE) * f64::from(meta.diagonal);
    for (at, (point, cluster)) in set.points.iter().zip(&set.clusters).enumerate() {
        let outside = set.spheres.get(*cluster as usize).map_or(f64::INFINITY, |sphere| outside(point, sphere));
        if outside > allowed {
            let reason = format!("point {at} is {outside} outside its sphere {cluster}, {allowed} is allowed; fit the mesh again");
            return Err(Error::invalid(&place.part("section `spheres`"), reason));
        }
    }
    let (last, has) = (set.history.last().map_or(f64::NAN, |e| f64::from(*e)), meta.relative_outside_volume());
    if meta.poses > 0 || (last - has).abs() <= HISTORY_TOLERANCE * (1.0 + has) {
        return Ok(());
    }
    Err(Error::invalid(&place.part("section `history`"), format!("ends with E/V(T) = {last}, but the set has {has}; fit the mesh again")))
}

/// What [`verify`] does, and that the set is of the object that the manifest says, as it stands in the scene.
pub(super) fn verify_object(set: &SphereSet, object: &str, scene: &StoredScene, place: &Place) -> Result<()> {
    verify(set, place)?;
    let refuse = |reason: String| Err(Error::invalid(place, format!("{reason}; bake it again")));
    if set.meta.mesh != object {
        return refuse(format!("holds the spheres of `{}`, the manifest lists `{object}`", set.meta.mesh));
    }
    let vertices = set.points.get(..set.meta.vertices as usize).unwrap_or_default();
    match vertices_of(scene, object) {
        Some(positions) if positions == vertices => Ok(()),
        Some(_) => refuse(format!("its vertices are not those of object `{object}` in the scene")),
        None => refuse(format!("object `{object}` is not in the scene")),
    }
}

/// The positions of an object's vertices. Objects follow each other in the scene, and use all of their vertices.
fn vertices_of<'a>(scene: &'a StoredScene, object: &str) -> Option<&'a [[f32; 3]]> {
    let index = scene.meta.objects.iter().position(|o| o.name == object)?;
    let (before, here) = scene.meta.objects.split_at(index);
    let first: usize = before.iter().map(|o| o.triangles as usize).sum();
    let indices = scene.triangles.get(first..first + here.first()?.triangles as usize)?.as_flattened();
    scene.positions.get(*indices.iter().min()? as usize..=*indices.iter().max()? as usize)
}

/// How far `point` lies outside the sphere; negative inside.
fn outside(point: &[f32; 3], [x, y, z, radius]: &[f32; 4]) -> f64 {
    let squares = point.iter().zip([x, y, z]).map(|(p, c)| (f64::from(*p) - f64::from(*c)).powi(2));
    squares.sum::<f64>().sqrt() - f64::from(*radius)
}
