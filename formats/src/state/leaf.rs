//! What a state file has for a key of a material: a number or colour, or the file of a texture.

use super::{MaterialState, Rgb};
use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

/// By what name readers of files are asked for one. They say which it is: [`Visitor::visit_str`] for a file,
/// [`Visitor::visit_some`] for a value, so that their messages about values are their own.
pub(super) const LEAF: &str = "texture or value";

/// Whether `text` names a file: something with an ending that is no number.
pub(super) fn is_file(text: &str) -> bool {
    let ending = Path::new(text).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ending.starts_with(|c: char| c.is_ascii_alphabetic()))
}

/// The keys of a material, as files have them.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Leaves {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    kd: Option<Leaf<Rgb>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ks: Option<Leaf<Rgb>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shininess: Option<Leaf<f32>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fresnel: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    base_color: Option<Leaf<Rgb>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    metallic: Option<Leaf<f32>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    roughness: Option<Leaf<f32>>,
}

enum Leaf<T> {
    Value(T),
    File(String),
}

impl From<Leaves> for MaterialState {
    fn from(leaves: Leaves) -> Self {
        let mut textures = BTreeMap::new();
        let Leaves { kd, ks, shininess, fresnel, base_color, metallic, roughness } = leaves;
        Self {
            kd: value(kd, "kd", &mut textures),
            ks: value(ks, "ks", &mut textures),
            shininess: value(shininess, "shininess", &mut textures),
            fresnel,
            base_color: value(base_color, "base_color", &mut textures),
            metallic: value(metallic, "metallic", &mut textures),
            roughness: value(roughness, "roughness", &mut textures),
            textures,
        }
    }
}

fn value<T>(
    leaf: Option<Leaf<T>>,
    key: &'static str,
    textures: &mut BTreeMap<&'static str, String>,
) -> Option<T> {
    match leaf? {
        Leaf::Value(value) => Some(value),
        Leaf::File(file) => {
            textures.insert(key, file);
            None
        }
    }
}

impl From<MaterialState> for Leaves {
    fn from(mut state: MaterialState) -> Self {
        Self {
            kd: leaf(state.kd, state.textures.remove("kd")),
            ks: leaf(state.ks, state.textures.remove("ks")),
            shininess: leaf(state.shininess, state.textures.remove("shininess")),
            fresnel: state.fresnel,
            base_color: leaf(state.base_color, state.textures.remove("base_color")),
            metallic: leaf(state.metallic, state.textures.remove("metallic")),
            roughness: leaf(state.roughness, state.textures.remove("roughness")),
        }
    }
}

fn leaf<T>(value: Option<T>, file: Option<String>) -> Option<Leaf<T>> {
    file.map(Leaf::File).or(value.map(Leaf::Value))
}

impl<T: Serialize> Serialize for Leaf<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::File(file) => file.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Leaf<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_newtype_struct(LEAF, OfLeaf(PhantomData))
    }
}

struct OfLeaf<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OfLeaf<T> {
    type Value = Leaf<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("numbers or the file of a texture")
    }

    fn visit_str<E: Error>(self, file: &str) -> Result<Leaf<T>, E> {
        Ok(Leaf::File(file.to_owned()))
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Leaf<T>, D::Error> {
        T::deserialize(deserializer).map(Leaf::Value)
    }

    /// Of readers that do not know leaves, such as those of the values of animations.
    fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<Leaf<T>, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "invalid type, expected numbers or the file of a texture")]
        enum Either<T> {
            Value(T),
            File(String),
        }
        Ok(match Either::deserialize(deserializer)? {
            Either::Value(value) => Leaf::Value(value),
            Either::File(file) => Leaf::File(file),
        })
    }
}
