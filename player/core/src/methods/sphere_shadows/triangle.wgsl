// A triangle that casts a shadow, where it is now.
struct Triangle {
    a: vec3<f32>,
    // The object that it is of.
    object: u32,
    b: vec3<f32>,
    // For each of its edges AB, BC, CA a bit: whether it runs from the vertex with the larger number. Triangles that share an edge compute its plane
    // from the same corners in the same order, so that no rounding opens a crack.
    turned: u32,
    c: vec3<f32>,
    // Receivers of its own object count that are higher above its plane than this,
    own_above: f32,
    // Unit length; 0 if it has no area.
    normal: vec3<f32>,
    // or farther below it than this.
    own_below: f32,
    // The same for other receivers.
    above: f32,
    below: f32,
}
