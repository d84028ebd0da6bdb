//! The settings as a state, for `player --state`.

use super::Editor;
use relume_formats::kinds::scene::{EnvironmentLook, StoredMaterial};
use relume_formats::state::{Camera, CameraState, EnvironmentState, MaterialState, Posed, ShapeState, State, ViewState};

impl Editor {
    /// The look as a state: what differs from the scene.
    pub fn state(&self) -> State {
        let look = self.look();
        let differs = |material: &&StoredMaterial| look.materials.get(&material.name).is_some_and(|brdf| *brdf != material.brdf);
        let named = |material: &StoredMaterial| Some((material.name.clone(), MaterialState::from(*look.materials.get(&material.name)?)));
        State {
            environment: look.environment.as_ref().zip(self.scene().environment.as_ref()).and_then(|(now, was)| light_change(now, was)),
            view: changed(look.tonemap, &self.scene().tonemap).map(|tonemap| ViewState { tonemap: Some(tonemap) }),
            camera: camera_change(&look.camera, &self.scene().camera),
            materials: self.materials().filter(differs).filter_map(named).collect(),
            shapes: look.shapes.into_iter().map(|(name, posed)| (name, shape_state(posed))).collect(),
            ..State::default()
        }
    }
}

/// `now`, if it is not what it was.
fn changed<T: PartialEq>(now: T, was: &T) -> Option<T> {
    Some(now).filter(|now| now != was)
}

fn light_change(now: &EnvironmentLook, was: &EnvironmentLook) -> Option<EnvironmentState> {
    let change = EnvironmentState {
        map: changed(now.map.clone(), &was.map),
        rotation_deg: changed(now.rotation_deg, &was.rotation_deg),
        gain: changed(now.gain, &was.gain),
    };
    changed(change, &EnvironmentState::default())
}

/// The state in which a shape at rest shows `posed`.
fn shape_state(posed: Posed) -> ShapeState {
    ShapeState { clip: Some(posed.clip), time_s: Some(posed.time_s), ..ShapeState::default() }
}

fn camera_change(now: &Camera, was: &Camera) -> Option<CameraState> {
    let change = CameraState {
        position: changed(now.position, &was.position),
        target: changed(now.target, &was.target),
        fov_deg: changed(now.fov_deg, &was.fov_deg),
        exposure_ev: changed(now.exposure_ev, &was.exposure_ev),
    };
    changed(change, &CameraState::default())
}
