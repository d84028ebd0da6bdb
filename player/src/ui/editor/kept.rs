//! What the user has set, taken along to another bake of the scene.

use super::{Editor, Part};
use relume_formats::Place;
use relume_formats::name::plain;
use relume_formats::state::{Animation, State};
use relume_playback::Look;
use std::collections::BTreeSet;

/// What the user has set.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The look without the animation, as what differs from the scene.
    pub state: State,
    held: BTreeSet<Part>,
    /// The chosen animation, where in it, and whether it plays.
    animation: Option<(Animation, f64, bool)>,
    selected: Option<String>,
    /// Whether all of it is in a file, or is what it began with.
    pub is_saved: bool,
}

impl Editor {
    /// What is set, to be set again by [`Editor::keep`].
    pub fn kept(&self) -> Kept {
        Kept {
            state: self.base.difference(&Look::default_of(self.scene())),
            held: self.held.clone(),
            animation: self.animation().map(|chosen| (chosen.clone(), self.time_s, self.playing)),
            selected: self.selected.clone(),
            is_saved: self.unsaved().is_none(),
        }
    }

    /// Sets what was set on another bake, as far as it fits this one, as one edit. Returns what does not fit,
    /// in words.
    pub fn keep(&mut self, kept: Kept) -> Vec<String> {
        let place = Place::file("edit");
        let mut lost: Vec<String> = pieces(&kept.state)
            .into_iter()
            .filter_map(|(words, piece)| self.take_state(&piece, &place).is_err().then_some(words))
            .collect();
        if let Some((animation, time_s, playing)) = kept.animation {
            match self.animations.iter().position(|other| other.name == animation.name) {
                Some(index) => self.choose(Some(index)),
                None => {
                    let words = format!("animation {}", plain(&animation.name));
                    lost.extend(self.take_animation(animation, &place).is_err().then_some(words));
                }
            }
            if self.animation().is_some() {
                self.scrub(time_s);
                self.playing = playing;
            }
        }
        self.held = kept.held.into_iter().filter(|part| self.concerns(part)).collect();
        self.select(kept.selected.as_deref());
        self.commit();
        if kept.is_saved && lost.is_empty() {
            self.mark_saved();
        }
        lost
    }
}

/// `state` cut into what is legal or not by itself, each with its words.
fn pieces(state: &State) -> Vec<(String, State)> {
    let all: Vec<Part> = Part::of(state).collect();
    let piece = |words: String| {
        let mut piece = state.clone();
        all.iter().filter(|part| part.words() != words).for_each(|part| part.take_from(&mut piece));
        (words, piece)
    };
    Part::words_of(&all).into_iter().map(piece).collect()
}
