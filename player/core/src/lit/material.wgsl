// What a mesh is drawn with.
struct Material {
    // Diffuse reflectance.
    albedo: vec3<f32>,
    // Where alpha is below this, there is no surface.
    alpha_cutoff: f32,
    // How the texture goes on beyond its edge, along u and v: 0 it repeats, 1 it is mirrored, 2 its edge texels go on.
    wrap: vec2<u32>,
    // Texels of a row, and rows.
    size: vec2<u32>,
    // What multiplies the glossy lobe.
    specular: vec3<f32>,
    // Which reflectance model it has: a constant of the snippet `brdf`.
    model: u32,
    // How much facets reflect at normal incidence.
    f0: vec3<f32>,
    // Exponent of Blinn-Phong, glTF's perceptual roughness, or the slope of Cook and Torrance's facets.
    sharpness: f32,
    // In how many sizes there is a texture: 0 if there is none.
    levels: u32,
    // 1 if texels are sharp, 0 if one flows into the next.
    nearest: u32,
}
