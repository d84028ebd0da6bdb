//! The structs of `sum.wgsl`, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// One dispatch: a band of pixels × a chunk of slots.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Dispatch {
    /// Pixels of the band.
    pub(super) pixels: u32,
    /// First slot of the chunk.
    pub(super) first_slot: u32,
    /// One past its last slot.
    pub(super) end_slot: u32,
    /// All slots of the bake.
    pub(super) slots: u32,
    /// 1 to add to what the film holds, 0 to overwrite it.
    pub(super) accumulate: u32,
}

/// Where a slot lies in its chunk.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Slot {
    /// First plane, in halves from the start of the chunk; even.
    pub(super) offset: u32,
    /// From plane to plane, in halves; even.
    pub(super) stride: u32,
    /// Fragments that have a value in this slot.
    pub(super) fragments: u32,
    /// 1: three planes, 0: one.
    pub(super) rgb: u32,
}

/// A fragment of a pixel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Fragment {
    /// Position within a plane.
    pub(super) index: u32,
    /// Row of the coefficients.
    pub(super) material: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    /// Name, size and (member, offset) pairs of a struct.
    type Layout = (&'static str, usize, Vec<(&'static str, usize)>);

    macro_rules! layout_of {
        ($type:ident { $($field:ident),* }) => {{
            // Naming every field makes a forgotten one a compile error.
            let $type { $($field: _),* } = $type::zeroed();
            (stringify!($type), size_of::<$type>(), vec![$((stringify!($field), offset_of!($type, $field))),*])
        }};
    }

    #[test]
    fn gpu_layout() {
        let module = naga::front::wgsl::parse_str(super::super::SHADER).unwrap();
        let ours: [Layout; 3] = [
            layout_of!(Dispatch { pixels, first_slot, end_slot, slots, accumulate }),
            layout_of!(Slot { offset, stride, fragments, rgb }),
            layout_of!(Fragment { index, material }),
        ];
        for (name, size, fields) in ours {
            let (_, shader_type) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
            let naga::TypeInner::Struct { members, span } = &shader_type.inner else { panic!("{name} is no struct") };
            let theirs: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
            assert_eq!((theirs, *span as usize), (fields, size), "{name}");
        }
    }
}
