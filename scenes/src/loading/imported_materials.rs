//! The materials of all glTF files of a scene: a name for each that no other has, and what the scene file
//! changes of them.

use crate::description::MaterialFile;
use crate::geometry::GltfMaterial;
use crate::scene::Material;
use relume_formats::{Error, Place, Result};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Materials met so far.
pub(super) struct Materials<'a> {
    /// Those of the scene file.
    described: &'a BTreeMap<String, MaterialFile>,
    /// By name, with the file that it was met in.
    known: HashMap<String, (GltfMaterial, PathBuf)>,
    /// Names by file, number in the file, and whether what wears it has texture coordinates.
    names: HashMap<(PathBuf, usize, bool), String>,
    /// Names of those that surfaces wear.
    worn: HashSet<String>,
    /// What surfaces wear, in order of first use.
    materials: Vec<Material>,
}

impl<'a> Materials<'a> {
    pub fn new(described: &'a BTreeMap<String, MaterialFile>) -> Self {
        Self {
            described,
            known: HashMap::new(),
            names: HashMap::new(),
            worn: HashSet::new(),
            materials: Vec::new(),
        }
    }

    /// The name in the scene of material `number` of the file at `path`, which calls it `name`: its own, or a
    /// numbered one if that stands for another material. Without texture coordinates (`has_uvs`) a surface
    /// wears it without its texture. Adds both to `warnings`.
    pub fn scene_name(
        &mut self,
        path: &Path,
        number: usize,
        name: &str,
        source: &GltfMaterial,
        has_uvs: bool,
        warnings: &mut Vec<String>,
    ) -> String {
        let key = (path.to_path_buf(), number, has_uvs);
        if let Some(known) = self.names.get(&key) {
            return known.clone();
        }
        let mut material = source.clone();
        if !has_uvs && material.material.texture.is_some() && !self.is_replaced(name) {
            (material.material.texture, material.material.alpha_cutoff) = (None, None);
            let path = path.display();
            warnings.push(format!(
                "{path}: material `{name}`: has a texture, but some that wear it have no texture coordinates; they go without"
            ));
        }
        let numbered = (2..).map(|number| format!("{name}-{number}"));
        for candidate in std::iter::once(name.to_owned()).chain(numbered) {
            material.material.name.clone_from(&candidate);
            match self.known.get(&candidate) {
                Some((same, _)) if *same == material => {}
                Some(_) => continue,
                None => drop(self.known.insert(candidate.clone(), (material, path.to_path_buf()))),
            }
            self.tell_of_new_name(name, &candidate, path, warnings);
            self.names.insert(key, candidate.clone());
            return candidate;
        }
        name.to_owned()
    }

    fn tell_of_new_name(&self, name: &str, new: &str, path: &Path, warnings: &mut Vec<String>) {
        if let Some((_, other)) = self.known.get(name).filter(|_| new != name) {
            let (path, other) = (path.display(), other.display());
            warnings.push(format!(
                "{path}: material `{name}` differs from the one of this name in {other}; called it `{new}`"
            ));
        }
    }

    /// True if the scene file describes material `name` whole, which replaces all of a file's.
    pub fn is_replaced(&self, name: &str) -> bool {
        self.described.get(name).is_some_and(|file| file.brdf.is_some())
    }

    /// What the scene file multiplies the emission of material `name` with.
    pub fn emission(&self, name: &str) -> f32 {
        self.described.get(name).and_then(|file| file.emission).unwrap_or(1.0)
    }

    /// Something wears material `name`.
    pub fn wear(&mut self, name: &str) {
        if !self.is_replaced(name) && self.worn.insert(name.to_owned()) {
            self.materials.extend(self.known.get(name).map(|(source, _)| source.material.clone()));
        }
    }

    /// The materials that surfaces wear, those apart that the scene file describes whole.
    ///
    /// # Errors
    /// If the scene file scales the emission of a material that emits nothing.
    pub fn finish(self, place: &Place) -> Result<Vec<Material>> {
        for (name, (source, _)) in &self.known {
            let scaled =
                self.described.get(name).is_some_and(|file| file.brdf.is_none() && file.emission.is_some());
            if scaled && source.emission == [0.0; 3] {
                let place = place.part(format!("material `{name}`"));
                return Err(Error::invalid(
                    &place,
                    "has `emission`, but emits nothing that it could scale; remove the key",
                ));
            }
        }
        Ok(self.materials)
    }
}
