// What points of surfaces have whatever they reflect: a colour, holes, and the suns that shine on them.

#import corner
#import sunlight
#import texture

// The diffuse albedo of a material, coloured by its texture. Where that cuts a hole, nothing is drawn.
fn albedo_at(uv: vec2<f32>, material: Material) -> vec3<f32> {
    // Where neighbours may take another branch, there are no derivatives.
    let across = dpdx(uv);
    let down = dpdy(uv);
    if material.levels == 0u {
        return material.albedo;
    }
    // Holes are cut by the texture itself: the mean of alpha would close them, or open all, far away.
    if material.alpha_cutoff > 0.0
        && sample(uv, level_of(0u, material, false), material.wrap).a < material.alpha_cutoff {
        discard;
    }
    return material.albedo * mean(uv, across, down, material);
}

// The unit normal of the triangle around a point, on the side that the eye sees.
fn towards_eye_side(point: vec3<f32>) -> vec3<f32> {
    let across_face = cross(dpdx(point), dpdy(point));
    return unit(select(-1.0, 1.0, dot(across_face, view.eye_in_world - point) > 0.0) * across_face);
}

// The number of a sample among those of its pixel.
fn sample_number(clip: vec4<f32>) -> u32 {
    let place = vec2<u32>(clip.xy) % 2u;
    return 2u * place.y + place.x;
}

fn unit(v: vec3<f32>) -> vec3<f32> {
    // First to a size whose square is a number, whatever the scene's.
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    let scaled = v / select(1.0, largest, largest > 0.0);
    return scaled / max(length(scaled), 1e-30);
}
