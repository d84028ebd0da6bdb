//! Input in the order in which it came.
//!
//! egui reacts once to all that has come since the last pass: a press belongs to what is under the pointer
//! when all motions are over, and what is typed to the field that has the focus when all Tabs are counted. On
//! a slow display, what a quick hand did would depend on the frame rate. So events are cut into turns that
//! egui takes for what they are, and the screen goes through a pass for each of them; only the last is drawn.

use egui::{Context, Event, FullOutput, RawInput, Ui};

/// What a turn is about. Within one, order makes no difference to egui, or egui keeps it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum About {
    /// The pointer moves, any number of times.
    Motion,
    /// The wheel turns, any number of times.
    Wheel,
    /// A button of the mouse goes down or up.
    Button,
    /// A key is pressed, and perhaps types something.
    Key,
    /// Text, as a rule of the key before it.
    Text,
    /// Something is copied, cut, pasted or composed.
    Edit,
}

/// Shows the screen once for each turn of `input`. What comes out is to be drawn and done as if it came of
/// one pass.
pub fn run_in_turns(context: &Context, mut input: RawInput, mut show: impl FnMut(&mut Ui)) -> FullOutput {
    let mut turns = cut(std::mem::take(&mut input.events)).into_iter();
    let with = |events| RawInput { events, ..input.clone() };
    let mut output = context.run_ui(with(turns.next().unwrap_or_default()), &mut show);
    // What a turn has opened, or given the focus to, is laid out before the next one begins.
    for events in turns.flat_map(|turn| [Vec::new(), turn]) {
        let newer = context.run_ui(with(events), &mut show);
        // When to draw again is for the last pass to say.
        let viewports = newer.viewport_output.clone();
        output.append(newer);
        output.viewport_output = viewports;
    }
    output
}

/// Cuts events into turns.
fn cut(events: Vec<Event>) -> Vec<Vec<Event>> {
    let mut turns: Vec<Vec<Event>> = Vec::new();
    let mut now = None;
    for event in events {
        let about = about(&event);
        let goes_on = match (now, about) {
            (Some(now), Some(about)) => continues(now, about),
            _ => true,
        };
        match turns.last_mut().filter(|_| goes_on) {
            Some(turn) => turn.push(event),
            None => turns.push(vec![event]),
        }
        now = if goes_on { now.or(about) } else { about };
    }
    turns
}

/// Whether events about `next` may be part of a turn about `now`.
fn continues(now: About, next: About) -> bool {
    matches!(
        (now, next),
        (About::Motion, About::Motion) | (About::Wheel, About::Wheel) | (About::Key, About::Text)
    )
}

/// What an event is about, if its order among others matters.
fn about(event: &Event) -> Option<About> {
    match event {
        Event::PointerMoved(_) | Event::MouseMoved(_) | Event::PointerGone => Some(About::Motion),
        Event::MouseWheel { .. } | Event::Zoom(_) => Some(About::Wheel),
        Event::PointerButton { .. } => Some(About::Button),
        Event::Key { pressed: true, .. } => Some(About::Key),
        Event::Text(_) => Some(About::Text),
        Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_) => Some(About::Edit),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Key, PointerButton, Pos2, Vec2};

    fn key(key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Default::default() }
    }

    fn button(pressed: bool) -> Event {
        Event::PointerButton {
            pos: Pos2::ZERO,
            button: PointerButton::Primary,
            pressed,
            modifiers: Default::default(),
        }
    }

    fn moved(x: f32) -> Event {
        Event::PointerMoved(Pos2::new(x, 0.0))
    }

    fn wheel() -> Event {
        let (unit, phase) = (egui::MouseWheelUnit::Point, egui::TouchPhase::Move);
        Event::MouseWheel {
            unit,
            source: egui::MouseWheelSource::Unknown,
            phase,
            delta: Vec2::Y,
            modifiers: Default::default(),
        }
    }

    #[test]
    fn events_are_cut_where_their_order_matters() {
        let text = |text: &str| Event::Text(text.to_owned());
        let (a, tab) = (key(Key::A, true), key(Key::Tab, true));
        for turns in [
            vec![],
            vec![
                vec![Event::WindowFocused(true), moved(1.0), moved(2.0)],
                vec![button(true)],
                vec![moved(3.0), moved(4.0)],
                vec![button(false)],
            ],
            vec![
                vec![moved(1.0)],
                vec![wheel(), wheel()],
                vec![moved(2.0), Event::PointerGone],
                vec![wheel()],
            ],
            vec![
                vec![a.clone(), text("a"), key(Key::A, false)],
                vec![tab.clone(), key(Key::Tab, false)],
                vec![a.clone(), text("a")],
            ],
            vec![
                vec![tab.clone()],
                vec![Event::Paste("b".to_owned())],
                vec![Event::Cut],
                vec![text("b")],
                vec![text("c")],
            ],
            vec![
                vec![button(false)],
                vec![text("b")],
                vec![Event::Copy],
                vec![Event::Paste("c".to_owned())],
                vec![tab.clone()],
                vec![tab],
            ],
        ] {
            assert_eq!(cut(turns.concat()), turns);
        }
    }
}
