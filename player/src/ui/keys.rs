//! What the keys and the mouse do: one table, by which keys are obeyed, the line below the picture gives hints,
//! and the help tells all.

use egui::{Key, Modifiers, Ui};

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Does {
    Png,
    Exr,
    State,
    Open,
    Reload,
    Play,
    Undo,
    Redo,
    /// Told by the system as such, as is [`Does::Paste`].
    Copy,
    Paste,
    ResetView,
    /// Obeyed by egui, as are the next two.
    Larger,
    Smaller,
    Unscaled,
    Help,
    /// Obeyed by what is under way or open.
    Cancel,
    Close,
}

/// Part of the help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    Picture,
    Edits,
    Files,
    Window,
}

/// Keys that do the same.
pub struct Entry {
    pub does: Does,
    pub group: Group,
    /// As the user calls them.
    pub keys: &'static [&'static str],
    /// What they do, for the help.
    pub words: &'static str,
    /// What they do, for the line below the picture, if they are told there.
    pub hint: Option<&'static str>,
    chords: &'static [(Modifiers, Key)],
}

/// Something done with the mouse.
pub struct Gesture {
    pub group: Group,
    pub how: &'static str,
    pub words: &'static str,
    /// Whether it takes a camera that moves; those that do are told below the picture, too.
    pub moves: bool,
}

impl Group {
    /// All of them, in the order of the help.
    pub const ALL: [Self; 4] = [Self::Picture, Self::Edits, Self::Files, Self::Window];

    /// Its heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Picture => "PICTURE",
            Self::Edits => "EDITS",
            Self::Files => "FILES",
            Self::Window => "WINDOW",
        }
    }
}

const fn entry(
    does: Does,
    group: Group,
    keys: &'static [&'static str],
    words: &'static str,
    chords: &'static [(Modifiers, Key)],
) -> Entry {
    Entry { does, group, keys, words, hint: None, chords }
}

impl Entry {
    const fn hint(self, hint: &'static str) -> Self {
        Self { hint: Some(hint), ..self }
    }

    /// Each of them with what is held meanwhile.
    pub fn chords(&self) -> &'static [(Modifiers, Key)] {
        self.chords
    }
}

const PLAIN: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT_CTRL: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// All keys.
pub const TABLE: [Entry; 17] = {
    use Does::*;
    use Group::*;
    [
        entry(ResetView, Picture, &["V"], "reset the view", &[(PLAIN, Key::V)]).hint("reset view"),
        entry(Png, Files, &["S"], "save the picture as PNG", &[(PLAIN, Key::S)]).hint("PNG"),
        entry(Exr, Files, &["E"], "save the picture as EXR, linear radiance", &[(PLAIN, Key::E)]).hint("EXR"),
        entry(State, Files, &["T"], "save the edits as a state", &[(PLAIN, Key::T)]).hint("state"),
        entry(Open, Files, &["Ctrl+O"], "open a bundle, a state, an animation or a map", &[(CTRL, Key::O)]),
        entry(Reload, Files, &["F5"], "show the bundle as it is on disk now", &[(PLAIN, Key::F5)]),
        entry(Play, Picture, &["Space"], "play or pause the animation", &[(PLAIN, Key::Space)])
            .hint("play / pause"),
        entry(Undo, Edits, &["Ctrl+Z"], "undo", &[(CTRL, Key::Z)]).hint("undo"),
        entry(Redo, Edits, &["Shift+Ctrl+Z", "Ctrl+Y"], "do again", &[(SHIFT_CTRL, Key::Z), (CTRL, Key::Y)]),
        entry(Copy, Edits, &["Ctrl+C"], "copy the selected material as text", &[(CTRL, Key::C)]),
        entry(Paste, Edits, &["Ctrl+V"], "paste a material on it, or a state", &[(CTRL, Key::V)]),
        entry(Cancel, Edits, &["Esc"], "call off a drag, or what is being typed", &[(PLAIN, Key::Escape)])
            .hint("cancel"),
        entry(Larger, Window, &["Ctrl+plus"], "larger letters", &[(CTRL, Key::Plus), (CTRL, Key::Equals)]),
        entry(Smaller, Window, &["Ctrl+minus"], "smaller letters", &[(CTRL, Key::Minus)]),
        entry(Unscaled, Window, &["Ctrl+0"], "letters as they were", &[(CTRL, Key::Num0)]),
        entry(Help, Window, &["F1", "?"], "this help", &[(PLAIN, Key::F1), (PLAIN, Key::Questionmark)])
            .hint("help"),
        entry(Close, Window, &["Q"], "close the window", &[(PLAIN, Key::Q)]).hint("close"),
    ]
};

/// All that is done with the mouse.
pub const GESTURES: [Gesture; 7] = [
    Gesture { group: Group::Picture, how: "click", words: "select the material", moves: false },
    Gesture { group: Group::Picture, how: "drag", words: "orbit", moves: true },
    Gesture { group: Group::Picture, how: "right drag", words: "pan", moves: true },
    Gesture { group: Group::Picture, how: "wheel", words: "closer, farther", moves: true },
    Gesture {
        group: Group::Edits,
        how: "drag a number",
        words: "change it; Shift makes it slow",
        moves: false,
    },
    Gesture {
        group: Group::Edits,
        how: "click a number",
        words: "type it; Tab goes to the next",
        moves: false,
    },
    Gesture { group: Group::Files, how: "drop a file", words: "open it", moves: false },
];

/// Whether the keys that do this were pressed; they are used up then.
pub fn pressed(ui: &Ui, does: Does) -> bool {
    let chords = TABLE.iter().filter(|entry| entry.does == does).flat_map(Entry::chords);
    // All of them: what is pressed twice is obeyed once.
    chords
        .fold(false, |any, (modifiers, key)| ui.input_mut(|input| input.consume_key(*modifiers, *key)) | any)
}
