// Highlights of materials: the GPU twin of the glossy lobes of `relume_formats::state::Brdf`, with the terms of `relume_formats::basis::microfacet`.

#import material
#import pi

// Values of `Material::model`.
const BLINN_PHONG = 0u;
const GGX = 1u;
const COOK_TORRANCE = 2u;

// Below this cosine a direction is in the surface: light from there carries nothing.
const GRAZING = 1e-6;
// Where e⁻ˣ leaves the range of normal numbers.
const DARK = 87.0;

// Cosines between two directions, their half vector and the normal, all of them 0..=1.
struct Angles {
    // Between half vector and normal.
    cos_half: f32,
    // Between half vector and either direction.
    cos_difference: f32,
    // Between directions and normal.
    cos_in: f32,
    cos_out: f32,
}

// Of unit vectors, of which both directions point away from the surface.
fn angles_between(incoming: vec3<f32>, outgoing: vec3<f32>, normal: vec3<f32>) -> Angles {
    let sum = incoming + outgoing;
    let size = length(sum);
    let half_vector = sum / select(1.0, size, size > 0.0);
    return Angles(
        clamp(dot(half_vector, normal), 0.0, 1.0),
        clamp(dot(half_vector, outgoing), 0.0, 1.0),
        max(dot(incoming, normal), 0.0),
        max(dot(outgoing, normal), 0.0),
    );
}

// Schlick's weight (1 − v·h)⁵: how far Fresnel reflectance has gone from f0 to 1.
fn schlick(cos_difference: f32) -> f32 {
    let x = 1.0 - cos_difference;
    return x * x * x * x * x;
}

// (s + 2)/2π · cosˢδ, sr⁻¹.
fn blinn_phong(shininess: f32, angles: Angles) -> f32 {
    // A power of 0 is what its logarithm makes of it.
    let cosine = max(angles.cos_half, 1e-30);
    return 0.5 * FRAC_1_PI * (shininess + 2.0) * pow(cosine, shininess);
}

// Smith's masking of a direction, without its denominator.
fn smith(cosine: f32, alpha_squared: f32) -> f32 {
    return sqrt((1.0 - cosine * cosine) * alpha_squared + cosine * cosine);
}

// D·V of Trowbridge and Reitz's facets, masked and shadowed as Smith has it, sr⁻¹; α is the square of `roughness`.
fn distribution_visibility(roughness: f32, angles: Angles) -> f32 {
    let alpha_squared = roughness * roughness * (roughness * roughness);
    let half_squared = angles.cos_half * angles.cos_half;
    // sin² + α² cos², and not 1 + (α² − 1) cos², which cancels at the peak.
    let spread = (1.0 - half_squared) + alpha_squared * half_squared;
    let visibility = angles.cos_in * smith(angles.cos_out, alpha_squared) + angles.cos_out * smith(angles.cos_in, alpha_squared);
    if visibility <= 0.0 {
        return 0.0;
    }
    return 0.5 * FRAC_1_PI * alpha_squared / (spread * spread * visibility);
}

// D·V of Beckmann's facets of root mean square slope `slope`, in Cook and Torrance's V-shaped grooves, sr⁻¹.
fn beckmann_grooves(slope: f32, angles: Angles) -> f32 {
    let half_squared = angles.cos_half * angles.cos_half;
    let slope_squared = slope * slope;
    let higher = max(angles.cos_in, angles.cos_out);
    // tan²δ/m² as a comparison of products: at right angles there is no tangent.
    if (1.0 - half_squared) >= DARK * half_squared * slope_squared || higher <= GRAZING {
        return 0.0;
    }
    let tan_squared = (1.0 - half_squared) / half_squared;
    let inverse = 1.0 + tan_squared;
    let distribution = FRAC_1_PI * exp(-tan_squared / slope_squared) * inverse * inverse / slope_squared;
    // As v·h = (n·l + n·v)/(2 n·h), no cosine is left alone in the denominator of the second. The first is larger than that by far where it is cut off.
    let open = 0.25 / max(angles.cos_in * angles.cos_out, 1e-30);
    return distribution * min(open, half_squared / ((angles.cos_in + angles.cos_out) * higher));
}

// The glossy part of a material's BRDF, sr⁻¹: no texture colours it.
fn glossy_lobe(material: Material, angles: Angles) -> vec3<f32> {
    if material.model == BLINN_PHONG {
        return material.specular * blinn_phong(material.sharpness, angles);
    }
    let fresnel = material.f0 + (1.0 - material.f0) * schlick(angles.cos_difference);
    if material.model == GGX {
        return fresnel * distribution_visibility(material.sharpness, angles);
    }
    return material.specular * fresnel * beckmann_grooves(material.sharpness, angles);
}

// The diffuse part of a material's BRDF in parts of albedo/π: glTF's facets pass on what they do not reflect.
fn diffuse_lobe(material: Material, angles: Angles) -> f32 {
    return select(1.0, 1.0 - schlick(angles.cos_difference), material.model == GGX);
}
