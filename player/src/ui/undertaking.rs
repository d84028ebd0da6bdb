//! What the user is in the middle of, a drag or a field being typed in, and how it is called off: by Escape,
//! which brings back what was set before.

use super::editor::{Editor, Settings};
use egui::{Context, Event, Id, Key, Modifiers};

/// What is under way, and the settings from before it changed anything.
#[derive(Default)]
pub struct Undertaking {
    /// What is dragged, or typed in.
    of: Option<(Id, Settings)>,
}

impl Undertaking {
    /// Looks what is under way, before a pass changes anything.
    pub fn watch(&mut self, ctx: &Context, editor: &mut Editor) {
        // In the pass of an Escape egui has ended drag and typing already.
        if !escapes(ctx) {
            self.update(ctx, editor);
        }
    }

    /// Whether the hand has let go of everything, so that what has changed is an edit of its own.
    pub fn is_over(&self, ctx: &Context) -> bool {
        self.of.is_none() && ctx.input(|input| input.smooth_scroll_delta() == egui::Vec2::ZERO)
    }

    /// Calls off what is under way if the user asks for that, after a pass has changed what it would.
    pub fn obey_escape(&mut self, ctx: &Context, editor: &mut Editor) {
        if let Some((_, before)) = self.of.take_if(|_| escapes(ctx)) {
            editor.restore(before);
        }
        self.update(ctx, editor);
    }

    fn update(&mut self, ctx: &Context, editor: &mut Editor) {
        let of = under_way(ctx);
        if of != self.of.as_ref().map(|(id, _)| *id) {
            // What was under way is over, and an edit of its own, even if something else goes on at once.
            editor.commit();
            self.of = of.map(|id| (id, editor.settings()));
        }
    }
}

fn escapes(ctx: &Context) -> bool {
    let is_escape = |event: &Event| {
        matches!(event, Event::Key { key: Key::Escape, pressed: true, modifiers: Modifiers::NONE, .. })
    };
    ctx.input(|input| input.events.iter().any(is_escape))
}

fn under_way(ctx: &Context) -> Option<Id> {
    ctx.dragged_id().or_else(|| ctx.memory(|memory| memory.focused()).filter(|_| ctx.text_edit_focused()))
}
