//! Files of kind `sphere-set`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::SphereSet;
use relume_formats_fuzz::playing::play_spheres;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<SphereSet>(data, play_spheres));
