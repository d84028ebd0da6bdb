// Surfaces that shine: what the diffuse and the glossy part of a material reflect of all light but suns towards the eye, both interpolated between
// vertices, and at each point what the whole material reflects of the suns. Textures colour the diffuse part alone.

#import brdf
#import surface

struct GlossyCorner {
    @builtin(position) clip: vec4<f32>,
    @location(0) radiance: vec3<f32>,
    @location(1) glossy: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat) material: u32,
    // Where it is, metres, and its shading normal, in world space.
    @location(4) point: vec3<f32>,
    @location(5) normal: vec3<f32>,
}

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) radiance: vec4<f32>,
    @location(4) glossy: vec4<f32>,
    @builtin(instance_index) material: u32,
) -> GlossyCorner {
    return GlossyCorner(on_film(position, normal), radiance.rgb, glossy.rgb, uv, material, position, normal);
}

@fragment
fn surface(seen: GlossyCorner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let facing = towards_eye_side(seen.point);
    let material = materials[seen.material];
    let albedo = albedo_at(seen.uv, material);
    // What is known is the light on the side that the normal points to; the other side gets none.
    if !front {
        return vec4<f32>(vec3<f32>(0.0), 1.0);
    }
    let normal = unit(seen.normal);
    let towards_eye = unit(view.eye_in_world - seen.point);
    var diffuse = seen.radiance;
    var glossy = seen.glossy;
    for (var layer = 0u; layer < suns.count; layer += 1u) {
        let white = sunlight(layer, seen.point, normal, facing, sample_number(seen.clip));
        // The lobe is that of the disc's middle, not its mean over the disc: of materials that a state may set none is as narrow. Exponent 200, slope 0.1
        // and roughness 0.32 have standard deviations of 8° in the plane of incidence, which a sun of the largest radius, 3.25°, would widen by 2 %; across
        // it, a cosine of the angle narrower, by a tenth at 60°.
        let angles = angles_between(suns.suns[layer].towards, towards_eye, normal);
        diffuse += diffuse_lobe(material, angles) * white;
        glossy += PI * glossy_lobe(material, angles) * white;
    }
    return vec4<f32>(view.gain * (albedo * diffuse + glossy), 1.0);
}
