// Half number `index` of an array whose words hold two each, the first in the low bits; `word` is the one that holds it.
fn half_of(word: u32, index: u32) -> f32 {
    let pair = unpack2x16float(word);
    return select(pair.x, pair.y, index % 2u == 1u);
}
