// BRDF spaces and materials, for the passes that make of what arrives what is seen.

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
    // [cones, 5]: what the shader that looks makes a `Cone` of.
    first_cone: u32,
    // Structs of a uniform array are whole wide words.
    unused: u32,
}

struct Spaces {
    spaces: array<Space, 3>,
    // [16] xyz: directions in a frame, in `tables`.
    directions: u32,
}

// Where the tables of a material are: [nodes, profiles] what each profile counts for, and [nodes, cones] what each cone reflects, rgb.
struct Lobes {
    space: u32,
    weights: u32,
    shares: u32,
}

// The number of a space that is none.
const NO_SPACE = 3u;

@group(0) @binding(10) var<uniform> known: Spaces;
// First `Lobes` by material. Whole numbers, or the bits of others.
@group(0) @binding(11) var<storage, read> tables: array<vec4<u32>>;

fn lobes_of(material: u32) -> Lobes {
    let words = tables[material];
    return Lobes(words.x, words.y, words.z);
}

// Four numbers of the tables.
fn row(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(tables[at]);
}
