//! Memory in large pages: rays without order touch all of a large scene, and would else wait for the tables of its
//! pages, too.

use memmap2::MmapMut;
use std::alloc::{Layout, handle_alloc_error};
use std::marker::PhantomData;

/// A large page, bytes.
const LARGE: usize = 1 << 21;

/// Items that stay as they are.
#[derive(Debug)]
pub struct Pages<T> {
    memory: MmapMut,
    /// In bytes, from the beginning of a large page.
    start: usize,
    size: usize,
    items: PhantomData<T>,
}

impl<T: bytemuck::Pod> Pages<T> {
    /// A copy of `items`. Ends the program if there is no memory for them, as all collections do.
    pub fn new(items: &[T]) -> Self {
        let bytes: &[u8] = bytemuck::cast_slice(items);
        let size = bytes.len();
        let room = size.next_multiple_of(LARGE) + LARGE;
        let mut memory =
            MmapMut::map_anon(room).unwrap_or_else(|_| handle_alloc_error(Layout::for_value(bytes)));
        // No more than a wish.
        #[cfg(target_os = "linux")]
        let _ = memory.advise(memmap2::Advice::HugePage);
        let start = memory.as_ptr().align_offset(LARGE).min(LARGE);
        memory[start..start + size].copy_from_slice(bytes);
        Self { memory, start, size, items: PhantomData }
    }

    /// The items.
    #[inline(always)]
    pub fn as_slice(&self) -> &[T] {
        bytemuck::cast_slice(&self.memory[self.start..self.start + self.size])
    }
}
