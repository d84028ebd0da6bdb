// Receivers whose bitmaps share a buffer.
struct Batch {
    // The first receiver of the batch, and how many there are.
    first: u32,
    count: u32,
    // Spheres of all sets.
    spheres: u32,
}
