//! region-images: bakes of painted scenes against references and against other bakes.

use crate::support::regions::{bake, settings, shown};
use crate::support::{images, job, scene};
use relume_bake::paintings::paintings;
use relume_bake::random_paint::in_random_paint;
use relume_bake::trace::reference::{self, Paths};
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_images;
use relume_formats::kinds::region_images::{REGION_COUNT, Source};
use relume_formats::state::{Paint, Rgb};
use relume_scenes::Scene;
use std::sync::Arc;

/// A painted wall beside a floor that is edited as a whole and a wall that stays, under a lamp of one colour.
const CORNER: &str = "[vary]\nmaterials = ['wall', 'floor']\npainted = ['wall']\n[render]\nsize = [32, 32]\n\
    reflections = 2\n[camera]\nposition = [0.5, 0.9, 2.4]\ntarget = [-0.1, 0.35, 0]\nfov_deg = 45\n\
    [materials.wall]\nbrdf = 'blinn-phong'\nkd = [0.5, 0.5, 0.5]\nks = [0.2, 0.2, 0.2]\nshininess = 20\n\
    [materials.floor]\nbrdf = 'blinn-phong'\nkd = [0.4, 0.4, 0.4]\nks = [0.4, 0.4, 0.4]\nshininess = 40\n\
    [materials.red]\nbrdf = 'blinn-phong'\nkd = [0.6, 0.1, 0.1]\n\
    [[light]]\nname = 'l'\nkind = 'area'\nradiance = [8, 6, 4]\n\
    transform = { translation = [0.2, 1.6, 0.4], rotation_deg = [-90, 0, 0], scale = 0.8 }\n\
    [[object]]\nname = 'floor'\nmaterial = 'floor'\nshape = 'quad'\ntransform = { scale = 2 }\n\
    [[object]]\nname = 'back'\nmaterial = 'red'\nshape = 'quad'\n\
    transform = { scale = 2, rotation_deg = [90, 0, 0], translation = [0, 1, -0.9] }\n\
    [[object]]\nname = 'wall'\nmaterial = 'wall'\nshape = 'quad'\n\
    transform = { scale = 2, rotation_deg = [0, 0, -90], translation = [-0.7, 1, 0] }\n";

fn relative_l2(image: &[Rgb], truth: &[Rgb]) -> f64 {
    let square = |x: f32| f64::from(x).powi(2);
    let pairs = || image.as_flattened().iter().zip(truth.as_flattened());
    let off: f64 = pairs().map(|(a, b)| square(a - b)).sum();
    (off / pairs().map(|(_, b)| square(*b)).sum::<f64>()).sqrt()
}

fn reference(scene: &Scene, states: &[Scene], samples: u32) -> Vec<Vec<Rgb>> {
    let Scene { size, reflections, .. } = *scene;
    let settings =
        reference::Settings { size, samples, seed: 3, reflections, paths: Paths::Gather, target: None };
    let paintings = paintings(scene, &job()).unwrap();
    let estimates = reference::render(scene, states, &paintings, &settings, &job()).unwrap();
    estimates.into_iter().map(|estimate| estimate.radiance).collect()
}

/// On the bake's own paths: what differs is the method, and noise that it adds, for a path meets one texel of a region
/// that counts by its mean. The error that a bake states is without that noise. Textures are washes of colour: of sharp
/// edges, of which there are many in a pixel of so small a film, four places a pixel miss more.
#[test]
fn washes_of_colour_are_as_references_have_them() {
    let scene = scene(CORNER);
    let (basis, baked) = bake(&scene, settings(32, 256, 0.01));
    let states = [0, 4].map(|state| in_random_paint(state, &scene));
    let truth = reference(&scene, &states, 256);
    let pairs = states.iter().zip(&truth);
    let errors: Vec<f64> =
        pairs.map(|(state, truth)| relative_l2(&shown(&basis, &baked, state), truth)).collect();
    let stated = [baked.errors.all[0], baked.errors.all[4]];
    assert!(stated.iter().all(|error| *error < 0.03), "{stated:?}");
    assert!(errors.iter().all(|error| *error < 0.06), "{errors:?}, stated {stated:?}");
    // Light between surfaces counts: without it no picture is nearly right.
    let direct = Scene { reflections: 1, ..scene.clone() };
    let alone = reference(&direct, &states, 256);
    let without: Vec<f64> =
        alone.iter().zip(&truth).map(|(image, truth)| relative_l2(image, truth)).collect();
    assert!(
        without.iter().zip(&errors).all(|(without, error)| *without > 3.0 * error),
        "{without:?} {errors:?}"
    );
}

