// The irradiance over π that arrives at vertices after two reflections: the GPU twin of that part of `relume_formats::evaluate::transfer_tensor::received`.

#import bytes
#import invocation
#import tile

struct Second {
    // Vertices of the band.
    vertices: u32,
    // Vectors of each cluster, and words of four shares.
    vectors: u32,
    quads: u32,
}

@group(0) @binding(0) var<uniform> second: Second;
@group(0) @binding(1) var<storage, read> tiles: array<Tile>;
// Vertices in the order of clusters: which of the band they are.
@group(0) @binding(2) var<storage, read> order: array<u32>;
// [quads, vertices in the order of clusters] four i8: in 127ths.
@group(0) @binding(3) var<storage, read> shares: array<u32>;
// By cluster and vector; the fourth component is unused.
@group(0) @binding(4) var<storage, read> lit_twice: array<vec4<f32>>;
// [17, vertices of the band]: 16 harmonics, and irradiance over π after two reflections; the fourth component is unused.
@group(0) @binding(5) var<storage, read_write> arriving: array<vec4<f32>>;

@compute @workgroup_size(64)
fn reflect_twice(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, 1u, 0u);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    if lane >= tile.count {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var vector = 0u; vector < second.vectors; vector += 1u) {
        let four = bytes_of(shares[vector / 4u * second.vertices + tile.first + lane]);
        sum += four[vector % 4u] / 127.0 * lit_twice[tile.cluster * second.vectors + vector].rgb;
    }
    arriving[16u * second.vertices + order[tile.first + lane]] = vec4<f32>(sum, 0.0);
}
