// The radiance that arrives at vertices after one reflection, as 16 spherical harmonics in world space: the GPU twin of that part of
// `relume_formats::evaluate::transfer_tensor::received`.
//
// A workgroup makes four harmonics of a tile of vertices. All of these have the same functions, so that what lanes load of them is one word for all.

#import bytes
#import invocation
#import tile

struct Bounce {
    // Vertices of the band.
    vertices: u32,
    sources: u32,
    // Words of four shares, of each source.
    quads: u32,
}

// Workgroups of a tile.
const PARTS = 4u;

@group(0) @binding(0) var<uniform> bounce: Bounce;
@group(0) @binding(1) var<storage, read> tiles: array<Tile>;
// Vertices in the order of clusters: which of the band they are.
@group(0) @binding(2) var<storage, read> order: array<u32>;
// [sources, quads, vertices in the order of clusters] four i8: in 127ths.
@group(0) @binding(3) var<storage, read> shares: array<u32>;
// [clusters, sources, 4·quads, 16]; the fourth component is unused.
@group(0) @binding(4) var<storage, read> functions: array<vec4<f32>>;
// By source: what its material makes of it.
@group(0) @binding(5) var<storage, read> weights: array<vec4<f32>>;
// [17, vertices of the band]: 16 harmonics, and irradiance over π after two reflections; the fourth component is unused.
@group(0) @binding(6) var<storage, read_write> arriving: array<vec4<f32>>;

// Four harmonics.
struct Harmonics {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

fn add(sums: ptr<function, Harmonics>, share: vec3<f32>, at: u32) {
    (*sums).a += share * functions[at].rgb;
    (*sums).b += share * functions[at + 1u].rgb;
    (*sums).c += share * functions[at + 2u].rgb;
    (*sums).d += share * functions[at + 3u].rgb;
}

@compute @workgroup_size(64)
fn reflect_once(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, 1u, 0u);
    if index / PARTS >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index / PARTS];
    let part = index % PARTS;
    let place = tile.first + min(lane, tile.count - 1u);
    var sums = Harmonics();
    for (var source = 0u; source < bounce.sources; source += 1u) {
        let weight = weights[source].rgb / 127.0;
        if all(weight == vec3<f32>(0.0)) {
            continue;
        }
        for (var quad = 0u; quad < bounce.quads; quad += 1u) {
            let word = source * bounce.quads + quad;
            let of_vertex = bytes_of(shares[word * bounce.vertices + place]);
            let at = 64u * (tile.cluster * bounce.sources * bounce.quads + word) + 4u * part;
            add(&sums, of_vertex.x * weight, at);
            add(&sums, of_vertex.y * weight, at + 16u);
            add(&sums, of_vertex.z * weight, at + 32u);
            add(&sums, of_vertex.w * weight, at + 48u);
        }
    }
    if lane < tile.count {
        let first = 4u * part * bounce.vertices + order[place];
        arriving[first] = vec4<f32>(sums.a, 0.0);
        arriving[first + bounce.vertices] = vec4<f32>(sums.b, 0.0);
        arriving[first + 2u * bounce.vertices] = vec4<f32>(sums.c, 0.0);
        arriving[first + 3u * bounce.vertices] = vec4<f32>(sums.d, 0.0);
    }
}
