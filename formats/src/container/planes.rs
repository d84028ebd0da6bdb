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
        2 => pairs(planes),
        4 => {
            // The planes of either half of an element, then the halves.
            let (low, high) = planes.split_at(planes.len() / 4 * 2);
            let (low, high) = (pairs(low), pairs(high));
            let halves = low.as_chunks::<2>().0.iter().zip(high.as_chunks::<2>().0);
            halves.flat_map(|([a, b], [c, d])| [*a, *b, *c, *d]).collect()
        }
        _ => planes.to_vec(),
    }
}

/// Elements of two bytes.
fn pairs(planes: &[u8]) -> Vec<u8> {
    let mut out = vec![0; planes.len()];
    let (low, high) = planes.split_at(planes.len() / 2);
    for (element, (low, high)) in out.as_chunks_mut().0.iter_mut().zip(low.iter().zip(high)) {
        *element = [*low, *high];
    }
    out
}
