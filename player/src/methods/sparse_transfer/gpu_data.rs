//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// How the environment stands.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Environment {
    pub(super) sin_rotation: f32,
    pub(super) cos_rotation: f32,
    /// What a stored 1 is worth.
    pub(super) unit: f32,
    /// Texels along a side of the cube's faces.
    pub(super) face_size: u32,
    /// Look-ups along a side of a texel of the cube.
    pub(super) points: u32,
}

/// A band of the film as the camera sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct View {
    pub(super) eye_in_world: [f32; 3],
    pub(super) near: f32,
    pub(super) forward: [f32; 3],
    pub(super) band_middle: f32,
    pub(super) right: [f32; 3],
    pub(super) band_reach: f32,
    pub(super) up: [f32; 3],
    pub(super) first_row: f32,
    pub(super) gain: [f32; 3],
    pub(super) width: f32,
    pub(super) height: f32,
    pub(super) unused: [f32; 3],
}

/// What a mesh is drawn with.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Material {
    pub(super) albedo: [f32; 3],
    pub(super) alpha_cutoff: f32,
    pub(super) wrap: [u32; 2],
    pub(super) textured: u32,
    pub(super) unused: u32,
}

/// One dispatch over a band of columns.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Dispatch {
    pub(super) vertices: u32,
    /// Runs that have arrived.
    pub(super) runs: u32,
    pub(super) channels: u32,
    /// 1 to add to what is there, 0 to overwrite it.
    pub(super) accumulate: u32,
    /// What a stored 1 is worth.
    pub(super) unit: f32,
}

/// Consecutive columns of one block; offsets are in words from the start of their band.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Run {
    pub(super) terms: u32,
    /// 1 if values are 16-bit integers, 0 for bytes.
    pub(super) wide: u32,
    pub(super) indices: u32,
    pub(super) values: u32,
    pub(super) scales: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    /// Size and (member, offset) pairs of a struct.
    type Layout = (usize, Vec<(&'static str, usize)>);

    macro_rules! layout_of {
        ($type:ident { $($field:ident),* } $($unused:ident)?) => {{
            // Naming every field makes a forgotten one a compile error.
            let $type { $($field: _,)* $($unused: _)? } = $type::zeroed();
            (size_of::<$type>(), vec![$((stringify!($field), offset_of!($type, $field))),*])
        }};
    }

    #[track_caller]
    fn expect(shader: &str, name: &str, (size, members): &Layout) {
        let module = naga::front::wgsl::parse_str(shader).unwrap();
        let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
        let naga::TypeInner::Struct { members: theirs, span } = &found.inner else { panic!("no struct") };
        let theirs: Vec<_> = theirs.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
        assert_eq!((theirs.as_slice(), *span as usize), (members.as_slice(), *size), "{name}");
    }

    #[test]
    fn the_structs_have_the_shaders_layout() {
        let view =
            layout_of!(View { eye_in_world, near, forward, band_middle, right, band_reach, up, first_row, gain, width, height } unused);
        for shader in [super::super::ENVIRONMENT, super::super::DRAW] {
            expect(shader, "View", &view);
        }
        let environment = layout_of!(Environment { sin_rotation, cos_rotation, unit, face_size, points });
        expect(super::super::ENVIRONMENT, "Environment", &environment);
        expect(super::super::DRAW, "Material", &layout_of!(Material { albedo, alpha_cutoff, wrap, textured } unused));
        expect(super::super::ACCUMULATE, "Dispatch", &layout_of!(Dispatch { vertices, runs, channels, accumulate, unit }));
        expect(super::super::ACCUMULATE, "Run", &layout_of!(Run { terms, wide, indices, values, scales }));
    }
}
