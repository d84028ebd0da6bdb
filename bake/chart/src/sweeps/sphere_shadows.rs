//! The settings of the method on the chart: spheres, terms, and levels of visibility.

use crate::sweep::{Bench, Sweep, Variant, read};
use relume_bake::error::Result;
use relume_bake::methods::sphere_shadows::{METHOD, NAME, SphereShadowsMethod};
use relume_formats::kinds::SphereShadows;
use relume_scenes::Scene;
use serde_json::json;
use std::collections::BTreeMap;

/// The method's line among the sweeps.
pub const SWEEP: Sweep = Sweep { method: &METHOD, variants };

/// Spheres of every object that has some.
const SPHERES: [u32; 4] = [16, 32, 64, 128];
/// Spheres of the variants that differ in something else.
const SOME: u32 = 64;
/// Terms of light and lobes; the last are the bake's.
const TERMS: [u32; 3] = [50, 100, 200];

fn variants(scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let mut variants = Vec::new();
    for spheres in SPHERES {
        let mut scene = scene.clone();
        scene
            .objects
            .iter_mut()
            .filter_map(|object| object.spheres.as_mut())
            .for_each(|number| *number = spheres);
        let baked = bench.bake(
            &scene,
            Box::new(SphereShadowsMethod::new(&scene, 0)),
            &format!("{NAME}-{spheres}"),
        )?;
        let whole: SphereShadows = read(&baked.folder)?;
        for (terms, second_level) in TERMS.into_iter().flat_map(|terms| [(terms, false), (terms, true)]) {
            let is_whole = (terms, second_level) == (whole.meta.terms, whole.meta.second_level);
            if spheres != SOME && !is_whole {
                continue;
            }
            let level = if second_level { "II" } else { "I" };
            let folder = if is_whole {
                baked.folder.clone()
            } else {
                let mut cut = whole.clone();
                (cut.meta.terms, cut.meta.second_level) = (terms, second_level);
                bench.cut(&baked.folder, &format!("{NAME}-{spheres}-{terms}-{level}"), |file| {
                    file.replace(&cut)
                })?
            };
            let settings = [
                ("spheres", json!(spheres)),
                ("terms", json!(terms)),
                ("levels", json!(if second_level { 2 } else { 1 })),
            ];
            let settings: BTreeMap<_, _> = settings.map(|(name, value)| (name.to_owned(), value)).into();
            let (series, label) = if is_whole {
                ("spheres".to_owned(), format!("{spheres} spheres"))
            } else {
                (format!("level {level}"), format!("{spheres} spheres, {terms} terms, {level}"))
            };
            variants.push(Variant {
                method: NAME,
                series,
                label,
                settings,
                folder,
                bake_seconds: baked.seconds,
            });
        }
    }
    Ok(variants)
}
