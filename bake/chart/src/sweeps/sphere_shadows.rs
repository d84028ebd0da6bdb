//! The settings of the method on the chart: what casts shadows, terms, and levels of visibility.

use crate::sweep::{Bench, Sweep, Variant, read};
use relume_bake::error::Result;
use relume_bake::methods::sphere_shadows::{Asked, METHOD, NAME, SphereShadowsMethod};
use relume_formats::kinds::SphereShadows;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The method's line among the sweeps.
pub const SWEEP: Sweep = Sweep { method: &METHOD, variants };

/// Spheres of every object that has some.
const SPHERES: [u32; 4] = [16, 32, 64, 128];
/// Triangles of every object.
const TRIANGLES: [u32; 5] = [64, 128, 256, 512, 1024];
/// Triangles of the variants that differ in something else.
const SOME: u32 = 256;
/// Terms of light and lobes; the last are the bake's.
const TERMS: [u32; 3] = [50, 100, 200];

fn variants(scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let mut variants = Vec::new();
    let with_spheres = scene.objects.iter().any(|object| object.spheres.is_some());
    for spheres in SPHERES.into_iter().filter(|_| with_spheres) {
        let mut scene = scene.clone();
        let asked = scene.objects.iter_mut().filter_map(|object| object.spheres.as_mut());
        asked.for_each(|number| *number = spheres);
        variants.push(whole(&scene, bench, ("spheres", spheres), Asked::Spheres)?);
    }
    for triangles in TRIANGLES {
        let asked = Asked::Triangles(triangles as usize);
        let baked = whole(scene, bench, ("triangles", triangles), asked)?;
        if triangles == SOME {
            variants.extend(cuts(&baked, bench)?);
        }
        variants.push(baked);
    }
    let asked = Asked::Error(scene.max_error);
    let method = SphereShadowsMethod::new(scene, 0, asked);
    let baked = bench.bake(scene, Box::new(method), &format!("{NAME}-chosen"))?;
    variants.push(Variant {
        method: NAME,
        series: "as baked".to_owned(),
        label: "as baked".to_owned(),
        settings: BTreeMap::from([("max_error".to_owned(), json!(scene.max_error))]),
        folder: baked.folder,
        bake_seconds: baked.seconds,
    });
    Ok(variants)
}

/// A bake whose objects cast by so many of something.
fn whole(scene: &Scene, bench: &Bench<'_>, (what, count): (&str, u32), asked: Asked) -> Result<Variant> {
    let method = SphereShadowsMethod::new(scene, 0, asked);
    let baked = bench.bake(scene, Box::new(method), &format!("{NAME}-{what}-{count}"))?;
    let shadows: SphereShadows = read(&baked.folder)?;
    Ok(Variant {
        method: NAME,
        series: what.to_owned(),
        label: format!("{count} {what}"),
        settings: settings((what, count), shadows.meta.terms, shadows.meta.second_level),
        folder: baked.folder,
        bake_seconds: baked.seconds,
    })
}

fn settings((what, count): (&str, u32), terms: u32, second_level: bool) -> BTreeMap<String, Value> {
    let levels = if second_level { 2 } else { 1 };
    let all = [(what, count), ("terms", terms), ("levels", levels)];
    all.map(|(name, value)| (name.to_owned(), json!(value))).into()
}

/// `baked` with fewer terms and levels.
fn cuts(baked: &Variant, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let whole: SphereShadows = read(&baked.folder)?;
    let all = TERMS.into_iter().flat_map(|terms| [(terms, false), (terms, true)]);
    let others = all.filter(|which| *which != (whole.meta.terms, whole.meta.second_level));
    let cut = |(terms, second_level): (u32, bool)| {
        let level = if second_level { "II" } else { "I" };
        let mut cut = whole.clone();
        (cut.meta.terms, cut.meta.second_level) = (terms, second_level);
        let name = format!("{NAME}-{SOME}-{terms}-{level}");
        let folder = bench.cut(&baked.folder, &name, |file| file.replace(&cut))?;
        Ok(Variant {
            series: format!("level {level}"),
            label: format!("{}, {terms} terms, {level}", baked.label),
            settings: settings(("triangles", SOME), terms, second_level),
            folder,
            ..baked.clone()
        })
    };
    others.map(cut).collect()
}
