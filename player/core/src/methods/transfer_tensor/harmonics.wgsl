// Real spherical harmonics of four bands: the GPU twin of `relume_formats::basis::sh`.

// The radiance that coefficients give in a unit direction, each band times a component of `scale`.
fn radiance_of(harmonics: ptr<function, array<vec3<f32>, 16>>, direction: vec3<f32>, scale: vec4<f32>) -> vec3<f32> {
    let x = direction.x;
    let y = direction.y;
    let z = direction.z;
    let sin2 = x * y;
    let cos2 = x * x - y * y;
    let zz = z * z;
    let linear = 0.4886025 * (y * (*harmonics)[1] + z * (*harmonics)[2] + x * (*harmonics)[3]);
    let quadratic = 1.0925484 * (sin2 * (*harmonics)[4] + y * z * (*harmonics)[5] + x * z * (*harmonics)[7])
        + 0.31539157 * (3.0 * zz - 1.0) * (*harmonics)[6] + 0.5462742 * cos2 * (*harmonics)[8];
    let cubic = 0.5900436 * (y * (3.0 * x * x - y * y) * (*harmonics)[9] + x * (x * x - 3.0 * y * y) * (*harmonics)[15])
        + 0.4570458 * (5.0 * zz - 1.0) * (y * (*harmonics)[11] + x * (*harmonics)[13])
        + 2.8906114 * sin2 * z * (*harmonics)[10] + 0.37317633 * z * (5.0 * zz - 3.0) * (*harmonics)[12]
        + 1.4453057 * z * cos2 * (*harmonics)[14];
    return scale.x * 0.2820948 * (*harmonics)[0] + scale.y * linear + scale.z * quadratic + scale.w * cubic;
}
