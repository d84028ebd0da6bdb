//! How the display shows the picture: exposure, by value or from the picture, and the curve.

use super::{Editor, Part};
use relume_formats::display::Tonemap;
use relume_formats::state::{CameraState, MAX_EXPOSURE_EV, State, ViewState};
use std::ops::RangeInclusive;

/// How far from the scene's exposure the slider reaches, either way, in EV.
const EXPOSURE_REACH_EV: f32 = 10.0;

/// When the picture is to be measured for its exposure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metering {
    /// As it is: the user asks for it.
    Now,
    /// Once it is whole: the player was started so.
    WhenWhole,
}

impl Editor {
    /// Sets the exposure.
    pub fn set_exposure(&mut self, ev: f32) {
        if !ev.is_nan() {
            self.metering = None;
            self.set(&exposed(ev.clamp(-MAX_EXPOSURE_EV, MAX_EXPOSURE_EV)));
        }
    }

    /// The exposures to offer.
    pub fn exposure_range(&self) -> RangeInclusive<f32> {
        let middle = self.scene().camera.exposure_ev;
        (middle - EXPOSURE_REACH_EV).max(-MAX_EXPOSURE_EV)..=(middle + EXPOSURE_REACH_EV).min(MAX_EXPOSURE_EV)
    }

    /// Gives the exposure back its value from the scene, and to the animation if there is one.
    pub fn reset_exposure(&mut self) {
        self.metering = None;
        self.give_back(&exposed(self.scene().camera.exposure_ev), &[Part::Exposure]);
    }

    /// Asks that the exposure be set by the picture.
    pub fn meter(&mut self, when: Metering) {
        self.metering = Some(when);
    }

    /// What was asked for by [`Editor::meter`] and is still to be answered.
    pub fn metering(&self) -> Option<Metering> {
        self.metering
    }

    /// Answers [`Editor::meter`]: `ev` is the exposure of the picture, if it has any light.
    pub fn metered(&mut self, ev: Option<f32>) {
        match (self.metering.take(), ev) {
            (Some(Metering::Now), Some(ev)) => self.set_exposure(ev),
            // What the player was started with lies below an animation, as a state does.
            (Some(Metering::WhenWhole), Some(ev)) => self.start_from(&exposed(ev)),
            _ => {}
        }
    }

    /// Sets the curve.
    pub fn set_tonemap(&mut self, tonemap: Tonemap) {
        self.set(&curved(tonemap));
    }

    /// Gives the curve back its value from the scene, and to the animation if there is one.
    pub fn reset_tonemap(&mut self) {
        self.give_back(&curved(self.scene().tonemap), &[Part::Tonemap]);
    }
}

fn exposed(ev: f32) -> State {
    State {
        camera: Some(CameraState { exposure_ev: Some(ev), ..CameraState::default() }),
        ..State::default()
    }
}

fn curved(tonemap: Tonemap) -> State {
    State { view: Some(ViewState { tonemap: Some(tonemap) }), ..State::default() }
}
