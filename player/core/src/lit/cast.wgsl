// Shadow maps: of what a sun sees, how near to it that is. 1 is nearest.

#import sun
#import texture

@group(0) @binding(0) var<uniform> suns: Suns;
// Which sun looks.
@group(0) @binding(1) var<uniform> number: u32;
@group(0) @binding(2) var<storage, read> materials: array<Material>;

struct Caster {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) material: u32,
}

@vertex
fn caster(
    @location(0) position: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @builtin(instance_index) material: u32,
) -> Caster {
    let at = in_box(suns.suns[number], position);
    return Caster(vec4<f32>(at.xy, 0.5 + 0.5 * at.z, 1.0), uv, material);
}

// Holes let light through.
@fragment
fn cut(seen: Caster) {
    let material = materials[seen.material];
    if sample(seen.uv, level_of(0u, material, false), material.wrap).a < material.alpha_cutoff {
        discard;
    }
}
