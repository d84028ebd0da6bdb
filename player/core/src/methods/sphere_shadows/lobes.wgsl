// The lobes whose blend is that of a receiver's normal.
struct Lobes {
    rows: vec4<u32>,
    // Their weights, 0 for those not needed.
    weights: vec4<f32>,
}
