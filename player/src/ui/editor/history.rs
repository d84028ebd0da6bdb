//! Undo and redo. An edit is over when the hand lets go; what has changed since the last one is then a step,
//! kept as the change that leads back, so that undoing everything leads to the start, bit for bit. That time
//! passes or stands still is no edit.

use super::{Editor, Part, apply};
use relume_formats::state::State;
use relume_playback::Look;
use std::collections::{BTreeSet, VecDeque};

/// Steps that are kept, some hundred bytes each; older ones are forgotten.
const MOST_STEPS: usize = 10_000;

/// What edits change.
#[derive(Debug, Clone, PartialEq)]
struct Edits {
    base: Look,
    held: BTreeSet<Part>,
    active: Option<usize>,
}

/// A way from some edits to others.
#[derive(Debug, Clone, PartialEq)]
struct Step {
    /// What changes of the look without the animation.
    change: State,
    /// What is held after it.
    held: BTreeSet<Part>,
    /// The animation chosen after it.
    active: Option<usize>,
    /// What it is about, in words, and how many parts that are.
    about: String,
    parts: usize,
}

/// What has been done.
#[derive(Debug, Clone)]
pub(super) struct History {
    /// After the last step.
    now: Edits,
    /// At the start.
    start: Edits,
    /// As last saved, or at the start.
    saved: Edits,
    /// Steps that lead back, the last first to be taken.
    back: VecDeque<Step>,
    /// Steps that lead on again.
    forth: Vec<Step>,
}

impl History {
    pub(super) fn new(base: &Look, active: Option<usize>) -> Self {
        let start = Edits { base: base.clone(), held: BTreeSet::new(), active };
        Self { now: start.clone(), saved: start.clone(), start, back: VecDeque::new(), forth: Vec::new() }
    }

    /// The look at the start, without the animation.
    pub(super) fn start(&self) -> &Look {
        &self.start.base
    }
}

impl Step {
    /// The way from `from` to `to`.
    fn between(from: &Edits, to: &Edits) -> Self {
        let change = to.base.difference(&from.base);
        let mut parts: BTreeSet<Part> = Part::of(&change).collect();
        parts.extend(from.held.symmetric_difference(&to.held).cloned());
        let mut about = Part::words_of(&parts);
        about.extend((from.active != to.active).then(|| "the animation".to_owned()));
        let parts = about.len();
        if let [first, .., _] = &about[..]
            && about.len() > 3
        {
            about = vec![first.clone(), format!("{} others", about.len() - 1)];
        }
        Self { change, held: to.held.clone(), active: to.active, about: about.join(", "), parts }
    }

    fn changes_nothing_of(&self, from: &Edits) -> bool {
        self.change == State::default() && self.held == from.held && self.active == from.active
    }
}

impl Editor {
    fn edits(&self) -> Edits {
        Edits { base: self.base.clone(), held: self.held.clone(), active: self.active }
    }

    /// Makes a step of what has changed since the last, if anything has.
    pub fn commit(&mut self) {
        let edits = self.edits();
        let back = Step::between(&edits, &self.history.now);
        if back.changes_nothing_of(&edits) {
            return;
        }
        if self.history.back.len() == MOST_STEPS {
            self.history.back.pop_front();
        }
        self.history.back.push_back(back);
        self.history.forth.clear();
        self.history.now = edits;
    }

    /// Undoes the last step. Returns what it was about, if there was one.
    pub fn undo(&mut self) -> Option<String> {
        self.commit();
        let back = self.history.back.pop_back()?;
        let (forth, about) = self.take(back);
        self.history.forth.push(forth);
        Some(about)
    }

    /// Does again what was undone last. Returns what it was about, if there was anything.
    pub fn redo(&mut self) -> Option<String> {
        self.commit();
        let forth = self.history.forth.pop()?;
        let (back, about) = self.take(forth);
        self.history.back.push_back(back);
        Some(about)
    }

    /// Takes `step`; returns the one that leads back, and what it was about.
    fn take(&mut self, step: Step) -> (Step, String) {
        let before = self.edits();
        apply(&mut self.base, &step.change, &self.scope);
        self.held = step.held;
        if self.active != step.active {
            (self.active, self.playing, self.time_s) = (step.active, false, 0.0);
        }
        self.history.now = self.edits();
        (Step::between(&self.history.now, &before), step.about)
    }

    /// What the next undo is about, if there is anything to undo.
    pub fn undoes(&self) -> Option<&str> {
        self.history.back.back().map(|step| step.about.as_str())
    }

    /// What the next redo is about, if there is anything to do again.
    pub fn redoes(&self) -> Option<&str> {
        self.history.forth.last().map(|step| step.about.as_str())
    }

    /// Makes a change that is part of the start, and no edit.
    pub(super) fn start_from(&mut self, change: &State) {
        let History { now, start, saved, .. } = &mut self.history;
        for look in [&mut self.base, &mut now.base, &mut start.base, &mut saved.base] {
            apply(look, change, &self.scope);
        }
    }

    /// Notes that the edits are saved.
    pub fn mark_saved(&mut self) {
        self.history.saved = self.edits();
    }

    /// What the edits are about that would be lost if the program ended now, since they were last saved or since
    /// the start, whichever is nearer; `None` if there are none.
    pub fn unsaved(&self) -> Option<String> {
        let edits = self.edits();
        let since = |known: &Edits| {
            // A state file holds no animation.
            let known = Edits { active: edits.active, ..known.clone() };
            let step = Step::between(&known, &edits);
            (!step.changes_nothing_of(&known)).then_some(step)
        };
        let (saved, start) = (since(&self.history.saved)?, since(&self.history.start)?);
        Some(if start.parts < saved.parts { start } else { saved }.about)
    }
}
