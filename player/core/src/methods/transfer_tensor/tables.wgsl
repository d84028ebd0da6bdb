// What vertices and their materials are, for the passes that make of what arrives what is seen.

// A BRDF space. Places are in `tables`, whose components that are not named are unused.
struct Space {
    // Numbers of a vertex: one of the diffuse part, then one of each profile of order 0 and two of each other.
    columns: u32,
    profiles: u32,
    cones: u32,
    // [16, columns] x: what radiance from each of the 16 directions counts for.
    harmonics: u32,
    // [profiles] x: azimuthal order.
    orders: u32,
    // [nodes] rgb: what the diffuse part reflects of a white sky.
    even: u32,
    // [cones, 4]: what the shader that looks makes a `Cone` of.
    first_cone: u32,
    // Structs of a uniform array are whole wide words.
    unused: u32,
}

struct Look {
    // Metres, world space.
    eye: vec3<f32>,
    // The band's first vertex, among those of the scene.
    first_vertex: u32,
    // Vertices of the band.
    vertices: u32,
    // Of the light about +Y.
    sin_rotation: f32,
    cos_rotation: f32,
    // [16] xyz: directions in a frame, in `tables`.
    directions: u32,
    spaces: array<Space, 3>,
}

// A vertex.
struct Place {
    // Metres, world space.
    position: vec3<f32>,
    material: u32,
    // Unit shading normal, world space.
    normal: vec3<f32>,
}

// Where the tables of a material are: [nodes, profiles] what each profile counts for, and [nodes, cones] what each cone reflects, rgb.
struct Lobes {
    space: u32,
    weights: u32,
    shares: u32,
}

// The number of a space that is none.
const NO_SPACE = 3u;

@group(0) @binding(0) var<uniform> look: Look;
// By vertex of the scene.
@group(0) @binding(1) var<storage, read> places: array<Place>;
// First `Lobes` by material. Whole numbers, or the bits of others.
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;

fn lobes_of(material: u32) -> Lobes {
    let words = tables[material];
    return Lobes(words.x, words.y, words.z);
}

// Four numbers of the tables.
fn row(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(tables[at]);
}