/// The same paths by another method: both store halves, and one of them coverages apart.
#[test]
fn even_paint_shows_what_transfer_images_show() {
    let scene = scene(&CORNER.replace("reflections = 2", "reflections = 1"));
    let (basis, baked) = bake(&scene, settings(32, 64, 0.01));
    let whole = images::Settings { size: [32, 32], samples: 64, seed: 3, bases: 6, filter: false };
    let (of_wholes, images) = images::bake(&scene, &whole, true);
    assert_eq!(of_wholes, basis);
    for number in 0..3 {
        let mut state = in_random_paint(number, &scene);
        let brdfs: Vec<_> = state.vary.materials.iter().map(|m| state.materials[*m].brdf).collect();
        let wall = state.vary.materials[0];
        state.materials[wall].paint = Some(Arc::new(Paint::uniform(&brdfs[0], [3, 2])));
        let expected = transfer_images::evaluate(&images, &images::on_bases(&basis, &brdfs));
        let error = relative_l2(&shown(&basis, &baked, &state), &expected);
        assert!(error < 1e-3, "{number}: {error}");
    }
}

/// More is kept of a bake that may be off by less.
#[test]
fn what_is_kept_goes_by_the_error_that_is_asked_for() {
    let scene = scene(CORNER);
    let [rough, fine] = [0.05, 0.002].map(|error| bake(&scene, settings(24, 64, error)).1);
    let bytes = |baked: &relume_bake::methods::region_images::bake::Baked| {
        baked.images.to_bytes(Place::file("images")).unwrap().len()
    };
    assert!(2 * bytes(&rough) < bytes(&fine), "{} {}", bytes(&rough), bytes(&fine));
    let worst = |errors: &[f64]| errors.iter().fold(0.0, |m: f64, e| m.max(*e));
    assert!(worst(&fine.errors.of_compression) < worst(&rough.errors.of_compression));
    assert!(worst(&fine.errors.of_compression) < 0.002, "{:?}", fine.errors.of_compression);
    let rows = fine.images.head.rows.iter().flatten();
    let painted = rows.filter(|row| matches!(row.source, Source::Painted { .. })).count();
    assert!((1..16 * REGION_COUNT).contains(&painted));
}

/// Whatever the threads, bytes are the same.
#[test]
fn threads_change_nothing() {
    let scene = scene(CORNER);
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (_, baked) = pool.install(|| bake(&scene, settings(20, 32, 0.01)));
        baked.images.to_bytes(Place::file("images")).unwrap()
    };
    assert!(bytes(1) == bytes(3));
}

/// Regions that nothing shows or meets, a material that nothing wears, and light that is reflected once alone.
#[test]
fn what_is_not_there_is_baked_as_nothing() {
    let unworn = CORNER
        .replace("painted = ['wall']", "painted = ['wall', 'ghost']")
        .replace("['wall', 'floor']", "['wall', 'floor', 'ghost']")
        + "[materials.ghost]\nbrdf = 'blinn-phong'\n";
    let once = CORNER.replace("reflections = 2", "reflections = 1");
    for text in [&unworn, &once] {
        let scene = scene(text);
        let (basis, baked) = bake(&scene, settings(16, 64, 0.01));
        let states = [in_random_paint(0, &scene)];
        let truth = reference(&Scene { size: [16, 16], ..scene.clone() }, &states, 64);
        let error = relative_l2(&shown(&basis, &baked, &states[0]), &truth[0]);
        assert!(error < 0.08, "{error}");
    }
}
