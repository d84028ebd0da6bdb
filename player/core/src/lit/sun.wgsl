// The suns that shine, and where their shadow maps stand.

// A box around the scene, seen from a sun: a shadow map fills it.
struct Sun {
    centre: vec3<f32>,
    // Tangent of the sun's angular radius.
    tangent: f32,
    // Unit vectors along the rows of the shadow map, up its columns and towards the sun, each with half the box's extent along it, metres.
    right: vec3<f32>,
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    towards: vec3<f32>,
    half_depth: f32,
    // Irradiance of a surface that faces the sun, before the gain, W/m².
    irradiance: vec3<f32>,
}

struct Suns {
    suns: array<Sun, 4>,
    count: u32,
}

// A point of world space in the box: along each of its axes in −1..1.
fn in_box(sun: Sun, point: vec3<f32>) -> vec3<f32> {
    let way = point - sun.centre;
    return vec3<f32>(
        dot(way, sun.right) / sun.half_width,
        dot(way, sun.up) / sun.half_height,
        dot(way, sun.towards) / sun.half_depth,
    );
}
