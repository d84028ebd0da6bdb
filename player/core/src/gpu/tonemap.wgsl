// From linear radiance to what a display shows, by a triangle that covers the target.

#import everywhere

struct Band {
    // Number of the band's first pixel on the film, row by row.
    first_pixel: u32,
    // Pixels of the band.
    pixels: u32,
    // Pixels of a row of the film.
    width: u32,
    // Factor on radiance: 2^ev.
    gain: f32,
}

@group(0) @binding(0) var<uniform> band: Band;
// Linear radiance of the band; the fourth component is unused.
@group(0) @binding(1) var<storage, read> film: array<vec4<f32>>;
// [256]: the least linear value that is shown as each 8-bit step, in ascending order.
@group(0) @binding(2) var<storage, read> least: array<f32>;

// The exposed radiance of a pixel of the band, 0 to 1; pixels of other bands are left alone.
fn exposed(at: vec4<f32>) -> vec3<f32> {
    let pixel = u32(at.y) * band.width + u32(at.x);
    if pixel < band.first_pixel || pixel - band.first_pixel >= band.pixels {
        discard;
    }
    return clamp(film[pixel - band.first_pixel].rgb * band.gain, vec3<f32>(0.0), vec3<f32>(1.0));
}

// The 8-bit sRGB step of a linear value: the same on every device, which `pow` is not.
fn step_of(linear: f32) -> f32 {
    var low = 0u;
    for (var half = 128u; half > 0u; half /= 2u) {
        if linear >= least[low + half] {
            low += half;
        }
    }
    return f32(low) / 255.0;
}

// For targets that hold what the display is sent.
@fragment
fn encoded(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let linear = exposed(at);
    return vec4<f32>(step_of(linear.r), step_of(linear.g), step_of(linear.b), 1.0);
}

// For targets that encode what they are given, and for those that hold linear values.
@fragment
fn linear(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(exposed(at), 1.0);
}
