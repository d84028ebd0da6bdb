//! The screen without a window: the same drawing code in a plain egui context, fed with made-up input. Where
//! things are is read from the accessibility tree, so that tests name what they click on.
#![allow(dead_code, reason = "each test binary uses its own part")]

use egui::{Event, FullOutput, OutputCommand, PointerButton, Pos2, RawInput, Rect, Shape, Vec2, accesskit};
use relume_player::ui::run_in_turns;

/// A screen of some size.
pub struct Mirror {
    context: egui::Context,
    size: Vec2,
    time_s: f64,
    nodes: Vec<accesskit::Node>,
    /// Texts as drawn, with what can be seen of their rectangles.
    pub texts: Vec<(String, Rect)>,
    /// What was copied to the clipboard in the last frame.
    pub copied: Vec<String>,
    /// Whether egui asked to be drawn again at once.
    pub restless: bool,
}

impl Mirror {
    /// A screen of `size` points.
    pub fn new(size: [f32; 2]) -> Self {
        let context = egui::Context::default();
        context.enable_accesskit();
        Self {
            context,
            size: size.into(),
            time_s: 0.0,
            nodes: Vec::new(),
            texts: Vec::new(),
            copied: Vec::new(),
            restless: false,
        }
    }

    /// What it is drawn in.
    pub fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Gives it another size.
    pub fn resize(&mut self, size: [f32; 2]) {
        self.size = size.into();
    }

    /// Draws a frame with these events, some time after the last, as the window does.
    pub fn frame(&mut self, events: Vec<Event>, draw: impl FnMut(&mut egui::Ui)) {
        self.time_s += 0.05;
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, self.size));
        let input =
            RawInput { screen_rect, time: Some(self.time_s), events, focused: true, ..Default::default() };
        let output = run_in_turns(&self.context, input, draw);
        self.restless = output.viewport_output[&egui::ViewportId::ROOT].repaint_delay.is_zero();
        self.texts.clear();
        output
            .shapes
            .iter()
            .for_each(|clipped| find_texts(&clipped.shape, clipped.clip_rect, &mut self.texts));
        let FullOutput { platform_output, mut textures_delta, .. } = output;
        textures_delta.clear();
        let copied = |command| if let OutputCommand::CopyText(text) = command { Some(text) } else { None };
        self.copied = platform_output.commands.into_iter().filter_map(copied).collect();
        self.nodes =
            platform_output.accesskit_update.unwrap().nodes.into_iter().map(|(_, node)| node).collect();
    }

    /// Where the thing called `name` is, as last drawn; for a slider, its rail.
    #[track_caller]
    pub fn rect(&self, name: &str) -> Rect {
        let named =
            |node: &&accesskit::Node| node.label() == Some(name) && node.role() != accesskit::Role::Label;
        let node = self
            .nodes
            .iter()
            .find(named)
            .unwrap_or_else(|| panic!("nothing is called `{name}`: {:?}", self.names()));
        let bounds = node.bounds().unwrap();
        Rect::from_min_max(
            Pos2::new(bounds.x0 as f32, bounds.y0 as f32),
            Pos2::new(bounds.x1 as f32, bounds.y1 as f32),
        )
    }

    /// Whether the thing called `name` reacts to nothing.
    pub fn is_disabled(&self, name: &str) -> bool {
        self.nodes.iter().any(|node| node.label() == Some(name) && node.is_disabled())
    }

    /// All texts on the screen and all names of things.
    pub fn names(&self) -> Vec<&str> {
        self.nodes.iter().filter_map(|node| node.label().or(node.value())).collect()
    }
}

/// The texts of `shape`, as far as they are seen.
fn find_texts(shape: &Shape, clip: Rect, found: &mut Vec<(String, Rect)>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| find_texts(shape, clip, found)),
        Shape::Text(text) => {
            let seen = text.visual_bounding_rect().intersect(clip);
            if seen.is_positive() && !text.galley.text().trim().is_empty() {
                found.push((text.galley.text().to_owned(), seen));
            }
        }
        _ => {}
    }
}

/// The first half of a click.
pub fn press(at: Pos2) -> Vec<Event> {
    vec![Event::PointerMoved(at), button(at, true)]
}

/// The other half of a click.
pub fn release(at: Pos2) -> Vec<Event> {
    vec![Event::PointerMoved(at), button(at, false)]
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Default::default() }
}

/// A key pressed and released.
pub fn key(key: egui::Key) -> Vec<Event> {
    chord(egui::Modifiers::NONE, key)
}

/// A key pressed and released while others are held.
pub fn chord(modifiers: egui::Modifiers, key: egui::Key) -> Vec<Event> {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    vec![event(true), event(false)]
}

/// What the keyboard sends for `text`, in which a tab and a line break stand for their keys.
pub fn typed(text: &str) -> Vec<Event> {
    let strokes = |letter: char| match letter {
        '\t' => key(egui::Key::Tab),
        '\n' => key(egui::Key::Enter),
        letter => {
            let of_key = egui::Key::from_name(&letter.to_uppercase().to_string()).map(key);
            let mut events = of_key.unwrap_or_else(|| key(egui::Key::Minus));
            events.insert(1, Event::Text(letter.to_string()));
            events
        }
    };
    text.chars().flat_map(strokes).collect()
}
