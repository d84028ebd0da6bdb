//! The structure of a glTF file. What is legal though the parser does not know it, and what other programs
//! often get wrong, is mended in the JSON before it is parsed; what asks for more than this version reads is
//! refused by its name.

use super::gltf_container::{Chunks, split};
use super::tidy_name;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::json::{Path as JsonPath, Root, Value};
use gltf::{Document, Semantic};
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;

/// The structure of a file, and what the parser leaves out of it.
pub(super) struct Structure {
    pub document: Document,
    pub binary: Option<Vec<u8>>,
    /// For nodes with EXT_mesh_gpu_instancing the numbers of the accessors that place their instances.
    pub instances: HashMap<usize, InstanceAccessors>,
    /// What is ignored or was mended, one line each.
    pub notes: Vec<String>,
}

/// Accessors of EXT_mesh_gpu_instancing.
#[derive(Default, Clone, Copy)]
pub(super) struct InstanceAccessors {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

const INSTANCING: &str = "EXT_mesh_gpu_instancing";
const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: &str = "EXT_meshopt_compression";
const POINTER: &str = "KHR_animation_pointer";

/// Extensions whose content is used; a file may use others, which are named in a warning, but may not require
/// them.
const READ: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    // Lit like others, with a warning for those that are worn.
    "KHR_materials_unlit",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    INSTANCING,
];

/// Reads the structure of the file whose content is `bytes`.
pub(super) fn parse(bytes: &[u8], place: &Place) -> Result<Structure> {
    let Chunks { json, binary } = split(bytes, place)?;
    let mut json: Value = serde_json::from_slice(json).map_err(|e| {
        Error::invalid(
            place,
            format!("not a glTF 2.0 file ({e}); export it again, or save it as .gltf or .glb"),
        )
    })?;
    expect_version(&mut json, place)?;
    let strange = expect_known_extensions(&json, place)?;
    expect_data(&json, place)?;
    let mut notes = Vec::new();
    if !strange.is_empty() {
        notes.push(format!("the file uses {}, which is ignored", strange.join(", ")));
    }
    tidy(&mut json);
    mend(&mut json, &mut notes);
    let instances = instances(&json);
    let root = Root::deserialize(&json).map_err(|e| misfit(&json, &e, place))?;
    validate(&root, place)?;
    Ok(Structure {
        document: Document::from_json_without_validation(root),
        binary: binary.map(<[u8]>::to_vec),
        instances,
        notes,
    })
}

/// Makes text of a version that is written as a number. Files of 2.1 and so on are read, unless they say that
/// readers of 2.0 cannot.
fn expect_version(json: &mut Value, place: &Place) -> Result<()> {
    for version in ["/asset/version", "/asset/minVersion"] {
        if let Some(version) = json.pointer_mut(version).filter(|version| version.is_number()) {
            *version = Value::String(version.to_string());
        }
    }
    if let Some(least) = json
        .pointer("/asset/minVersion")
        .and_then(Value::as_str)
        .filter(|least| !["2", "2.0"].contains(least))
    {
        let reason = format!(
            "needs glTF of version {} (asset.minVersion), only 2.0 is read; export it as glTF 2.0",
            tidy_name(least)
        );
        return Err(Error::unsupported(place, reason));
    }
    match json.pointer("/asset/version").and_then(Value::as_str) {
        Some(version) if version.starts_with("2.") || version == "2" => Ok(()),
        Some(version) => {
            let reason = format!(
                "is glTF of version {}, only 2.0 is read; convert it to glTF 2.0",
                tidy_name(version)
            );
            Err(Error::unsupported(place, reason))
        }
        None => Err(Error::invalid(place, "not a glTF 2.0 file (it has no asset.version); export it again")),
    }
}

fn strings<'a>(json: &'a Value, key: &str) -> impl Iterator<Item = &'a str> {
    json.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

fn items<'a>(json: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    json.get(key).and_then(Value::as_array).into_iter().flatten()
}

fn items_mut<'a>(json: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    json.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

fn index(json: &Value, key: &str) -> Option<usize> {
    usize::try_from(json.get(key)?.as_u64()?).ok()
}

/// Fails if the file requires an extension that is not read. Returns the names of those that it uses and are
/// ignored.
fn expect_known_extensions(json: &Value, place: &Place) -> Result<Vec<String>> {
    match strings(json, "extensionsRequired").find(|name| !READ.contains(name)) {
        Some(name) => Err(unsupported_extension(name, "requires", place)),
        None => {
            Ok(strings(json, "extensionsUsed").filter(|name| !READ.contains(name)).map(tidy_name).collect())
        }
    }
}

