// Surfaces that reflect alike in all directions: the radiance of a vertex, interpolated, and what each point has of the suns, times the diffuse albedo of
// the material and its texture.

#import corner
#import sunlight
#import texture

@fragment
fn surface(seen: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    // Where neighbours may take another branch, there are no derivatives.
    let across = dpdx(seen.uv);
    let down = dpdy(seen.uv);
    let across_face = cross(dpdx(seen.point), dpdy(seen.point));
    let material = materials[seen.material];
    var albedo = material.albedo;
    if material.levels > 0u {
        // Holes are cut by the texture itself: the mean of alpha would close them, or open all, far away.
        if material.alpha_cutoff > 0.0
            && sample(seen.uv, level_of(0u, material, false), material.wrap).a < material.alpha_cutoff {
            discard;
        }
        albedo *= mean(seen.uv, across, down, material);
    }
    // What is known is the light on the side that the normal points to; the other side gets none.
    if !front {
        return vec4<f32>(vec3<f32>(0.0), 1.0);
    }
    // That side is the one that the eye sees.
    let facing = select(-1.0, 1.0, dot(across_face, view.eye_in_world - seen.point) > 0.0) * across_face;
    let place = vec2<u32>(seen.clip.xy) % 2u;
    let direct = sunlight(seen.point, unit(seen.normal), unit(facing), 2u * place.y + place.x);
    return vec4<f32>(view.gain * albedo * (seen.radiance + direct), 1.0);
}

fn unit(v: vec3<f32>) -> vec3<f32> {
    // First to a size whose square is a number, whatever the scene's.
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    let scaled = v / select(1.0, largest, largest > 0.0);
    return scaled / max(length(scaled), 1e-30);
}
