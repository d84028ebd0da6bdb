//! What glTF files bring besides geometry: the `[[object]]`s that name no material wear the file's, and its
//! lights shine.

use super::Context;
use super::imported_lights::punctual_lights;
use super::imported_materials::Materials;
use super::objects::{path_of, place_of};
use crate::description::{MaterialFile, ObjectFile};
use crate::geometry::{GltfFile, MaterialPart, MaterialReader, is_gltf};
use crate::numbering::listed;
use crate::scene::{Emitter, Glow, Light, Material, Mesh};
use relume_formats::state::expect_radiometric;
use relume_formats::{Error, Place, Result};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The part of an object that wears one of the file's materials.
pub(super) struct ImportedObject {
    /// `<object>/<material>`; the object's own name if spheres are fitted to it, which there is one mesh of
    /// then.
    pub name: String,
    /// Name of the material.
    pub material: String,
    /// In world space.
    pub mesh: Arc<Mesh>,
}

/// What all glTF files of a scene bring.
#[derive(Default)]
pub(super) struct Imported {
    /// Each once.
    pub materials: Vec<Material>,
    /// For each `[[object]]`, the objects that stand for it; none if it names its material.
    pub objects: Vec<Vec<ImportedObject>>,
    /// Lights; names may occur more than once. Surfaces that emit are named by the index that their object
    /// has when all objects are in a row.
    pub lights: Vec<Light>,
}

/// Reads the files of all objects that name no material. `described` are the materials of the scene file.
pub(super) fn read(
    files: &[ObjectFile],
    described: &BTreeMap<String, MaterialFile>,
    context: &mut Context<'_>,
) -> Result<Imported> {
    let mut materials = Materials::new(described);
    let (mut objects, mut lights, mut before) = (Vec::new(), Vec::new(), 0);
    for file in files {
        let mut import = Import {
            object: file,
            path: PathBuf::new(),
            before,
            materials: &mut materials,
            lights: &mut lights,
            left_out: None,
        };
        let brought = if file.material.is_some() { Vec::new() } else { import.read(context)? };
        before += if file.material.is_some() { 1 } else { brought.len() };
        for part in &brought {
            context.room.take(
                part.mesh.positions.len() as u64,
                part.mesh.triangles.len() as u64,
                &place_of(file, context),
            )?;
        }
        objects.push(brought);
    }
    Ok(Imported { materials: materials.finish(&context.place)?, objects, lights })
}

/// An `[[object]]` being read.
struct Import<'a, 'b> {
    object: &'a ObjectFile,
    /// Its file.
    path: PathBuf,
    /// Objects of the scene that come before it.
    before: usize,
    materials: &'a mut Materials<'b>,
    lights: &'a mut Vec<Light>,
    /// The first reason why something of it is not there.
    left_out: Option<String>,
}

/// Spheres are fitted to one mesh.
fn expect_one(objects: &[ImportedObject], place: &Place) -> Result<()> {
    let materials: Vec<String> = objects.iter().map(|part| part.material.clone()).collect();
    match materials.len() {
        0 => Err(Error::invalid(
            place,
            "`spheres` are fitted to a surface, of which the file brings none; remove them, or check `node`",
        )),
        1 => Ok(()),
        count => {
            let (listed, remedy) =
                (listed(&materials), "give the object a `material`, or take parts of one material by `node`");
            let reason = format!(
                "`spheres` are fitted to one mesh, but the file brings one for each of {count} materials, {listed}; {remedy}"
            );
            Err(Error::invalid(place, reason))
        }
    }
}

