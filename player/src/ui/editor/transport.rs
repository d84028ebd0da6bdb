//! The animation: which one, where in it, and whether time passes.

use super::Editor;
use relume_formats::state::Animation;

impl Editor {
    /// All animations, in the order of their names.
    pub fn animations(&self) -> &[Animation] {
        &self.animations
    }

    /// The chosen animation.
    pub fn animation(&self) -> Option<&Animation> {
        self.animations.get(self.active?)
    }

    /// Index of the chosen animation.
    pub fn active(&self) -> Option<usize> {
        self.active
    }

    /// Chooses an animation and plays it from its start, or chooses none.
    pub fn choose(&mut self, index: Option<usize>) {
        self.active = index.filter(|index| *index < self.animations.len());
        self.time_s = 0.0;
        self.playing = false;
        self.play_or_pause();
    }

    /// Whether time passes.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// Pauses, or plays on. An animation that has ended starts again.
    pub fn play_or_pause(&mut self) {
        let Some(animation) = self.animation() else { return };
        let (duration_s, looping) = (f64::from(animation.duration_s), animation.looping);
        self.playing = !self.playing;
        if self.playing && !looping && self.time_s >= duration_s {
            self.time_s = 0.0;
        }
    }

    /// Where in the animation it stands, in seconds.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Goes to `time_s`, within the animation, and pauses there.
    pub fn scrub(&mut self, time_s: f64) {
        let Some(duration_s) = self.animation().map(|animation| f64::from(animation.duration_s)) else {
            return;
        };
        self.playing = false;
        if !time_s.is_nan() {
            self.time_s = time_s.clamp(0.0, duration_s);
        }
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f64) {
        let Some(animation) = self.animation().filter(|_| self.playing) else { return };
        let (duration_s, looping) = (f64::from(animation.duration_s), animation.looping);
        let time_s = self.time_s + seconds;
        self.playing = looping || time_s < duration_s;
        self.time_s = if looping { time_s.rem_euclid(duration_s) } else { time_s.min(duration_s) };
    }
}
