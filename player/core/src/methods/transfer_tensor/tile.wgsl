// Vertices of a band that are of one cluster, as they are numbered in the order of clusters.
struct Tile {
    cluster: u32,
    first: u32,
    // At most 64.
    count: u32,
}
