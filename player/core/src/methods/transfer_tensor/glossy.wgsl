// Surfaces that shine: what the diffuse and the glossy part of a material reflect of all light but suns and the map itself towards the eye, both
// interpolated between vertices; at each point what highlights have of the map, as far as vertices see of it, the GPU twin of
// `relume_formats::evaluate::transfer_tensor::Parts::mirrored`; and what the whole material reflects of the suns. Textures colour the diffuse part alone.

#import aspect
#import brdf
#import filtered
#import frame
#import surface

// One or two Gaussians of the angle.
struct Cone {
    // How they are turned away from the mirror direction.
    turned: vec4<f32>,
    // The row where the map filtered for them begins, and its columns and rows; number of Gaussians.
    map: vec4<u32>,
}

// What highlights of a material are made of. A struct of the material that is drawn, and textures rather than buffers: software adapters look up what is
// the same for all lanes once, and texels whole.
struct Mirror {
    cones: array<Cone, 16>,
    count: u32,
}

@group(1) @binding(1) var<uniform> mirror: Mirror;
// [nodes, cones] what each cone reflects.
@group(1) @binding(2) var shares: texture_2d<f32>;

struct GlossyCorner {
    @builtin(position) clip: vec4<f32>,
    @location(0) radiance: vec3<f32>,
    @location(1) glossy: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat) material: u32,
    // Where it is, metres, and its shading normal, in world space.
    @location(4) point: vec3<f32>,
    @location(5) normal: vec3<f32>,
    // The visible parts of 16 cones.
    @location(6) visible_a: vec4<f32>,
    @location(7) visible_b: vec4<f32>,
    @location(8) visible_c: vec4<f32>,
    @location(9) visible_d: vec4<f32>,
}

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) radiance: vec4<f32>,
    @location(4) glossy: vec4<f32>,
    @location(5) visible_a: vec4<f32>,
    @location(6) visible_b: vec4<f32>,
    @location(7) visible_c: vec4<f32>,
    @location(8) visible_d: vec4<f32>,
    @builtin(instance_index) material: u32,
) -> GlossyCorner {
    let clip = on_film(position, normal);
    return GlossyCorner(
        clip, radiance.rgb, glossy.rgb, uv, material, position, normal, visible_a, visible_b, visible_c, visible_d,
    );
}

// What highlights have of the map at a point with a unit normal, seen from a unit vector.
fn mirrored(normal: vec3<f32>, towards_eye: vec3<f32>, visible: array<vec4<f32>, 4>) -> vec3<f32> {
    let frame = frame_about(normal);
    let aspect = aspect_of(frame_from_world(frame, towards_eye));
    var parts = visible;
    var sum = vec3<f32>(0.0);
    for (var number = 0u; number < mirror.count; number += 1u) {
        let before = textureLoad(shares, vec2<u32>(number, aspect.node), 0).rgb;
        let after = textureLoad(shares, vec2<u32>(number, aspect.node + 1u), 0).rgb;
        let share = parts[number / 4u][number % 4u] * mix(before, after, aspect.between);
        if all(share == vec3<f32>(0.0)) {
            continue;
        }
        let cone = mirror.cones[number];
        var light = light_towards(cone.map.xyz, world_from_frame(frame, middle_of(cone.turned, aspect, 1.0)));
        if cone.map.w > 1u {
            light = 0.5 * (light + light_towards(cone.map.xyz, world_from_frame(frame, middle_of(cone.turned, aspect, -1.0))));
        }
        sum += share * light;
    }
    return sum;
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
    let visible = array<vec4<f32>, 4>(seen.visible_a, seen.visible_b, seen.visible_c, seen.visible_d);
    var glossy = max(seen.glossy + mirrored(normal, towards_eye, visible), vec3<f32>(0.0));
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
