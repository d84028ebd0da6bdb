//! What a scene needs: which methods serve what it varies, what baking with each will take, which one `bake
//! run` takes and what is left out then.

mod charted;
mod facts;
mod stored;
mod text;

use facts::{Candidate, Plan, Prediction, Varies};
use relume_bake::bundle;
use relume_bake::error::Result;
use relume_bake::job::{Job, ProgressMode};
use relume_bake::methods::asked::Asked;
use relume_bake::methods::choice::{METHODS, cheapest};
use relume_bake::methods::registered::Registered;
use relume_bake::playable;
use relume_formats::{Error, Place};
use relume_scenes::{Scene, Vary};
use std::path::Path;

/// Where bundles and charts of scenes are, each in a folder called as the scene.
#[derive(Debug, Clone, Copy)]
pub struct Folders<'a> {
    /// Bundles.
    pub bundles: &'a Path,
    /// Charts.
    pub charts: &'a Path,
}

/// The plan for `scene` and what is `asked` of methods, as text or as JSON. Figures of earlier bakes and charts are
/// sought in `folders`.
///
/// # Errors
/// If a part of the scene cannot be prepared for predictions, such as spheres of an object that encloses
/// nothing.
pub fn plan(scene: &Scene, asked: &Asked, folders: &Folders<'_>, json: bool) -> Result<String> {
    let plan = if varies_nothing(scene) { nothing(scene) } else { make(scene, asked, folders)? };
    if !json {
        return Ok(text::of(&plan));
    }
    let text = serde_json::to_string_pretty(&plan)
        .map_err(|e| Error::invalid(&Place::file(&scene.file), e.to_string()))?;
    Ok(text + "\n")
}

fn varies_nothing(scene: &Scene) -> bool {
    let vary = &scene.vary;
    !(vary.light || vary.view || vary.shape) && vary.materials.is_empty()
}

fn varies(scene: &Scene) -> Varies {
    let materials = scene.varying_names().into_iter().map(str::to_owned).collect();
    Varies { light: scene.vary.light, view: scene.vary.view, shape: scene.vary.shape, materials }
}

fn nothing(scene: &Scene) -> Plan {
    let why = "varies nothing, so there is nothing to bake: make one image with `bake reference`, or name in [vary] what is to change";
    Plan {
        scene: scene.name.clone(),
        varies: varies(scene),
        methods: Vec::new(),
        chosen: None,
        why: why.to_owned(),
        not_modelled: ignored(scene),
        stored_unusable: None,
    }
}

fn make(scene: &Scene, asked: &Asked, folders: &Folders<'_>) -> Result<Plan> {
    let job = Job::new(ProgressMode::None);
    bundle::expect_fit(scene, &[], asked.size, &job)?;
    let mut stored = stored::read(&folders.bundles.join(&scene.name), scene);
    let mut charted = charted::read(&folders.charts.join(&scene.name));
    let mut shared = None;
    let mut candidate = |registered: &'static Registered| {
        let method = (registered.new)(asked, scene);
        let misfit =
            method.expect_fit(scene).err().map(|error| reason(&error.with_line().to_string(), scene));
        let mut candidate = Candidate {
            name: method.name(),
            misfit,
            serves_all: registered.serves_all(&scene.vary),
            leaves_out: Vec::new(),
            settings: method.asked_for(),
            predicted: None,
            stored: stored.methods.remove(method.name()),
            charted: charted.remove(method.name()),
        };
        candidate.settings.remove("revision");
        if candidate.misfit.is_none() {
            let shared = match shared {
                Some(shared) => shared,
                None => *shared.insert(bundle::predict_shared(scene, asked.size, asked.seed, &job)?),
            };
            candidate.leaves_out = method.leaves_out(scene);
            candidate.predicted = Some(Prediction::new(
                &method.predict(scene, &job)?,
                &shared,
                method.chosen().first().copied(),
            ));
        }
        Ok(candidate)
    };
    let methods = METHODS.into_iter().map(&mut candidate).collect::<Result<Vec<Candidate>>>()?;
    let preferred = cheapest(&scene.vary);
    let taken = methods.iter().find(|candidate| candidate.name == preferred.card.name);
    let fits = taken.filter(|candidate| candidate.misfit.is_none());
    Ok(Plan {
        scene: scene.name.clone(),
        varies: varies(scene),
        chosen: fits.map(|candidate| candidate.name),
        why: why(preferred, taken.and_then(|candidate| candidate.misfit.as_deref())),
        not_modelled: not_modelled(scene, fits),
        methods,
        stored_unusable: stored.unusable,
    })
}

/// An error's message without the scene's file, which the reader knows.
fn reason(message: &str, scene: &Scene) -> String {
    let file = format!("{}: ", Place::file(&scene.file));
    let line = message.strip_prefix(&file).unwrap_or(message);
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Why `bake run` takes `method`, which may not fit.
fn why(method: &Registered, misfit: Option<&str>) -> String {
    match misfit {
        None => method.why.to_owned(),
        Some(misfit) => format!("{}, which would be, does not fit: {misfit}", method.card.name),
    }
}

/// What the `chosen` method leaves out, and what no method does.
fn not_modelled(scene: &Scene, chosen: Option<&Candidate>) -> Vec<String> {
    let vary = &scene.vary;
    let moves = [("light", vary.light), ("view", vary.view), ("shape", vary.shape)]
        .into_iter()
        .filter(|(_, varies)| *varies);
    let moves: Vec<&str> = moves.map(|(what, _)| what).collect();
    // What is painted is edited as a whole if it must be, and that is told of the method.
    let whole = Vary { painted: Vec::new(), ..vary.clone() };
    let served = METHODS.into_iter().any(|method| method.serves_all(&whole));
    let both = !served && !moves.is_empty() && !vary.materials.is_empty();
    let together = both.then(|| format!("no method varies materials together with {}", moves.join(", ")));
    let meta = bundle::stored_scene(scene, scene.size).meta;
    let animations =
        chosen.map(|candidate| playable::split(scene, &meta, &[candidate.name]).1).unwrap_or_default();
    let by_choice = chosen.iter().flat_map(|candidate| candidate.leaves_out.iter().cloned());
    by_choice.chain(together).chain(animations).chain(ignored(scene)).collect()
}

/// What of the scene's files was ignored or mended when they were read.
fn ignored(scene: &Scene) -> Vec<String> {
    scene.warnings.iter().map(|warning| reason(warning, scene)).collect()
}

#[cfg(test)]
mod tests;
