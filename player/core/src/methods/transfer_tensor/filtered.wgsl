// The map without suns as cones see it.

#import angle

// Sine and cosine of what the light is turned by about +Y.
@group(0) @binding(12) var<uniform> rotation: vec2<f32>;
// For cones of each width, one below the other, not turned.
@group(0) @binding(13) var filtered: texture_2d<f32>;

fn filtered_at(column: i32, row: f32, map: vec3<u32>) -> vec3<f32> {
    let width = i32(map.y);
    let at = vec2<i32>((column + width) % width, i32(map.x) + i32(clamp(row, 0.0, f32(map.z) - 1.0)));
    return textureLoad(filtered, at, 0).rgb;
}

// The light as cones see it in a direction in world space: their map begins at row `map.x` and has `map.y` columns and `map.z` rows. The GPU twin of
// `relume_formats::basis::blurred::radiance`.
fn light_towards(map: vec3<u32>, direction: vec3<f32>) -> vec3<f32> {
    let x = rotation.y * direction.x - rotation.x * direction.z;
    let z = rotation.y * direction.z + rotation.x * direction.x;
    let u = 0.5 + 0.5 * FRAC_1_PI * angle_of(x, -z);
    let v = FRAC_1_PI * angle_of(length(vec2<f32>(x, z)), direction.y);
    let at = vec2<f32>(u, v) * vec2<f32>(f32(map.y), f32(map.z)) - 0.5;
    let first = floor(at);
    let share = at - first;
    let column = i32(first.x);
    let top = mix(filtered_at(column, first.y, map), filtered_at(column + 1, first.y, map), share.x);
    let bottom = mix(filtered_at(column, first.y + 1.0, map), filtered_at(column + 1, first.y + 1.0, map), share.x);
    return mix(top, bottom, share.y);
}
