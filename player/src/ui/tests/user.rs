//! A user of the screen, without a window.

use super::*;

/// A user before the screen.
pub(super) struct User {
    pub(super) mirror: Mirror,
    pub(super) screen: Screen,
    pub(super) editor: Editor,
    pub(super) picker: Option<Picker>,
    pub(super) facts: Facts,
    pub(super) wishes: Wishes,
    pub(super) surfaces: Surfaces,
    pub(super) note: Option<Note>,
}

impl User {
    pub(super) fn new(editor: Editor) -> Self {
        Self::before(editor, Some(Picker::new((&*support::images(true).head).into())))
    }

    pub(super) fn before(editor: Editor, picker: Option<Picker>) -> Self {
        let facts = Facts {
            adapter: "an adapter".to_owned(),
            method: "transfer-images".to_owned(),
            size: Some(support::SIZE),
            cpu_ms: Some(0.25),
            gpu_ms: None,
            bytes: 3_000_000,
            bytes_expected: 12_000_000,
            what: "images",
            pieces: 3,
            pieces_expected: 12,
            map_from_outside: false,
            rebaked: false,
            loading: Loading::Complete,
        };
        let mirror = Mirror::new([1200.0, 820.0]);
        let screen = Screen::default();
        let mut user = Self {
            mirror,
            screen,
            editor,
            picker,
            facts,
            wishes: Wishes::default(),
            surfaces: Surfaces::default(),
            note: None,
        };
        set_up_style(user.mirror.context());
        // Some layouts take a frame to settle.
        (0..3).for_each(|_| user.frame(Vec::new()));
        user
    }

    pub(super) fn frame(&mut self, events: Vec<Event>) {
        let Self { mirror, screen, editor, picker, facts, wishes, surfaces, note } = self;
        *wishes = Wishes::default();
        mirror.frame(events, |ui| {
            let picture = TextureId::User(0);
            let stage = Stage {
                editor: &mut *editor,
                picker: picker.as_ref(),
                surfaces,
                size: support::SIZE,
                resizes: picker.is_none(),
                picture,
            };
            let new = screen.show(ui, Some(stage), facts, note.as_ref());
            wishes.save.extend(new.save);
            wishes.paste |= new.paste;
            wishes.reload |= new.reload;
            wishes.open |= new.open;
            wishes.picture = new.picture;
            wishes.tell = new.tell.or_else(|| wishes.tell.take());
            wishes.close |= new.close;
        });
    }

    /// Draws until everything has settled.
    pub(super) fn settle(&mut self) {
        (0..60).for_each(|_| self.frame(Vec::new()));
    }

    pub(super) fn click_at(&mut self, at: Pos2) {
        self.frame(vec![Event::PointerMoved(at)]);
        self.frame(press(at));
        self.frame(release(at));
        let wishes = std::mem::take(&mut self.wishes);
        self.frame(Vec::new());
        self.wishes = wishes;
    }

    #[track_caller]
    pub(super) fn click(&mut self, name: &str) {
        self.click_at(self.mirror.rect(name).center());
    }

    /// The middle of a pixel that shows what `wanted` accepts.
    pub(super) fn pixel_of(&self, wanted: impl Fn(Seen<'_>) -> bool) -> Pos2 {
        let [width, height] = support::SIZE;
        let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let [x, y] = pixels.find(|pixel| wanted(self.picker.as_ref().unwrap().at(*pixel))).unwrap();
        let image = self.mirror.rect("picture");
        image.min
            + egui::Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32)
                * image.size()
    }

    /// Drags the slider called `name` to `share` of its length.
    pub(super) fn slide(&mut self, name: &str, share: f32) {
        let rail = self.mirror.rect(name);
        let to = Pos2::new(rail.left() + share * rail.width(), rail.center().y);
        self.frame(press(rail.center()));
        self.frame(vec![Event::PointerMoved(to)]);
        self.frame(release(to));
        self.frame(Vec::new());
    }

    pub(super) fn drag(&mut self, button: PointerButton, from: Pos2, to: Pos2) {
        let event =
            |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Default::default() };
        self.frame(vec![Event::PointerMoved(from), event(from, true)]);
        self.frame(vec![Event::PointerMoved(to)]);
        self.frame(vec![event(to, false)]);
        self.frame(Vec::new());
    }

    pub(super) fn shows(&self, text: &str) -> bool {
        self.mirror.names().iter().any(|name| name.contains(text))
    }
}
