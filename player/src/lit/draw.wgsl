// The scene's meshes: the radiance of a vertex, interpolated, times the diffuse albedo of the material and its texture.

// A band of the film as the camera sees it; see environment.wgsl.
struct View {
    eye_in_world: vec3<f32>,
    near: f32,
    forward: vec3<f32>,
    band_middle: f32,
    right: vec3<f32>,
    band_reach: f32,
    up: vec3<f32>,
    first_row: f32,
    gain: vec3<f32>,
    width: f32,
    height: f32,
}

struct Material {
    // Diffuse reflectance.
    albedo: vec3<f32>,
    // Where alpha is below this, there is no surface.
    alpha_cutoff: f32,
    // How the texture goes on beyond its edge, along u and v: 0 it repeats, 1 it is mirrored, 2 its edge texels go on.
    wrap: vec2<u32>,
    // 1 if there is a texture, else 0.
    textured: u32,
    // 1 if texels are sharp, 0 if one flows into the next.
    nearest: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> materials: array<Material>;
// Red, green and blue as sRGB encodes them, and alpha.
@group(1) @binding(0) var image: texture_2d<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) radiance: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) @interpolate(flat) material: u32,
}

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) radiance: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @builtin(instance_index) material: u32,
) -> Corner {
    let way = position - view.eye_in_world;
    let depth = dot(way, view.forward);
    let u = dot(way, view.right) / dot(view.right, view.right);
    let v = dot(way, view.up) / dot(view.up, view.up);
    // Depth is near/depth: 1 at the closest, 0 infinitely far away, and evenly precise in between.
    let clip = vec4<f32>(u, (v - view.band_middle * depth) / view.band_reach, view.near, depth);
    return Corner(clip, radiance.rgb, uv, material);
}

fn linear_from_srgb(encoded: vec3<f32>) -> vec3<f32> {
    let curved = pow((encoded + 0.055) / 1.055, vec3<f32>(2.4));
    return select(curved, encoded / 12.92, encoded <= vec3<f32>(0.04045));
}

fn wrapped(index: i32, count: i32, wrap: u32) -> i32 {
    switch wrap {
        case 0u: { return ((index % count) + count) % count; }
        case 1u: {
            let within = ((index % (2 * count)) + 2 * count) % (2 * count);
            return min(within, 2 * count - 1 - within);
        }
        default: { return clamp(index, 0, count - 1); }
    }
}

fn texel(column: i32, row: i32, wrap: vec2<u32>) -> vec4<f32> {
    let size = vec2<i32>(textureDimensions(image));
    let encoded = textureLoad(image, vec2<i32>(wrapped(column, size.x, wrap.x), wrapped(row, size.y, wrap.y)), 0);
    return vec4<f32>(linear_from_srgb(encoded.rgb), encoded.a);
}

// The GPU twin of `relume_formats::basis::Texture::sample`.
fn sample(uv: vec2<f32>, wrap: vec2<u32>, nearest: u32) -> vec4<f32> {
    // Coordinates so large that they have no fraction left fall somewhere legal.
    let scaled = clamp(uv * vec2<f32>(textureDimensions(image)), vec2<f32>(-1e9), vec2<f32>(1e9));
    if nearest == 1u {
        let hit = vec2<i32>(floor(scaled));
        return texel(hit.x, hit.y, wrap);
    }
    let at = scaled - 0.5;
    let first = floor(at);
    let share = at - first;
    let column = i32(first.x);
    let row = i32(first.y);
    let top = mix(texel(column, row, wrap), texel(column + 1, row, wrap), share.x);
    let bottom = mix(texel(column, row + 1, wrap), texel(column + 1, row + 1, wrap), share.x);
    return mix(top, bottom, share.y);
}

@fragment
fn surface(seen: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let material = materials[seen.material];
    var albedo = material.albedo;
    if material.textured == 1u {
        let texture = sample(seen.uv, material.wrap, material.nearest);
        if texture.a < material.alpha_cutoff {
            discard;
        }
        albedo *= texture.rgb;
    }
    // What a vertex knows is the light on the side that its normal points to; the other side gets none.
    let shown = select(vec3<f32>(0.0), view.gain * albedo * seen.radiance, front);
    return vec4<f32>(shown, 1.0);
}
