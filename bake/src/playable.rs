//! Which animations the methods of a bundle can play: one rule for what a bake writes and what `bake verify`
//! accepts.

use crate::method::Method;
use crate::methods::asked::Asked;
use crate::methods::choice::METHODS;
use crate::methods::registered::Registered;
use relume_formats::bundle::{Scope, expect_some_plays};
use relume_formats::kinds::scene::Meta;
use relume_formats::state::{Animation, with_line};
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::path::Path;

/// What the method called `name` shows of `scene` once it is baked; `None` for a name that is no method's.
fn scope(name: &str, scene: &Scene, meta: &Meta) -> Option<Scope> {
    let card = Registered::find(name)?.card;
    let maps = scene
        .environment
        .iter()
        .flat_map(|e| [&e.map].into_iter().chain(&e.others))
        .map(|map| map.name.clone());
    Some(Scope {
        scene: meta.clone(),
        card,
        maps: if card.lets_vary.light { maps.collect() } else { Vec::new() },
    })
}

/// The animations of `scene`, which a bundle holds as `meta`, that one of `methods` plays, and a sentence for
/// each that none does.
pub fn split<'a>(scene: &'a Scene, meta: &Meta, methods: &[&str]) -> (Vec<&'a Animation>, Vec<String>) {
    let scopes: Vec<Scope> = methods.iter().filter_map(|name| scope(name, scene, meta)).collect();
    let (mut kept, mut left_out) = (Vec::new(), Vec::new());
    for animation in &scene.animations {
        let place = place_of(animation, scene);
        match expect_some_plays(animation, &scopes, &place) {
            Ok(()) => kept.push(animation),
            Err(error) => left_out.push(sentence(animation, &with_line(error), scene, meta, methods)),
        }
    }
    (kept, left_out)
}

/// Where an animation of a scene comes from.
fn place_of(animation: &Animation, scene: &Scene) -> Place {
    let folder = scene.file.parent().unwrap_or_else(|| Path::new(""));
    Place::file(folder.join("animations").join(format!("{}.toml", animation.name)))
}

fn sentence(animation: &Animation, error: &Error, scene: &Scene, meta: &Meta, methods: &[&str]) -> String {
    let plays = |name: &&str| {
        scope(name, scene, meta)
            .is_some_and(|scope| expect_some_plays(animation, &[scope], &place_of(animation, scene)).is_ok())
    };
    let asked = Asked::of_scene(scene);
    let all: Vec<Box<dyn Method>> = METHODS.into_iter().map(|method| (method.new)(&asked, scene)).collect();
    let others: Vec<&str> = all
        .iter()
        .filter(|method| method.expect_fit(scene).is_ok())
        .map(|method| method.name())
        .filter(plays)
        .collect();
    match others.first() {
        Some(other) => format!(
            "{}: {} does not play this animation, {other} does; it is left out, add --method {other} to keep it",
            place_of(animation, scene),
            methods.join(", ")
        ),
        None => format!("{error}; the animation is left out"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[vary]\nlight = true\nmaterials = ['a']\n[render]\nsize = [8, 8]\nreflections = 1\n\
         [camera]\nposition = [0, 1, 3]\ntarget = [0, 0, 0]\nfov_deg = 40\n[materials.a]\nbrdf = 'blinn-phong'\n\
         [[object]]\nname = 'o'\nshape = 'box'\nmaterial = 'a'\n[environment]\n[[light]]\nname = 'lamp'\nkind = 'point'\nintensity = [1, 1, 1]\n";

    /// What of two animations, one of the material and one of `other`, is kept and said.
    fn after(other: &str, methods: &[&str]) -> (Vec<String>, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("animations")).unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("scene.toml", SCENE);
        write("animations/paint.toml", "duration_s = 1\n[[key]]\nt_s = 0\nmaterials.a.shininess = 30\n");
        write("animations/other.toml", &format!("duration_s = 1\n[[key]]\nt_s = 0.5\n{other}\n"));
        let scene = relume_scenes::load(&folder.path().join("scene.toml")).unwrap();
        let (kept, left_out) = split(&scene, &crate::bundle::stored_scene(&scene, [8, 8]).meta, methods);
        let folder = format!("{}/", folder.path().display());
        let plain = |sentence: String| sentence.replace(&folder, "");
        (
            kept.iter().map(|animation| animation.name.clone()).collect(),
            left_out.into_iter().map(plain).collect(),
        )
    }

    #[test]
    fn animations_are_kept_if_a_method_plays_them() {
        let turn = "environment.rotation_deg = 5";
        assert_eq!(
            after(turn, &["transfer-images", "sparse-transfer"]),
            (vec!["other".to_owned(), "paint".to_owned()], Vec::new())
        );
        let (kept, left_out) = after(turn, &["transfer-images"]);
        assert_eq!(kept, ["paint"]);
        // A point light does not suit the other method.
        assert_eq!(
            left_out,
            [
                "animations/other.toml: line 4: at 0.5 s: sets [environment], which this bundle does not vary (only material `a` varies); \
              remove it, or let it vary: by [vary] in scene.toml, and by a method that can, as `bake plan` tells; the animation is left out"
            ]
        );
    }

    #[test]
    fn what_no_method_plays_is_left_out_with_its_line() {
        let (kept, left_out) = after("lights.lamp.gain = [2, 2, 2]", &["transfer-images"]);
        assert_eq!(kept, ["paint"]);
        assert_eq!(
            left_out,
            [
                "animations/other.toml: line 4: at 0.5 s: sets light `lamp`, but no method of this version lets lights vary; \
              remove it; the animation is left out"
            ]
        );
    }
}
