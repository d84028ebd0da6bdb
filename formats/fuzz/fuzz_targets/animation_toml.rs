//! Animations as text.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::state::Animation;
use relume_formats_fuzz::playing::play_animation;
use relume_formats_fuzz::{check_refusal, place, read, write};

fuzz_target!(|text: &str| {
    match Animation::parse("fuzzed", text, &place()) {
        Ok(animation) => {
            play_animation(&animation);
            assert!(animation.frame_count(30.0) > 0);
            let stored: Animation = read(&write(&animation)).expect("what was parsed can be stored");
            assert_eq!(stored, animation);
        }
        Err(error) => check_refusal(&error),
    }
});
