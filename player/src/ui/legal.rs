//! Edits that stay within what a material, camera or environment may be: what the user sets is brought into
//! its range, and where two parameters share one range the other one gives way.

use relume_formats::Place;
use relume_formats::kinds::scene::{EnvironmentLook, StoredMaterial, StoredShape};
use relume_formats::state::{
    Brdf, Camera, CameraState, EnvironmentState, MaterialState, Pose, Posed, Rgb, ShapeState, State,
};
use relume_playback::{Look, Scope};
use std::collections::BTreeMap;

/// `brdf` with the leaves of `change` that belong to its model; always legal if `brdf` is.
///
/// Each value is brought into its range, and what is no number is passed over. If kd is set and kd + ks would
/// exceed 1, ks is lowered, and the other way round; if both are set, ks is.
fn apply(material: &StoredMaterial, brdf: Brdf, change: &MaterialState) -> Brdf {
    let [least, most] = material.editable();
    match brdf {
        Brdf::BlinnPhong(mut new) => {
            set_colour(&mut new.kd, change.kd);
            set_colour(&mut new.ks, change.ks);
            set(&mut new.shininess, change.shininess, least, most);
            give_way(&mut new.kd, &mut new.ks, change);
            Brdf::BlinnPhong(new)
        }
        Brdf::Ggx(mut new) => {
            set_colour(&mut new.base_color, change.base_color);
            set(&mut new.metallic, change.metallic, 0.0, if material.textured { 0.0 } else { 1.0 });
            set(&mut new.roughness, change.roughness, least, most);
            Brdf::Ggx(new)
        }
        Brdf::CookTorrance(mut new) => {
            set_colour(&mut new.kd, change.kd);
            set_colour(&mut new.ks, change.ks);
            set(&mut new.fresnel, change.fresnel, 0.0, 1.0);
            set(&mut new.roughness, change.roughness, least, most);
            give_way(&mut new.kd, &mut new.ks, change);
            Brdf::CookTorrance(new)
        }
    }
}

/// Lowers that of kd and ks which `change` does not name, ks if both or none, so that their sum is at most 1.
fn give_way(kd: &mut Rgb, ks: &mut Rgb, change: &MaterialState) {
    if change.ks.is_some() && change.kd.is_none() {
        *kd = room_beside(*ks, *kd);
    } else {
        *ks = room_beside(*kd, *ks);
    }
}

/// What of `change` may be set on `look`, with every value brought into its range, so that it can be applied:
/// whole materials and shapes, and the leaves of camera and environment that are named. What does not vary,
/// is not there or has no legal value near is left out.
pub fn within(look: &Look, scope: &Scope, change: &State) -> State {
    let varies = scope.varies();
    let material = |stored: &StoredMaterial| {
        let new = apply(stored, *look.materials.get(&stored.name)?, change.materials.get(&stored.name)?);
        Some((stored.name.clone(), MaterialState::from(new)))
    };
    let shape = |stored: &StoredShape| {
        let change =
            change.shapes.get(&stored.object).filter(|_| varies.shapes.contains(&stored.object.as_str()))?;
        Some((stored.object.clone(), shape(stored, look.shapes.get(&stored.object), change)?))
    };
    let light = |change: &EnvironmentState| {
        let known = change.map.as_ref().is_none_or(|map| scope.maps.contains(map));
        environment(look.environment.as_ref().filter(|_| known && varies.environment)?, change)
    };
    State {
        environment: change.environment.as_ref().and_then(light),
        view: change.view.clone(),
        camera: change.camera.as_ref().and_then(|change| camera(look.camera, change, varies.camera)),
        lights: BTreeMap::new(),
        materials: scope.materials().filter_map(material).collect(),
        shapes: scope.scene.shapes.iter().filter_map(shape).collect(),
    }
}

/// `change`, without what may not move, if it leads from `camera` to another.
fn camera(camera: Camera, change: &CameraState, moves: bool) -> Option<CameraState> {
    let change = if moves {
        change.clone()
    } else {
        CameraState { exposure_ev: change.exposure_ev, ..CameraState::default() }
    };
    camera.with(&change, &place()).is_ok().then_some(change)
}

/// `change`, if it leads from `look` to another environment.
fn environment(look: &EnvironmentLook, change: &EnvironmentState) -> Option<EnvironmentState> {
    look.with(change, &place()).is_ok().then(|| change.clone())
}

/// The change to what `shape`, which shows `now`, shows after `change`, if that is anything it has.
fn shape(shape: &StoredShape, now: Option<&Posed>, change: &ShapeState) -> Option<ShapeState> {
    let posed = shape.with(now, change, &place()).ok()?;
    Some(match posed {
        Some(Posed { clip, time_s }) => ShapeState { clip: Some(clip), time_s: Some(time_s), pose: None },
        None => ShapeState { pose: Some(Pose::Rest), ..ShapeState::default() },
    })
}

