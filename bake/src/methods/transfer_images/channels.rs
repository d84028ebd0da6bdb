//! What the channels of a fragment's record are, slot by slot.

use crate::filter::{LAYERS, Layer};
use crate::fragments::Channels;
use relume_formats::kinds::transfer_images::{FirstReflection, Layout};
use std::ops::Range;

/// Those of fragments of materials that vary, and of fixed ones, which have the first slots only, all of them RGB.
pub fn channels(layout: &Layout) -> [Channels; 2] {
    let editable = layout.slots.iter().map(|slot| (slot.first, slot.channels()));
    let fixed = layout.slots.iter().filter_map(|slot| Some((slot.fixed?, slot.channels())));
    [channels_of_layers(editable), channels_of_layers(fixed)]
}

fn layer_of(first: FirstReflection) -> Layer {
    match first {
        FirstReflection::None => Layer::Direct,
        FirstReflection::Fixed | FirstReflection::Editable { .. } => Layer::Indirect,
        FirstReflection::Later { .. } | FirstReflection::LaterLobe { .. } => Layer::Later,
    }
}

/// Of slots in their order, each with its channels.
fn channels_of_layers(slots: impl Iterator<Item = (FirstReflection, usize)>) -> Channels {
    let mut layers: [Vec<Range<usize>>; LAYERS] = Default::default();
    let mut start = 0;
    for (first, channels) in slots {
        let layer = &mut layers[layer_of(first) as usize];
        match layer.last_mut() {
            Some(last) if last.end == start => last.end += channels,
            _ => layer.push(start..start + channels),
        }
        start += channels;
    }
    Channels { count: start, layers }
}