impl Import<'_, '_> {
    fn read(&mut self, context: &mut Context<'_>) -> Result<Vec<ImportedObject>> {
        let (object, place) = (self.object, place_of(self.object, context));
        let needs_material = || Error::invalid(&place, "needs a `material`; only a glTF file brings its own");
        self.path = path_of(object.file.as_ref().ok_or_else(needs_material)?, &place, context)?;
        if !is_gltf(&self.path) {
            return Err(needs_material());
        }
        let file = GltfFile::open(&self.path, &mut context.warnings)?;
        if context.shapes_vary && file.document.animations().len() > 0 {
            context.warnings.push(format!(
                "{place}: brings its materials, so that it does not deform; give it a `material` to let it"
            ));
        }
        let nodes = file.nodes(
            object.node.as_deref(),
            &object.transform.world_from_local(&place)?,
            &mut context.warnings,
        )?;
        let parts = file.parts_by_material(&nodes, object.crease_deg, &mut context.warnings)?;
        let before = self.lights.len();
        if object.lights != Some(false) {
            self.lights.extend(punctual_lights(&file, &nodes.wanted, &mut context.warnings)?);
        }
        let mut objects = self.surfaces(&file, parts, context)?;
        if object.spheres.is_some() {
            expect_one(&objects, &place)?;
            // Files are called after it.
            objects.iter_mut().for_each(|part| part.name.clone_from(&object.name));
        }
        if objects.is_empty() && self.lights.len() == before {
            let file = self.path.display();
            let reason = match &self.left_out {
                Some(reason) => format!(
                    "nothing of {file} is left to show: {reason}; mend the file, or remove the object"
                ),
                None => format!("{file} brings neither a surface nor a light; check the file, or `node`"),
            };
            return Err(Error::invalid(&place, reason));
        }
        Ok(objects)
    }

    fn surfaces(
        &mut self,
        file: &GltfFile,
        parts: Vec<MaterialPart>,
        context: &mut Context<'_>,
    ) -> Result<Vec<ImportedObject>> {
        let Context { textures, warnings, .. } = context;
        let mut reader = MaterialReader::new(file, textures);
        let mut objects = Vec::new();
        for part in parts {
            let index = self.before + objects.len();
            objects.extend(self.surface(index, file, part, &mut reader, warnings)?);
        }
        reader.finish(warnings);
        Ok(objects)
    }

    /// What wears one of the file's materials; object `index` of the scene if there is anything of it.
    fn surface(
        &mut self,
        index: usize,
        file: &GltfFile,
        part: MaterialPart,
        reader: &mut MaterialReader<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<ImportedObject>> {
        let Some(source) = file.material_of(&part) else { return Ok(None) };
        let source = reader.read(&part.name, &source)?;
        let has_uvs = part.mesh.has_uvs();
        let name = self.materials.scene_name(&self.path, part.number, &part.name, &source, has_uvs, warnings);
        let place = Place::file(&self.path).part(format!("material `{name}`"));
        let replaced = self.materials.is_replaced(&name);
        let reason = match () {
            () if source.invisible && !replaced => Some("its mask leaves nothing of it"),
            () if !part.mesh.has_area() => Some("its triangles have no area"),
            () => None,
        };
        if let Some(reason) = reason {
            warnings.push(format!("{place}: {reason}, its surfaces are left out"));
            self.left_out.get_or_insert_with(|| format!("material `{name}`: {reason}"));
            return Ok(None);
        }
        let mesh = Arc::new(part.mesh.finish(&place, warnings)?);
        let full_name = format!("{}/{name}", self.object.name);
        let radiance = source.emission.map(|x| x * self.materials.emission(&name));
        if radiance != [0.0; 3] && !replaced && self.object.lights != Some(false) {
            expect_radiometric(radiance, "emissive factor times strength", &place)?;
            let glow_mesh =
                part.glow_mesh.map(|builder| builder.finish(&place, &mut Vec::new())).transpose()?;
            let uvs = &glow_mesh.as_ref().unwrap_or(&mesh).uvs;
            if source.glow.is_some() && uvs.is_empty() {
                warnings.push(format!(
                    "{place}: emits by a texture, but has no texture coordinates; what it emits is left out"
                ));
            } else {
                let glow = source.glow.map(|texture| Glow { texture, uvs: uvs.as_slice().into() });
                self.lights.push(Light {
                    name: full_name.clone(),
                    emitter: Emitter::Mesh { object: index, radiance, glow },
                });
            }
        }
        self.materials.wear(&name);
        Ok(Some(ImportedObject { name: full_name, material: name, mesh }))
    }
}
