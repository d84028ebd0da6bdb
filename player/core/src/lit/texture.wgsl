// The texture of a material: the GPU twin of `relume_formats::basis::Texture`.

// Red, green and blue as sRGB encodes them, and alpha.
@group(1) @binding(0) var image: texture_2d<f32>;

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
