// The frame of a vertex.
struct Frame {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
    normal: vec3<f32>,
}

// About a unit vector; the GPU twin of glam's `any_orthonormal_pair`, which tells 0 from −0.
fn frame_about(normal: vec3<f32>) -> Frame {
    let sign = select(1.0, -1.0, (bitcast<u32>(normal.z) & 0x80000000u) != 0u);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    return Frame(
        vec3<f32>(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        vec3<f32>(b, sign + normal.y * normal.y * a, -normal.y),
        normal,
    );
}

fn world_from_frame(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return v.x * frame.tangent + v.y * frame.bitangent + v.z * frame.normal;
}

fn frame_from_world(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(v, frame.tangent), dot(v, frame.bitangent), dot(v, frame.normal));
}
