// From linear radiance to what a display shows: the GPU twin of `output::display_value` and `output::encode_png`.

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
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

// The sRGB transfer function (IEC 61966-2-1).
fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let curved = 1.055 * pow(max(linear, vec3<f32>(0.0031308)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curved, 12.92 * linear, linear <= vec3<f32>(0.0031308));
}

@compute @workgroup_size(64)
fn tonemap(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = (group.y * groups.x + group.x) * 64u + lane;
    if index >= band.pixels {
        return;
    }
    let pixel = band.first_pixel + index;
    let linear = clamp(film[index].rgb * band.gain, vec3<f32>(0.0), vec3<f32>(1.0));
    // Rounded here, for how a device rounds on writing is its own choice.
    let encoded = floor(srgb(linear) * 255.0 + 0.5) / 255.0;
    textureStore(picture, vec2<u32>(pixel % band.width, pixel / band.width), vec4<f32>(encoded, 1.0));
}
