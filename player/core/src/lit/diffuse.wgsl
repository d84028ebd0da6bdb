// Surfaces that reflect alike in all directions: the radiance of a vertex, interpolated, times the diffuse albedo of the material and its texture.

#import corner
#import texture

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