fn place() -> Place {
    Place::file("edit")
}

fn set(value: &mut f32, wanted: Option<f32>, least: f32, most: f32) {
    if let Some(wanted) = wanted.filter(|wanted| !wanted.is_nan()) {
        *value = wanted.clamp(least, most);
    }
}

fn set_colour(colour: &mut Rgb, wanted: Option<Rgb>) {
    for (channel, wanted) in colour.iter_mut().zip(wanted.into_iter().flatten()) {
        set(channel, Some(wanted), 0.0, 1.0);
    }
}

/// `other`, lowered to what `first` leaves of 1 in each channel.
fn room_beside(first: Rgb, other: Rgb) -> Rgb {
    std::array::from_fn(|k| other[k].min((1.0 - first[k]).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;
    use relume_formats::Place;
    use relume_formats::state::{BlinnPhong, CookTorrance, Ggx};

    fn stored(brdf: Brdf, textured: bool) -> StoredMaterial {
        let sharpest = brdf.model().usual_sharpest();
        StoredMaterial { name: "m".to_owned(), brdf, varies: true, textured, sharpest }
    }

    #[test]
    fn the_other_reflectance_gives_way_channel_by_channel() {
        let start =
            Brdf::BlinnPhong(BlinnPhong { kd: [0.2, 0.5, 0.9], ks: [0.1, 0.5, 0.0], shininess: 10.0 });
        let set_kd = MaterialState { kd: Some([0.95, 0.2, 0.3]), ..Default::default() };
        let new = support::blinn_phong(apply(&stored(start, false), start, &set_kd));
        assert_eq!((new.kd, new.ks, new.shininess), ([0.95, 0.2, 0.3], [1.0 - 0.95, 0.5, 0.0], 10.0));
        let set_ks = MaterialState { ks: Some([0.95, 0.2, 0.3]), ..Default::default() };
        let new = support::blinn_phong(apply(&stored(start, false), start, &set_ks));
        assert_eq!((new.kd, new.ks), ([1.0 - 0.95, 0.5, 0.7], [0.95, 0.2, 0.3]));
    }

    #[test]
    fn no_edit_leads_out_of_the_legal_range() {
        let wild = [
            f32::NEG_INFINITY,
            -3.0,
            -0.0,
            0.0,
            1e-30,
            0.31,
            0.5,
            0.999_999_9,
            1.0,
            1.000_1,
            77.0,
            1e9,
            f32::INFINITY,
            f32::NAN,
        ];
        let blinn_phong = Brdf::BlinnPhong(BlinnPhong { kd: [0.3; 3], ks: [0.7; 3], shininess: 1.0 });
        let ggx = Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.0, roughness: 0.32 });
        let grooves = CookTorrance { kd: [0.3; 3], ks: [0.7; 3], fresnel: 1.0, roughness: 0.1 };
        let grooves = stored(Brdf::CookTorrance(grooves), true);
        for material in [stored(blinn_phong, false), stored(ggx, false), stored(ggx, true), grooves] {
            let mut brdf = material.brdf;
            for (i, a) in wild.into_iter().enumerate() {
                for b in wild {
                    let colour = Some([a, b, wild[(i * 7 + 3) % wild.len()]]);
                    for change in [
                        MaterialState { kd: colour, base_color: colour, ..Default::default() },
                        MaterialState {
                            ks: colour,
                            metallic: Some(a),
                            fresnel: Some(b),
                            ..Default::default()
                        },
                        MaterialState {
                            kd: colour,
                            ks: Some([b, a, b]),
                            shininess: Some(b),
                            roughness: Some(a),
                            ..Default::default()
                        },
                    ] {
                        brdf = apply(&material, brdf, &change);
                        material.validate(&brdf, &Place::file("edit")).unwrap();
                    }
                }
            }
        }
    }

    #[test]
    fn a_textured_material_does_not_become_a_metal() {
        let dull = Ggx { base_color: [0.5; 3], metallic: 0.0, roughness: 0.5 };
        let change = MaterialState { metallic: Some(1.0), kd: Some([0.1; 3]), ..Default::default() };
        assert_eq!(apply(&stored(Brdf::Ggx(dull), true), Brdf::Ggx(dull), &change), Brdf::Ggx(dull));
        let metal = Ggx { metallic: 1.0, ..dull };
        assert_eq!(apply(&stored(Brdf::Ggx(dull), false), Brdf::Ggx(dull), &change), Brdf::Ggx(metal));
    }
}
