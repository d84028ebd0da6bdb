//! Whether a struct of ours lies in memory as the shader's does.

/// Size and (member, offset) pairs of a struct.
pub(crate) type Layout = (usize, Vec<(&'static str, usize)>);

macro_rules! layout_of {
    ($type:ident { $($field:ident),* } $($unused:ident)?) => {{
        // Naming every field makes a forgotten one a compile error.
        let $type { $($field: _,)* $($unused: _)? } = <$type as bytemuck::Zeroable>::zeroed();
        (size_of::<$type>(), vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*])
    }};
}

pub(crate) use layout_of;

/// Fails unless the struct `name` of `shader` has this layout.
#[track_caller]
pub(crate) fn expect(shader: &str, name: &str, (size, members): &Layout) {
    let module = naga::front::wgsl::parse_str(&super::shader::expand(shader)).unwrap();
    let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members: theirs, span } = &found.inner else { panic!("no struct") };
    let theirs: Vec<_> = theirs.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
    assert_eq!((theirs.as_slice(), *span as usize), (members.as_slice(), *size), "{name}");
}
