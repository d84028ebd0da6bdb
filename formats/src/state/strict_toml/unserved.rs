//! Parts of a state that are known, but that no method of this version supports. They are refused as what
//! they are, not as unknown.

use super::hints::short;
use crate::state::leaf::is_file;
use crate::state::numbers_of;
use toml::de::DeValue;

/// The keys by which a state is known, and each of an animation's.
const STATE: &[&str] = &["environment", "camera", "view", "lights", "materials", "shapes"];
/// Those of a light of a state.
const LIGHT: &[&str] = &["gain"];
/// Those of a material of a state.
const MATERIAL: &[&str] = &["kd", "ks", "shininess", "fresnel", "base_color", "metallic", "roughness"];

/// What to do where a key belongs to a model that no method supports.
const THE_MODELS: &str =
    "remove it, as materials are of the models \"blinn-phong\", \"ggx\" and \"cook-torrance\"";

/// Where what stands, what it is, and what to do.
type Key = (&'static [&'static str], &'static str, &'static str, &'static str);

const KEYS: [Key; 7] = [
    (STATE, "objects", "the place of objects", "remove it, or move them in scene.toml and bake again"),
    (
        STATE,
        "media",
        "the refracting and scattering media within objects",
        "remove it, as surfaces are opaque",
    ),
    (LIGHT, "transform", "the place of a light", "remove it, or move the light in scene.toml and bake again"),
    (
        LIGHT,
        "radiance",
        "the emission of an area light",
        "write `gain`, a factor on it, or set it in scene.toml and bake again",
    ),
    (
        LIGHT,
        "size",
        "the size of an area light",
        "remove it, or scale the light in scene.toml and bake again",
    ),
    (MATERIAL, "reflectivity", "the reflectance of the model \"mirror\"", THE_MODELS),
    (MATERIAL, "gloss_deg", "the blur of the model \"mirror\"", THE_MODELS),
];

/// The models of materials that no method supports.
const MODELS: [&str; 1] = ["mirror"];

/// Why `key`, whose value is `value`, is refused where `expected` may stand, if it is known.
pub(super) fn of_key(key: &str, value: &DeValue<'_>, expected: &[&str]) -> Option<String> {
    if let Some(model) =
        value.as_str().filter(|model| key == "brdf" && expected == MATERIAL && MODELS.contains(model))
    {
        return Some(refusal(&format!("\"{model}\""), "a model of materials", THE_MODELS));
    }
    let is_it = |(beside, name, ..): &&Key| {
        *name == key && if *beside == STATE { expected.ends_with(STATE) } else { *beside == expected }
    };
    KEYS.iter().find(is_it).map(|(_, _, what, remedy)| refusal(&format!("`{key}`"), what, remedy))
}

/// Why `value` is refused as the value of `key`, if it is known: a texture where a material has numbers alone,
/// in a scene or for a key that has no textures.
pub(super) fn of_value(key: &str, value: &DeValue<'_>) -> Option<String> {
    let file = value.as_str().filter(|text| MATERIAL.contains(&key) && is_file(text))?;
    let (why, remedy) = match key {
        "fresnel" => ("which is the same all over a material", ""),
        "kd" | "base_color" => {
            ("which states may have where materials are painted", ", or name the file by `texture`")
        }
        _ => ("which states may have where materials are painted", ""),
    };
    Some(format!("\"{}\" is a texture for `{key}`, {why}; write {}{remedy}", short(file), numbers_of(key)))
}

fn refusal(which: &str, what: &str, remedy: &str) -> String {
    format!("{which} is {what}, which no method of this version supports; {remedy}")
}
