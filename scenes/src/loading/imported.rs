//! What glTF files bring besides geometry: the `[[object]]`s that name no material wear the file's, and its lights shine.

use super::Context;
use super::imported_lights::punctual_lights;
use super::lights::expect_radiometric;
use super::objects::{path_of, place_of};
use crate::description::{MaterialFile, ObjectFile};
use crate::geometry::{GltfFile, GltfMaterial, MeshBuilder, is_gltf, read_materials};
use crate::scene::{Emitter, Light, Material, Mesh};
use relume_formats::state::Brdf;
use relume_formats::{Error, Place, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The part of an object that wears one of the file's materials.
pub(super) struct ImportedObject {
    /// `<object>/<material>`.
    pub name: String,
    /// Name of the material.
    pub material: String,
    /// In world space.
    pub mesh: Arc<Mesh>,
}

/// What all glTF files of a scene bring.
#[derive(Default)]
pub(super) struct Imported {
    /// Materials that reflect, each once.
    pub materials: Vec<Material>,
    /// For each `[[object]]`, the objects that stand for it; none if it names its material.
    pub objects: Vec<Vec<ImportedObject>>,
    /// Lights; names may occur more than once.
    pub lights: Vec<Light>,
}

/// Reads the files of all objects that name no material. `described` are the materials of the scene file.
pub(super) fn read(files: &[ObjectFile], described: &BTreeMap<String, MaterialFile>, context: &mut Context<'_>) -> Result<Imported> {
    let mut import = Import { described, known: BTreeMap::new(), imported: Imported::default() };
    for file in files {
        let objects = if file.material.is_some() { Vec::new() } else { import.object(file, context)? };
        for part in &objects {
            context.room.take(part.mesh.positions.len() as u64, part.mesh.triangles.len() as u64, &place_of(file, context))?;
        }
        import.imported.objects.push(objects);
    }
    Ok(import.imported)
}

struct Import<'a> {
    described: &'a BTreeMap<String, MaterialFile>,
    /// Every material met, and the file it was met in.
    known: BTreeMap<String, (GltfMaterial, PathBuf)>,
    imported: Imported,
}

impl Import<'_> {
    fn object(&mut self, object: &ObjectFile, context: &mut Context<'_>) -> Result<Vec<ImportedObject>> {
        let place = place_of(object, context);
        let needs_material = || Error::invalid(&place, "needs a `material`; only a glTF file brings its own");
        let path = path_of(object.file.as_ref().ok_or_else(needs_material)?, &place, context)?;
        if !is_gltf(&path) {
            return Err(needs_material());
        }
        let file = GltfFile::open(&path)?;
        if context.shapes_vary && file.document.animations().len() > 0 {
            context.warnings.push(format!("{place}: brings its materials, so that it does not deform; give it a `material` to let it"));
        }
        let nodes = file.nodes(object.node.as_deref(), &object.transform.world_from_local(&place)?)?;
        let meshes = file.meshes_by_material(&nodes, &mut context.warnings)?;
        let names: Vec<String> = meshes.iter().map(|(name, _)| name.clone()).collect();
        for (name, material) in read_materials(&file, &names, &mut context.textures, &mut context.warnings)? {
            self.remember(name, material, &path)?;
        }
        let before = self.imported.lights.len();
        if object.lights != Some(false) {
            self.imported.lights.extend(punctual_lights(&file, &nodes.wanted, &mut context.warnings)?);
        }
        let mut objects = Vec::new();
        for (material, builder) in meshes {
            objects.extend(self.surface(object, &material, builder, &path, context)?);
        }
        if objects.is_empty() && self.imported.lights.len() == before {
            return Err(Error::invalid(
                &place,
                format!("{} brings neither a surface nor a light; check the file, or `node`", path.display()),
            ));
        }
        Ok(objects)
    }

    /// A name stands for one material in the whole scene.
    fn remember(&mut self, name: String, material: GltfMaterial, path: &Path) -> Result<()> {
        match self.known.get(&name) {
            Some((same, _)) if *same == material => {}
            Some((_, other)) => {
                let reason = format!("material `{name}` differs from the one of this name in {}; rename one of them", other.display());
                return Err(Error::invalid(&Place::file(path), reason));
            }
            None => {
                self.known.insert(name, (material, path.to_path_buf()));
            }
        }
        Ok(())
    }

    /// The part of `object` that wears `name`: an object that reflects, or a light.
    fn surface(
        &mut self,
        object: &ObjectFile,
        name: &str,
        builder: MeshBuilder,
        path: &Path,
        context: &mut Context<'_>,
    ) -> Result<Option<ImportedObject>> {
        let place = Place::file(path).part(format!("material `{name}`"));
        let Some((source, _)) = self.known.get(name) else { return Ok(None) };
        let described = self.described.get(name);
        // A material that the scene file describes whole replaces all of the file's.
        let replaced = described.is_some_and(|file| file.brdf.is_some());
        if source.invisible && !replaced {
            context.warnings.push(format!("{place}: its mask leaves nothing of it, its surfaces are left out"));
            return Ok(None);
        }
        let full_name = format!("{}/{name}", object.name);
        let emits = source.emission != [0.0; 3] && !replaced;
        if emits && described.is_some() {
            return Err(Error::invalid(
                &place,
                "emits light and reflects none; give [materials] its `brdf` too to make it reflect instead",
            ));
        }
        if emits && object.lights == Some(false) {
            context.warnings.push(format!("{place}: emits light, which `lights = false` leaves out with its surfaces"));
            return Ok(None);
        }
        let mesh = Arc::new(builder.finish(&place, &mut context.warnings)?);
        if emits {
            expect_radiometric(source.emission, "emissive factor times strength", &place)?;
            if !is_black(&source.material.brdf) {
                context.warnings.push(format!("{place}: emits light, so that its base colour reflects none"));
            }
            self.imported.lights.push(Light { name: full_name, emitter: Emitter::Mesh { mesh, radiance: source.emission } });
            return Ok(None);
        }
        if !replaced && !self.imported.materials.iter().any(|m| m.name == name) {
            self.imported.materials.push(source.material.clone());
        }
        Ok(Some(ImportedObject { name: full_name, material: name.to_owned(), mesh }))
    }
}

fn is_black(brdf: &Brdf) -> bool {
    matches!(brdf, Brdf::Ggx(ggx) if ggx.base_color == [0.0; 3])
}
