//! The GPU against the CPU, however storage and film are cut.

use super::storage::Volume;
use super::*;
use crate::support::{self, Bundle};
use crate::testing::{arrivals, gpu, playlist, read_radiance};
use relume_formats::container::Stored as _;
use relume_formats::kinds::StoredScene;
use relume_formats::state::{BlinnPhong, Brdf};

/// Everything of the bundle, loaded on `gpu`.
fn load(gpu: &Gpu, bundle: &Bundle) -> Result<TransferImages> {
    let scene = StoredScene::read_file(&bundle.folder().join("scene.relume"))?;
    let mut method =
        TransferImages::new(Setup { scene, settings: playlist(bundle.folder(), None).settings, size: None })?;
    arrivals(bundle.folder()).into_iter().try_for_each(|arrival| method.section_arrived(gpu, arrival))?;
    Ok(method)
}

fn render(gpu: &Gpu, method: &mut TransferImages, materials: [Brdf; 2]) -> Vec<[f32; 3]> {
    let mut look = Look::default_of(&support::scene_meta());
    ["a", "b"].into_iter().zip(materials).for_each(|(name, brdf)| look.materials.set(name, brdf));
    method.update(gpu, &look).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut passes = Passes::new(&mut encoder, None, 0);
    method.encode(&mut passes);
    passes.finish();
    gpu.queue.submit([encoder.finish()]);
    read_radiance(gpu, &method.film().unwrap().bands)
}

#[test]
fn gpu_equals_cpu_in_both_layouts_and_for_any_material() {
    let Some(gpu) = gpu() else { return };
    for one_colour in [true, false] {
        let bundle = Bundle::write(one_colour);
        let mut method = load(&gpu, &bundle).unwrap();
        let white = Brdf::BlinnPhong(BlinnPhong { kd: [0.6; 3], ks: [0.4; 3], shininess: 200.0 });
        let black = Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [0.0; 3], shininess: 1.0 });
        for materials in [support::default_materials(), [white, black], [black, white], [black, black]] {
            let (ours, theirs) =
                (render(&gpu, &mut method, materials), bundle.evaluate(&materials, |_| true));
            // 40 slots and at most three fragments, added up in another order and at times fused: some units
            // in the last place of the partial sums.
            let difference = support::largest_difference(&ours, &theirs);
            assert!(difference <= 1e-5, "one colour: {one_colour}, {materials:?}: {difference}");
            assert_eq!(ours[support::EMPTY_PIXEL], [0.0; 3]);
        }
    }
}

#[test]
fn small_bands_and_dispatches_give_the_identical_image() {
    let Some(mut gpu) = gpu() else { return };
    let bundle = Bundle::write(true);
    let materials = support::default_materials();
    let whole = render(&gpu, &mut load(&gpu, &bundle).unwrap(), materials);
    // Two rows of workgroups or more.
    gpu.workgroups_per_dimension = 3;
    assert_eq!(render(&gpu, &mut load(&gpu, &bundle).unwrap(), materials), whole);
    // Some pixel has fragments of both materials and of what is fixed.
    let least = Volume::new(&bundle.images.head.layout()).bytes(2, 3);
    for limit in [least, 3 * least] {
        gpu.binding_bytes = limit;
        let mut method = load(&gpu, &bundle).unwrap();
        let bands = &method.film().unwrap().bands;
        assert!(bands.len() > 1 && bands.iter().all(|band| band.size() <= limit));
        assert_eq!(render(&gpu, &mut method, materials), whole, "{limit}");
    }
    gpu.binding_bytes = least - 1;
    let error = load(&gpu, &bundle).err().unwrap();
    assert!(
        error.to_string().contains("bake fewer materials that vary") && matches!(error, Error::Format(_)),
        "{error}"
    );
}
