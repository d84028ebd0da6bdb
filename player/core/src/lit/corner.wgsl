// The corners of the scene's triangles: where they are seen, and what a vertex knows.

#import view
#import material

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> materials: array<Material>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) radiance: vec3<f32>,
    @location(1) uv: vec2<f32>,
    @location(2) @interpolate(flat) material: u32,
    // Where it is, metres, and its shading normal, in world space.
    @location(3) point: vec3<f32>,
    @location(4) normal: vec3<f32>,
}

// How much deeper what turns away from the eye is drawn, in parts of its depth: of the two faces of a sheet the one that faces the eye is seen.
const BEHIND = 1.52587890625e-5;

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) radiance: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) normal: vec3<f32>,
    @builtin(instance_index) material: u32,
) -> Corner {
    let way = position - view.eye_in_world;
    let depth = dot(way, view.forward);
    let u = dot(way, view.right) / dot(view.right, view.right);
    let v = dot(way, view.up) / dot(view.up, view.up);
    // Depth is near/depth: 1 at the closest, 0 infinitely far away, and evenly precise in between.
    let near = view.near * select(1.0, 1.0 - BEHIND, dot(normal, way) > 0.0);
    let clip = vec4<f32>(u, (v - view.band_middle * depth) / view.band_reach, near, depth);
    return Corner(clip, radiance.rgb, uv, material, position, normal);
}
