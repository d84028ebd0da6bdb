// Surfaces that reflect alike in all directions: the radiance of a vertex, interpolated, times the diffuse albedo of the material and its texture.

#import corner
#import texture

@fragment
fn surface(seen: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    // Where neighbours may take another branch, there are no derivatives.
    let across = dpdx(seen.uv);
    let down = dpdy(seen.uv);
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
    // What a vertex knows is the light on the side that its normal points to; the other side gets none.
    let shown = select(vec3<f32>(0.0), view.gain * albedo * seen.radiance, front);
    return vec4<f32>(shown, 1.0);
}
