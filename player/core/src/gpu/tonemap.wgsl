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
    // The curve: 0 clamp, 1 neutral, 2 AgX.
    curve: u32,
}

@group(0) @binding(0) var<uniform> band: Band;
// Linear radiance of the band; the fourth component is unused.
@group(0) @binding(1) var<storage, read> film: array<vec4<f32>>;
// [256]: the least linear value that is shown as each 8-bit step, in ascending order.
@group(0) @binding(2) var<storage, read> least: array<f32>;

// The curves are those of formats/src/display, which tells what they are and where their numbers come from.
const MOST = 1e9;

// Khronos PBR Neutral.
const F0 = 0.04;
const START = 0.76;
const DESATURATION = 0.15;

fn neutral(exposed: vec3<f32>) -> vec3<f32> {
    let least = min(exposed.r, min(exposed.g, exposed.b));
    let colour = exposed - select(F0, least - least * least / (4.0 * F0), least < 2.0 * F0);
    let peak = max(colour.r, max(colour.g, colour.b));
    if peak < START {
        return colour;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let kept = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    return new_peak * (colour / peak * kept + (1.0 - kept));
}

// AgX. A row of numbers here is a row of the matrix: vectors stand at the left of it.
const REC2020_FROM_REC709 = mat3x3<f32>(0.6274, 0.3293, 0.0433, 0.0691, 0.9195, 0.0113, 0.0164, 0.0880, 0.8956);
const REC709_FROM_REC2020 = mat3x3<f32>(1.6605, -0.5876, -0.0728, -0.1246, 1.1329, -0.0083, -0.0182, -0.1006, 1.1187);
const INSET = mat3x3<f32>(
    0.85662715, 0.09512124, 0.048251606,
    0.13731897, 0.761242, 0.10143904,
    0.11189821, 0.07679942, 0.81130237,
);
const OUTSET = mat3x3<f32>(
    1.1271006, -0.11060664, -0.016493939,
    -0.14132976, 1.1578237, -0.016493939,
    -0.14132976, -0.11060664, 1.2519364,
);
const LEAST_EV = -12.47393;
const MOST_EV = 4.026069;

fn contrast(x: vec3<f32>) -> vec3<f32> {
    return (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;
}

fn agx(exposed: vec3<f32>) -> vec3<f32> {
    let drawn_in = exposed * REC2020_FROM_REC709 * INSET;
    let ev = log2(max(drawn_in, vec3<f32>(1e-10)));
    let bent = contrast(clamp((ev - LEAST_EV) / (MOST_EV - LEAST_EV), vec3<f32>(0.0), vec3<f32>(1.0)));
    return pow(max(bent * OUTSET, vec3<f32>(0.0)), vec3<f32>(2.2)) * REC709_FROM_REC2020;
}

// What is shown of a pixel of the band, 0 to 1; pixels of other bands are left alone.
fn shown(at: vec4<f32>) -> vec3<f32> {
    let pixel = u32(at.y) * band.width + u32(at.x);
    if pixel < band.first_pixel || pixel - band.first_pixel >= band.pixels {
        discard;
    }
    let radiance = film[pixel - band.first_pixel].rgb * band.gain;
    // What is no number is not above 0 either.
    var value = select(vec3<f32>(0.0), min(radiance, vec3<f32>(MOST)), radiance > vec3<f32>(0.0));
    if band.curve == 1u {
        value = neutral(value);
    } else if band.curve == 2u {
        value = agx(value);
    }
    return clamp(value, vec3<f32>(0.0), vec3<f32>(1.0));
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
    let linear = shown(at);
    return vec4<f32>(step_of(linear.r), step_of(linear.g), step_of(linear.b), 1.0);
}

// For targets that encode what they are given, and for those that hold linear values.
@fragment
fn linear(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(shown(at), 1.0);
}
