// The vertices of a band, and the eye.

struct Look {
    // Metres, world space.
    eye: vec3<f32>,
    // The band's first vertex, among those of the scene.
    first_vertex: u32,
    // Vertices of the band.
    vertices: u32,
}

// A vertex.
struct Place {
    // Metres, world space.
    position: vec3<f32>,
    material: u32,
    // Unit shading normal, world space.
    normal: vec3<f32>,
}

@group(0) @binding(0) var<uniform> look: Look;
// By vertex of the scene.
@group(0) @binding(1) var<storage, read> places: array<Place>;
