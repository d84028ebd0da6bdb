// The squares of a face of 32 × 32 texels, from the whole down, level after level and row by row within each.

// Coefficients of a face.
const FACE = 1024u;

struct Square {
    // 0 for the whole face; a level has 2^level squares a side.
    level: u32,
    // Number within the level.
    within: u32,
}

fn square(s: u32) -> Square {
    let level = firstLeadingBit(3u * s + 1u) / 2u;
    return Square(level, s - ((1u << (2u * level)) - 1u) / 3u);
}