/// Fails if vertices are there for an extension alone, though the file does not say that it requires it.
fn expect_data(json: &Value, place: &Place) -> Result<()> {
    let accessors = json.get("accessors").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let is_empty = |number: usize| {
        accessors.get(number).is_some_and(|a| a.get("bufferView").is_none() && a.get("sparse").is_none())
    };
    for primitive in items(json, "meshes")
        .flat_map(|mesh| items(mesh, "primitives"))
        .filter(|p| extension(p, DRACO).is_some())
    {
        let attributes =
            primitive.get("attributes").and_then(Value::as_object).into_iter().flat_map(|map| map.values());
        let mut used = attributes.chain(primitive.get("indices")).filter_map(Value::as_u64);
        if used.any(|number| is_empty(number as usize)) {
            return Err(unsupported_extension(DRACO, "stores vertices by", place));
        }
    }
    let is_fallback = |buffer: &Value| buffer.get("uri").is_none() && extension(buffer, MESHOPT).is_some();
    if items(json, "buffers").any(is_fallback) {
        return Err(unsupported_extension(MESHOPT, "stores vertices by", place));
    }
    Ok(())
}

fn extension<'a>(json: &'a Value, name: &str) -> Option<&'a Value> {
    json.get("extensions")?.get(name)
}

fn unsupported_extension(name: &str, verb: &str, place: &Place) -> Error {
    let command = match name {
        DRACO | MESHOPT | "KHR_meshopt_compression" => Some("copy"),
        "KHR_texture_basisu" => Some("ktxdecompress"),
        "EXT_texture_webp" => Some("png --formats webp"),
        "EXT_texture_avif" => Some("png --formats avif"),
        "KHR_materials_pbrSpecularGlossiness" => Some("metalrough"),
        _ => None,
    };
    let remedy = match command {
        Some(command) => format!("convert it by `npx @gltf-transform/cli {command} in.glb out.glb`"),
        None => "export it without".to_owned(),
    };
    Error::unsupported(place, format!("{verb} {}, which is not supported; {remedy}", tidy_name(name)))
}

/// Drops what has no meaning: `extras`, which may be anything, and nulls. Some programs write whole numbers
/// as 3.0, which the parser takes for no index.
fn tidy(json: &mut Value) {
    match json {
        Value::Array(values) => values.iter_mut().for_each(tidy),
        Value::Object(map) => {
            map.retain(|key, value| key != "extras" && !value.is_null());
            map.values_mut().for_each(tidy);
        }
        Value::Number(number) => {
            let whole = number
                .as_f64()
                .filter(|x| number.is_f64() && x.is_sign_positive() && x.fract() == 0.0 && *x < 9e15);
            if let Some(whole) = whole {
                *json = Value::from(whole as u64);
            }
        }
        _ => {}
    }
}

