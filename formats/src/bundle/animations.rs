//! Whether an animation can be played: it sets nothing but what varies, and all of it legally at every key.
//!
//! Every leaf is linear between its keys and every legal range is convex, so if the looks at all keys are
//! legal, all are, but for one thing that is not convex: a camera must not meet its target. What is legal
//! depends on one thing at a time, a material, a shape, the camera or the environment. So each is looked at
//! by itself, at its own keys, and an animation of many keys and tracks costs no more than it is long.

use super::{Look, Scope};
use crate::error::{Error, Place, Result};
use crate::kinds::scene::StoredShape;
use crate::state::{Animation, Camera, State, Track, Varies};
use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// Fails unless `animation`, at `place`, can be played on top of `base` within `scope`.
///
/// # Errors
/// `Invalid` with the time of the key at which something is set that does not vary, or to what is not legal.
pub fn expect_playable(animation: &Animation, base: &Look, scope: &Scope, place: &Place) -> Result<()> {
    let varies = scope.varies();
    let names = Names::new(&varies);
    let check =
        Check { base, scope, shapes: scope.scene.shapes.iter().map(|s| (s.object.as_str(), s)).collect() };
    for part in parts(animation) {
        let mut last: Option<Camera> = None;
        for time_s in part.key_times_s() {
            let place = place.part(format!("at {time_s} s"));
            let state = part.sample(time_s).map_err(|reason| Error::invalid(&place, reason))?;
            if !names.have(&part) {
                state.expect_only(&varies, &place)?;
            }
            check.expect_legal(&state, &place)?;
            let Some(change) = &state.camera else { continue };
            let camera = base.camera.with(change, &place)?;
            if last.is_some_and(|last| passes_its_target(&last, &camera)) {
                let reason =
                    "camera: on the way here the position meets the target; add a key that leads around it";
                return Err(Error::invalid(&place, reason));
            }
            last = Some(camera);
        }
    }
    Ok(())
}

/// Fails unless one of the methods of a bundle, which see the same scene by `scopes`, can play `animation`,
/// at `place`.
///
/// # Errors
/// `Invalid` with what the last of them does not play.
pub fn expect_some_plays(animation: &Animation, scopes: &[Scope], place: &Place) -> Result<()> {
    let mut verdict = Ok(());
    for scope in scopes {
        verdict = expect_playable(animation, &Look::default_of(&scope.scene), scope, place);
        if verdict.is_ok() {
            break;
        }
    }
    verdict
}

/// Whether an animation sets nothing but what varies.
pub fn sets_only(animation: &Animation, varies: &Varies<'_>) -> bool {
    let names = Names::new(varies);
    parts(animation).all(|part| names.have(&part))
}

/// The animation of each thing that is set.
fn parts(animation: &Animation) -> impl Iterator<Item = Animation> {
    let tracks = animation.tracks.chunk_by(|a, b| thing(a) == thing(b));
    tracks.map(|tracks| Animation { name: String::new(), tracks: tracks.to_vec(), ..*animation })
}

/// The names that lead to what a track sets: of a material and the like its own, too.
fn thing(track: &Track) -> &[String] {
    let names = if track.leaf.len() > 2 { 2 } else { 1 };
    track.leaf.get(..names).unwrap_or_default()
}

/// What varies, quick to ask.
struct Names<'a> {
    varies: &'a Varies<'a>,
    materials: HashSet<&'a str>,
    shapes: HashSet<&'a str>,
}

impl<'a> Names<'a> {
    fn new(varies: &'a Varies<'a>) -> Self {
        Self {
            varies,
            materials: varies.materials.iter().copied().collect(),
            shapes: varies.shapes.iter().copied().collect(),
        }
    }

    /// Whether all that the tracks set varies.
    fn have(&self, part: &Animation) -> bool {
        part.tracks.iter().all(|track| match &track.leaf[..] {
            [materials, name, _] if materials == "materials" => self.materials.contains(name.as_str()),
            [shapes, name, _] if shapes == "shapes" => self.shapes.contains(name.as_str()),
            [environment, _] if environment == "environment" => self.varies.environment,
            [camera, leaf] if camera == "camera" => self.varies.camera || leaf == "exposure_ev",
            [view, _] if view == "view" => true,
            _ => false,
        })
    }
}

/// A look and what it may become.
struct Check<'a> {
    base: &'a Look,
    scope: &'a Scope,
    shapes: HashMap<&'a str, &'a StoredShape>,
}

impl Check<'_> {
    /// What [`Look::apply`] checks, by the same rules; the camera is the caller's.
    fn expect_legal(&self, state: &State, place: &Place) -> Result<()> {
        for (name, change) in &state.materials {
            let index = self.base.materials.index_of(name);
            let material = index.and_then(|index| self.scope.scene.materials.get(index));
            if let (Some(material), Some(brdf)) = (material, self.base.materials.get(name)) {
                material.with(brdf, change, place)?;
            }
        }
        for (name, change) in &state.shapes {
            if let Some(shape) = self.shapes.get(name.as_str()) {
                shape.with(self.base.shapes.get(name), change, place)?;
            }
        }
        if let (Some(environment), Some(change)) = (&self.base.environment, &state.environment) {
            self.scope.environment(environment, change, place)?;
        }
        Ok(())
    }
}

/// Whether the way from target to position, linear between two moments, comes to nothing in between.
fn passes_its_target(from: &Camera, to: &Camera) -> bool {
    let way = |camera: &Camera| Vec3::from(camera.position) - Vec3::from(camera.target);
    let (from, to) = (way(from), way(to));
    from.dot(to) < 0.0 && from.cross(to).length() <= 1e-5 * from.length() * to.length()
}
