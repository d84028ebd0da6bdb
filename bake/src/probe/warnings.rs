//! What a look at a scene finds wrong.

use super::Probe;
use crate::darkness;
use crate::trace::world::{Meeting, Owner};
use glam::Vec3A;
use relume_formats::Place;
use std::collections::BTreeMap;

/// Narrowest vertical field of view that anybody means, degrees; below, radians were meant.
const NARROW_DEG: f32 = 5.0;
/// Of what the camera sees, so much may be backs of surfaces.
const BACKS: f64 = 0.5;
/// Of the picture, so much should be surfaces.
const SURFACES: f64 = 0.005;
/// Steps that grey surfaces may be too bright or too dark by.
const STEPS: f32 = 4.0;
/// Most triangles of a material that are sought one by one.
const SOUGHT: usize = 4096;

/// What is wrong, a sentence each with the scene's file.
pub(super) fn of(probe: &Probe<'_>) -> Vec<String> {
    let file = Place::file(&probe.scene.file);
    let found = [narrow(probe), little(probe), backs(probe), black(probe), exposure(probe)];
    let all = found.into_iter().flatten().chain(hidden(probe));
    all.map(|sentence| format!("{file}: {sentence}")).collect()
}

fn narrow(probe: &Probe<'_>) -> Option<String> {
    let given = probe.scene.camera.fov_deg;
    let meant = given.to_degrees();
    let remedy = if meant <= 170.0 {
        format!("if that is in radians, write {meant:.1}")
    } else {
        "20 to 60 is usual".to_owned()
    };
    (given < NARROW_DEG).then(|| format!("[camera] fov_deg {given} is a very narrow view; {remedy}"))
}

fn little(probe: &Probe<'_>) -> Option<String> {
    let share = probe.meetings.iter().flatten().count() as f64 / probe.meetings.len().max(1) as f64;
    if share == 0.0 && !(0..probe.scene.materials.len()).any(|material| is_found(probe, material)) {
        return Some(
            "the camera sees no surface; check its position and target, and the size and place of objects"
                .to_owned(),
        );
    }
    let reason = "of the picture shows a surface; move the camera nearer, lower fov_deg, or give the model's transform another scale";
    let much =
        if share == 0.0 { "hardly anything".to_owned() } else { format!("only {:.1} %", 100.0 * share) };
    (share < SURFACES).then(|| format!("{much} {reason}"))
}

fn backs(probe: &Probe<'_>) -> Option<String> {
    let surfaces: Vec<&Meeting> =
        probe.meetings.iter().flatten().filter(|met| matches!(met.owner, Owner::Material(_))).collect();
    let mut objects: BTreeMap<usize, usize> = BTreeMap::new();
    for met in surfaces.iter().filter(|met| !met.front) {
        *objects.entry(object_of(probe, met.triangle)).or_default() += 1;
    }
    let share = objects.values().sum::<usize>() as f64 / surfaces.len().max(1) as f64;
    let most = objects
        .into_iter()
        .max_by_key(|(_, count)| *count)
        .and_then(|(object, _)| probe.scene.objects.get(object))?;
    let remedy = "move the camera if it is inside or below that, else turn the object's faces round";
    (share >= BACKS).then(|| {
        format!(
            "{:.0} % of the surfaces in view are seen from behind, most of them of object `{}`; {remedy}",
            100.0 * share,
            most.name
        )
    })
}

/// The object that a triangle belongs to; triangles are counted over all objects.
fn object_of(probe: &Probe<'_>, triangle: u32) -> usize {
    let ends = probe.scene.objects.iter().scan(0, |end, object| {
        *end += object.mesh.triangles.len();
        Some(*end)
    });
    ends.take_while(|end| *end <= triangle as usize).count()
}

fn is_black(probe: &Probe<'_>) -> bool {
    probe.grey.as_flattened().iter().all(|radiance| *radiance == 0.0)
}

/// Of a picture without surfaces something else is said.
fn black(probe: &Probe<'_>) -> Option<String> {
    let shows_any = probe.meetings.iter().any(Option::is_some);
    (shows_any && is_black(probe)).then(|| darkness::WARNING.to_owned())
}

/// Grey surfaces that are white or black on the display.
fn exposure(probe: &Probe<'_>) -> Option<String> {
    let ev = probe.scene.camera.exposure_ev;
    let wanted = probe.wanted_ev()?;
    let off = ev - wanted;
    let (much, why) = match off {
        off if off > STEPS => ("bright", "lamps of a file may be in photometric units, 683 times too bright"),
        off if off < -STEPS => ("dark", "lamps may be too weak or too far away"),
        _ => return None,
    };
    // Not −0, which would be written so.
    let remedy = format!("set [camera] exposure_ev to about {:.0}", wanted.clamp(-32.0, 32.0).round() + 0.0);
    Some(format!(
        "the picture is far too {much}, by {:.0} steps of exposure; {remedy}, or mend the light: {why}",
        off.abs()
    ))
}

/// Materials that vary and are not in view, where the view stays.
fn hidden(probe: &Probe<'_>) -> Vec<String> {
    let (scene, seen) = (probe.scene, probe.seen());
    let names = scene.vary.materials.iter().filter_map(|index| Some((*index, scene.materials.get(*index)?)));
    let unseen = names.filter(|(index, material)| {
        let is_worn = scene.objects.iter().any(|object| object.material == *index);
        let is_seen = seen.iter().any(|(name, _)| *name == material.name);
        is_worn && !is_seen && !is_found(probe, *index)
    });
    let told = unseen.map(|(_, material)| {
        let remedy = "move the camera, or leave it out of [vary]";
        format!("material `{}` varies, but nothing that wears it is in view; {remedy}", material.name)
    });
    if scene.vary.view { Vec::new() } else { told.collect() }
}

/// Whether the middle of a triangle that wears material `index` is in view: what is small falls between the
/// pixels of the picture.
fn is_found(probe: &Probe<'_>, index: usize) -> bool {
    let worn = probe.scene.objects.iter().filter(|object| object.material == index);
    let middles = worn.flat_map(|object| {
        let corner = |i: u32| object.mesh.positions.get(i as usize).map_or(Vec3A::NAN, |p| Vec3A::from(*p));
        let middle = move |triangle: &[u32; 3]| triangle.iter().map(|i| corner(*i)).sum::<Vec3A>() / 3.0;
        let step = object.mesh.triangles.len().div_ceil(SOUGHT).max(1);
        object.mesh.triangles.iter().step_by(step).map(middle)
    });
    middles.take(SOUGHT).any(|point| is_seen(probe, point, index))
}

/// Whether the camera sees material `index` where it looks at `point`.
fn is_seen(probe: &Probe<'_>, point: Vec3A, index: usize) -> bool {
    let [forward, right, up] = probe.film.axes();
    let way = point - probe.film.eye_in_world;
    let depth = way.dot(forward);
    let on_film = |axis: Vec3A| (way.dot(axis) / (depth * axis.length_squared())).abs() <= 1.0;
    let is_in_frame = depth > 0.0 && on_film(right) && on_film(up);
    let direction = way.normalize_or_zero();
    let met = if is_in_frame { probe.world.meet(probe.film.eye_in_world, direction) } else { None };
    met.is_some_and(|met| met.owner == Owner::Material(index as u32))
}
