//! The screen without a window: the same drawing code in a plain egui context, fed with made-up input. Where things are is read from the
//! accessibility tree, so that tests name what they click on.
#![allow(dead_code, reason = "each test binary uses its own part")]

use egui::{Event, PointerButton, Pos2, RawInput, Rect, Vec2, accesskit};

/// A screen of some size.
pub struct Mirror {
    context: egui::Context,
    size: Vec2,
    time_s: f64,
    nodes: Vec<accesskit::Node>,
    /// Whether egui asked to be drawn again at once.
    pub restless: bool,
}

impl Mirror {
    /// A screen of `size` points.
    pub fn new(size: [f32; 2]) -> Self {
        let context = egui::Context::default();
        context.enable_accesskit();
        Self { context, size: size.into(), time_s: 0.0, nodes: Vec::new(), restless: false }
    }

    /// What it is drawn in.
    pub fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Draws a frame with these events, some time after the last.
    pub fn frame(&mut self, events: Vec<Event>, mut draw: impl FnMut(&mut egui::Ui)) {
        self.time_s += 0.05;
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, self.size));
        let input = RawInput { screen_rect, time: Some(self.time_s), events, focused: true, ..Default::default() };
        let output = self.context.run_ui(input, |ui| draw(ui));
        let update = output.platform_output.accesskit_update.unwrap();
        self.nodes = update.nodes.into_iter().map(|(_, node)| node).collect();
        self.restless = output.viewport_output[&egui::ViewportId::ROOT].repaint_delay.is_zero();
    }

    /// Where the thing called `name` is, as last drawn; for a slider, its rail.
    #[track_caller]
    pub fn rect(&self, name: &str) -> Rect {
        let named = |node: &&accesskit::Node| node.label() == Some(name) && node.role() != accesskit::Role::Label;
        let node = self.nodes.iter().find(named).unwrap_or_else(|| panic!("nothing is called `{name}`: {:?}", self.names()));
        let bounds = node.bounds().unwrap();
        Rect::from_min_max(Pos2::new(bounds.x0 as f32, bounds.y0 as f32), Pos2::new(bounds.x1 as f32, bounds.y1 as f32))
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

/// The events of a click; egui wants press and release in frames of their own to tell it from a touch.
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
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Default::default() };
    vec![event(true), event(false)]
}
