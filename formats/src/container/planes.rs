//! Numbers as planes of bytes, which compress better than the numbers one after the other.

/// Groups the bytes of equally wide elements by significance, lowest first.
pub fn split(raw: &[u8], width: usize) -> Vec<u8> {
    let mut planes = vec![0; raw.len()];
    for (byte, plane) in planes.chunks_exact_mut((raw.len() / width).max(1)).enumerate() {
        plane.iter_mut().zip(raw.chunks_exact(width)).for_each(|(value, element)| *value = element[byte]);
    }
    planes
}

/// The inverse of [`split`], for elements of two or four bytes; others are left as they are.
pub fn join(planes: &[u8], width: usize) -> Vec<u8> {
    match width {
        2 => interleaved::<2>(planes),
        4 => interleaved::<4>(planes),
        _ => planes.to_vec(),
    }
}

fn interleaved<const WIDTH: usize>(planes: &[u8]) -> Vec<u8> {
    let count = planes.len() / WIDTH;
    let mut out = vec![0; planes.len()];
    for (byte, plane) in planes.chunks_exact(count.max(1)).enumerate().take(WIDTH) {
        for (element, value) in out.as_chunks_mut::<WIDTH>().0.iter_mut().zip(plane) {
            element[byte] = *value;
        }
    }
    out
}
