// The number of an invocation over all workgroups of `lanes` each, which `Gpu::workgroups` lays out in rows.
fn invocation(group: vec3<u32>, groups: vec3<u32>, lanes: u32, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * lanes + lane;
}
