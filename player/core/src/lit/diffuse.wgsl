// Surfaces that reflect alike in all directions: the radiance of a vertex, interpolated, and what each point has of the suns, times the diffuse albedo of
// the material and its texture.

#import surface

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) radiance: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) @interpolate(flat) material: u32,
    // Where it is, metres, and its shading normal, in world space.
    @location(3) point: vec3<f32>,
    @location(4) normal: vec3<f32>,
}

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) radiance: vec4<f32>,
    @builtin(instance_index) material: u32,
) -> Corner {
    return Corner(on_film(position, normal), radiance.rgb, uv, material, position, normal);
}

@fragment
fn surface(seen: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let facing = towards_eye_side(seen.point);
    let albedo = albedo_at(seen.uv, materials[seen.material]);
    // What is known is the light on the side that the normal points to; the other side gets none.
    if !front {
        return vec4<f32>(vec3<f32>(0.0), 1.0);
    }
    let normal = unit(seen.normal);
    var direct = vec3<f32>(0.0);
    for (var layer = 0u; layer < suns.count; layer += 1u) {
        direct += sunlight(layer, seen.point, normal, facing, sample_number(seen.clip));
    }
    return vec4<f32>(view.gain * albedo * (seen.radiance + direct), 1.0);
}