/// Drops and adds what lets the parser read it. Adds what is lost to `notes`.
fn mend(json: &mut Value, notes: &mut Vec<String>) {
    for primitive in items_mut(json, "meshes").flat_map(|mesh| items_mut(mesh, "primitives")) {
        if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
            attributes.retain(|name, _| is_known_attribute(name));
        }
    }
    for (list, key) in [("scenes", "nodes"), ("animations", "channels"), ("animations", "samplers")] {
        for object in items_mut(json, list).filter_map(Value::as_object_mut) {
            object.entry(key).or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let scenes = items(json, "scenes").count();
    if index(json, "scene").is_some_and(|default| default >= scenes)
        && let Some(root) = json.as_object_mut()
    {
        root.remove("scene");
        notes.push("its default scene is not there; took what there is".to_owned());
    }
    let mut dropped = 0;
    for channels in
        items_mut(json, "animations").filter_map(|animation| animation.get_mut("channels")?.as_array_mut())
    {
        let before = channels.len();
        channels.retain(moves_a_node);
        dropped += before - channels.len();
    }
    if dropped > 0 {
        notes.push(format!(
            "left out {} without a node to move",
            counted(dropped, "animation channel", "animation channels")
        ));
    }
}

/// Whether a channel animates a node rather than nothing, or something else by an extension.
fn moves_a_node(channel: &Value) -> bool {
    let Some(target) = channel.get("target") else { return true };
    target.get("node").is_some_and(|node| !node.is_null())
        && extension(target, POINTER).is_none()
        && target.get("path").and_then(Value::as_str) != Some("pointer")
}

/// Attributes of vertices that the specification names; programs may add their own.
fn is_known_attribute(name: &str) -> bool {
    let is_set = |prefix: &str| name.strip_prefix(prefix).is_some_and(|set| set.parse::<u32>().is_ok());
    ["POSITION", "NORMAL", "TANGENT"].contains(&name)
        || ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"].into_iter().any(is_set)
}

fn instances(json: &Value) -> HashMap<usize, InstanceAccessors> {
    let of = |(node, json): (usize, &Value)| {
        let attributes = extension(json, INSTANCING)?.get("attributes")?;
        let [translation, rotation, scale] =
            ["TRANSLATION", "ROTATION", "SCALE"].map(|name| index(attributes, name));
        Some((node, InstanceAccessors { translation, rotation, scale }))
    };
    items(json, "nodes").enumerate().filter_map(of).collect()
}

/// The error for JSON that is no glTF: which part of it the parser does not take.
fn misfit(json: &Value, error: &serde_json::Error, place: &Place) -> Error {
    use gltf::json;
    fn first<T: DeserializeOwned>(json: &Value, key: &str) -> Option<String> {
        items(json, key).position(|item| T::deserialize(item).is_err()).map(|at| format!("{key}[{at}]"))
    }
    let part = first::<json::Accessor>(json, "accessors")
        .or_else(|| first::<json::Animation>(json, "animations"))
        .or_else(|| first::<json::Buffer>(json, "buffers"))
        .or_else(|| first::<json::buffer::View>(json, "bufferViews"))
        .or_else(|| first::<json::Camera>(json, "cameras"))
        .or_else(|| first::<json::Image>(json, "images"))
        .or_else(|| first::<json::Material>(json, "materials"))
        .or_else(|| first::<json::Mesh>(json, "meshes"))
        .or_else(|| first::<json::Node>(json, "nodes"))
        .or_else(|| first::<json::texture::Sampler>(json, "samplers"))
        .or_else(|| first::<json::Scene>(json, "scenes"))
        .or_else(|| first::<json::Skin>(json, "skins"))
        .or_else(|| first::<json::Texture>(json, "textures"));
    let place = part.map_or_else(|| place.clone(), |part| place.part(part));
    let what = error.to_string().replace("index into child of root", "an index");
    Error::invalid(&place, format!("not a glTF 2.0 file ({what}); export it again"))
}

/// The parser's own checks, but for those of what is legal or does no harm.
fn validate(root: &Root, place: &Place) -> Result<()> {
    let attributes =
        root.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| &primitive.attributes);
    // The parser looks into the accessor of positions before it checks that there is one.
    let mut positions =
        attributes.filter_map(|attributes| attributes.get(&Checked::Valid(Semantic::Positions)));
    if let Some(stray) = positions.find(|index| index.value() >= root.accessors.len()) {
        let reason = format!(
            "not valid glTF (POSITION is accessor {}, of {}); export it again",
            stray.value(),
            root.accessors.len()
        );
        return Err(Error::invalid(place, reason));
    }
    let mut first = None;
    root.validate(root, JsonPath::new, &mut |path, fault| {
        if first.is_none() {
            first = Some((path().to_string(), fault)).filter(|(path, fault)| !is_harmless(path, *fault));
        }
    });
    first.map_or(Ok(()), |(part, fault)| {
        let what = match fault {
            Fault::IndexOutOfBounds => "it names what is not there",
            Fault::Invalid => "its value is none that glTF knows",
            Fault::Missing => "it is missing",
            Fault::Oversize => "it is too large",
            Fault::Unsupported => "it is not supported",
        };
        Err(Error::invalid(&place.part(part), format!("not valid glTF ({what}); export the file again")))
    })
}

/// Accessors without data are zeros, primitives without positions are not drawn, bounds are not used, and
/// textures without a picture that can be read are left out. Required extensions were looked at before.
fn is_harmless(path: &str, fault: Fault) -> bool {
    let missing = fault == Fault::Missing;
    fault == Fault::Unsupported
        || (missing && path.starts_with("accessors[") && path.ends_with("].bufferView"))
        || (missing && path.starts_with("textures[") && path.ends_with("].source"))
        || (missing && path.ends_with("attributes[\"POSITION\"]"))
        || path.ends_with("attributes[\"POSITION\"].min")
        || path.ends_with("attributes[\"POSITION\"].max")
}
