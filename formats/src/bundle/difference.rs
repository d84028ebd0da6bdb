//! What tells one look from another, as a change.

use super::{Brdfs, Look};
use crate::kinds::scene::EnvironmentLook;
use crate::state::{
    Camera, CameraState, EnvironmentState, MaterialState, Pose, Posed, ShapeState, State, ViewState,
};
use std::collections::{BTreeMap, BTreeSet};

impl Look {
    /// The change that makes this look of `from`, a look of the same scene, bit for bit: 0 and -0 differ. It
    /// names no leaf in which the two agree, but for materials and shapes that differ, which it names whole.
    pub fn difference(&self, from: &Self) -> State {
        State {
            environment: self
                .environment
                .as_ref()
                .zip(from.environment.as_ref())
                .and_then(|(now, was)| environment(now, was)),
            view: Some(self.tonemap)
                .filter(|now| *now != from.tonemap)
                .map(|tonemap| ViewState { tonemap: Some(tonemap) }),
            camera: camera(&self.camera, &from.camera),
            lights: BTreeMap::new(),
            materials: materials(&self.materials, &from.materials),
            shapes: shapes(&self.shapes, &from.shapes),
        }
    }
}

/// `now`, if a bit of it is not what it was.
fn number(now: f32, was: f32) -> Option<f32> {
    Some(now).filter(|now| now.to_bits() != was.to_bits())
}

fn triple(now: [f32; 3], was: [f32; 3]) -> Option<[f32; 3]> {
    Some(now).filter(|now| now.map(f32::to_bits) != was.map(f32::to_bits))
}

fn environment(now: &EnvironmentLook, was: &EnvironmentLook) -> Option<EnvironmentState> {
    let change = EnvironmentState {
        map: Some(&now.map).filter(|map| **map != was.map).cloned(),
        rotation_deg: number(now.rotation_deg, was.rotation_deg),
        gain: triple(now.gain, was.gain),
    };
    Some(change).filter(|change| *change != EnvironmentState::default())
}

fn camera(now: &Camera, was: &Camera) -> Option<CameraState> {
    let change = CameraState {
        position: triple(now.position, was.position),
        target: triple(now.target, was.target),
        fov_deg: number(now.fov_deg, was.fov_deg),
        exposure_ev: number(now.exposure_ev, was.exposure_ev),
    };
    Some(change).filter(|change| *change != CameraState::default())
}

fn materials(now: &Brdfs, was: &Brdfs) -> BTreeMap<String, MaterialState> {
    if now.revision() == was.revision() {
        return BTreeMap::new();
    }
    let pairs = now.iter().filter_map(|(name, brdf)| {
        Some((name, MaterialState::from(*brdf), MaterialState::from(*was.get(name)?)))
    });
    pairs
        .filter(|(_, now, was)| !same_material(now, was))
        .map(|(name, now, _)| (name.to_owned(), now))
        .collect()
}

fn same_material(a: &MaterialState, b: &MaterialState) -> bool {
    let bits = |state: &MaterialState| {
        let colours = [state.kd, state.ks, state.base_color]
            .map(|colour| colour.map(|colour| colour.map(f32::to_bits)));
        let numbers = [state.shininess, state.fresnel, state.metallic, state.roughness];
        let numbers = numbers.map(|number| number.map(f32::to_bits));
        (colours, numbers)
    };
    bits(a) == bits(b)
}

fn shapes(now: &BTreeMap<String, Posed>, was: &BTreeMap<String, Posed>) -> BTreeMap<String, ShapeState> {
    let names: BTreeSet<&String> = now.keys().chain(was.keys()).collect();
    let same = |a: Option<&Posed>, b: Option<&Posed>| {
        let bits = |posed: &Posed| (posed.clip.clone(), posed.time_s.to_bits());
        a.map(bits) == b.map(bits)
    };
    let changed = names.into_iter().filter(|name| !same(now.get(*name), was.get(*name)));
    changed.map(|name| (name.clone(), showing(now.get(name)))).collect()
}

/// The change after which a shape shows `posed`, whatever it showed before.
fn showing(posed: Option<&Posed>) -> ShapeState {
    match posed {
        Some(Posed { clip, time_s }) => {
            ShapeState { clip: Some(clip.clone()), time_s: Some(*time_s), pose: None }
        }
        None => ShapeState { pose: Some(Pose::Rest), ..ShapeState::default() },
    }
}
