// Rows of texels of the cube on which bitmaps stand.

const SIDE = 32u;

// A vector in the frame of a face.
fn on_face(face: u32, v: vec3<f32>) -> vec3<f32> {
    switch face {
        case 0u: { return vec3<f32>(-v.z, -v.y, v.x); }
        case 1u: { return vec3<f32>(v.z, -v.y, -v.x); }
        case 2u: { return vec3<f32>(v.x, v.z, v.y); }
        case 3u: { return vec3<f32>(v.x, -v.z, -v.y); }
        case 4u: { return vec3<f32>(v.x, -v.y, v.z); }
        default: { return vec3<f32>(-v.x, -v.y, -v.z); }
    }
}

// Where the centres of a row are on its face.
fn centre(row: u32) -> f32 {
    return f32(2u * row + 1u) / f32(SIDE) - 1.0;
}

// How many of the 32 texel centres along a line lie below the place `texels`, counted in texels from the centre of the first.
fn below(texels: f32) -> u32 {
    // No number is below none, as in the CPU's code.
    return u32(round(min(select(0.0, texels, texels > 0.0), f32(SIDE))));
}

// All bits from the `first` on.
fn bits_from(first: u32) -> u32 {
    return select(0xffffffffu << (first & 31u), 0u, first > 31u);
}
