// The environment map: resampled to a cube, the GPU twin of `relume_formats::basis::cubemap::from_equirect`, and seen behind the scene.

struct Environment {
    sin_rotation: f32,
    cos_rotation: f32,
    // What a stored 1 is worth.
    unit: f32,
    // Texels along a side of the cube's faces.
    face_size: u32,
    // Look-ups along a side of a texel of the cube; a multiple of 4.
    points: u32,
}

#import angle
#import everywhere
#import invocation
#import view

@group(0) @binding(0) var<uniform> environment: Environment;
// Radiance, W/(sr·m²), row by row on 6 faces of the map without suns, and perhaps on 6 of the whole; the fourth component is unused.
@group(0) @binding(1) var<storage, read_write> cube: array<vec4<f32>>;
@group(0) @binding(2) var<uniform> view: View;
// Linear radiance in `unit` W/(sr·m²); rows from +Y down.
@group(1) @binding(0) var map: texture_2d<f32>;
// The same without its suns.
@group(1) @binding(1) var rest: texture_2d<f32>;

fn texel(column: i32, row: i32, size: vec2<i32>, whole: bool) -> vec3<f32> {
    let wrapped = ((column % size.x) + size.x) % size.x;
    let at = vec2<i32>(wrapped, clamp(row, 0, size.y - 1));
    if whole {
        return textureLoad(map, at, 0).rgb;
    }
    return textureLoad(rest, at, 0).rgb;
}

// Radiance from a direction of any length, interpolated linearly between texel centres, of the whole map or without its suns.
fn radiance(direction: vec3<f32>, whole: bool) -> vec3<f32> {
    let x = environment.cos_rotation * direction.x - environment.sin_rotation * direction.z;
    let z = environment.cos_rotation * direction.z + environment.sin_rotation * direction.x;
    let u = 0.5 + angle_of(x, -z) / (2.0 * PI);
    let v = angle_of(sqrt(x * x + z * z), direction.y) / PI;
    let size = vec2<i32>(textureDimensions(map));
    let at = vec2<f32>(u, v) * vec2<f32>(size) - 0.5;
    let first = floor(at);
    let share = at - first;
    let column = i32(first.x);
    let row = i32(first.y);
    let top = mix(texel(column, row, size, whole), texel(column + 1, row, size, whole), share.x);
    let bottom = mix(texel(column, row + 1, size, whole), texel(column + 1, row + 1, size, whole), share.x);
    return mix(top, bottom, share.y) * environment.unit;
}

// The point of the cube [−1, 1]³ at (s, t) on a face.
fn on_face(face: u32, s: f32, t: f32) -> vec3<f32> {
    switch face {
        case 0u: { return vec3<f32>(1.0, -t, -s); }
        case 1u: { return vec3<f32>(-1.0, -t, s); }
        case 2u: { return vec3<f32>(s, 1.0, t); }
        case 3u: { return vec3<f32>(s, -1.0, -t); }
        case 4u: { return vec3<f32>(s, -t, 1.0); }
        default: { return vec3<f32>(-s, -t, -1.0); }
    }
}

fn place(texel: u32, point: u32) -> f32 {
    return 2.0 * (f32(texel) + (f32(point) + 0.5) / f32(environment.points)) / f32(environment.face_size) - 1.0;
}

// Invocations that share the look-ups of one texel of the cube.
const TEAM = 16u;
// Weighted radiance and weight, by invocation.
var<workgroup> sums: array<vec4<f32>, 64>;

@compute @workgroup_size(64)
fn resample(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let n = environment.face_size;
    let index = invocation(group, groups, 64u, lane) / TEAM;
    let member = lane % TEAM;
    let face = index / (n * n);
    let is_there = index < arrayLength(&cube);
    let x = index % n;
    let y = index / n % n;
    var sum = vec4<f32>(0.0);
    if is_there {
        for (var k = member; k < environment.points * environment.points; k += TEAM) {
            let s = place(x, k % environment.points);
            let t = place(y, k / environment.points);
            let q = 1.0 + s * s + t * t;
            let weight = 1.0 / (q * sqrt(q));
            sum += weight * vec4<f32>(radiance(on_face(face % 6u, s, t), face >= 6u), 1.0);
        }
    }
    sums[lane] = sum;
    for (var half = TEAM / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if member < half {
            sums[lane] += sums[lane + half];
        }
    }
    if is_there && member == 0u {
        cube[index] = vec4<f32>(sums[lane].rgb / sums[lane].a, 0.0);
    }
}

@fragment
fn background(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    // Two samples for each pixel, both ways.
    let u = at.x / view.width - 1.0;
    let v = 1.0 - (2.0 * view.first_row + at.y) / view.height;
    return vec4<f32>(view.gain * radiance(view.forward + u * view.right + v * view.up, true), 1.0);
}
