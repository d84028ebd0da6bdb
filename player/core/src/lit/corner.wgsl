// The corners of the scene's triangles: where they are seen.

#import view
#import material

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> materials: array<Material>;

// How much deeper what turns away from the eye is drawn, in parts of its depth: of the two faces of a sheet the one that faces the eye is seen.
const BEHIND = 1.52587890625e-5;

// Where a vertex at `position` with this normal is drawn.
fn on_film(position: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
    let way = position - view.eye_in_world;
    let depth = dot(way, view.forward);
    let u = dot(way, view.right) / dot(view.right, view.right);
    let v = dot(way, view.up) / dot(view.up, view.up);
    // Depth is near/depth: 1 at the closest, 0 infinitely far away, and evenly precise in between.
    let near = view.near * select(1.0, 1.0 - BEHIND, dot(normal, way) > 0.0);
    return vec4<f32>(u, (v - view.band_middle * depth) / view.band_reach, near, depth);
}
