//! The method's line in the registry.

use super::inspected::INSPECTED;
use super::method::{Asked, SphereShadowsMethod};
use crate::methods::environment_lit;
use crate::methods::registered::{Bundled, Registered};
use relume_formats::bundle::{Maps, expect_lit, expect_receivers};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SphereShadows;
use relume_formats::method::SPHERE_SHADOWS;
use relume_formats::shape::DeformingMesh;
use relume_formats::{Error, Place, Result};
use std::path::PathBuf;

/// See there.
pub const METHOD: Registered = Registered {
    card: &SPHERE_SHADOWS,
    why: "shapes vary, and no other method's shadows follow them",
    options: &[],
    new: |asked, scene| Box::new(SphereShadowsMethod::new(scene, asked.seed, Asked::Error(asked.max_error))),
    remedy: |_| "cut meshes finer where shadows end".to_owned(),
    verify,
    inspected: &[INSPECTED],
};

fn verify(bundle: &Bundled<'_>, files: &[(Kind, PathBuf)]) -> Result<Maps> {
    let Bundled { scene, objects, settings } = bundle;
    let mut shapes = scene.meta.shapes.iter();
    environment_lit::verify(bundle, files, |kind, path, lit| {
        let place = Place::file(path);
        let refused =
            |reason: String| Error::invalid(&place, format!("{reason}; bake the whole bundle again"));
        if kind == Kind::Shape {
            let shape = DeformingMesh::read_file(path)?;
            let stored = shapes.next().ok_or_else(|| refused("is a shape of no object".to_owned()))?;
            return objects.expect_shape(&shape, stored, scene, &place);
        }
        let shadows = SphereShadows::read_file(path)?;
        expect_lit("lobes", shadows.meta.vertices(), scene, &lit.maps, lit.textured, &place)?;
        expect_receivers(&shadows, scene, objects, &place)?;
        settings.expect_objects(&scene.meta, objects)?;
        let missing = shapes.next();
        missing.map_or(Ok(()), |shape| {
            Err(refused(format!("needs the shape of object `{}` before it", shape.object)))
        })
    })
}
