//! `render_once` against the CPU evaluation.

use crate::support::{self, Bundle};
use relume_formats::Place;
use relume_formats::state::{Brdf, CookTorrance, Ggx, State, parse_toml};

fn gpu_there() -> bool {
    support::gpu_there(|| relume_player::gpu::list().map(|_| ()).map_err(|e| e.to_string()))
}

#[test]
fn a_state_is_rendered_as_the_cpu_does() {
    if !gpu_there() {
        return;
    }
    let text = "[materials.b]\nkd = [0.1, 0.6, 0.2]\nks = [0.5, 0.4, 0.3]\nshininess = 33.0\n[camera]\nexposure_ev = 3.0";
    let state: State = parse_toml(text, &Place::file("test")).unwrap();
    let mut materials = support::default_materials();
    materials[1] = materials[1].with(&state.materials["b"], "b", &Place::file("test")).unwrap();
    for one_colour in [true, false] {
        let bundle = Bundle::write(one_colour);
        let (size, ours) = relume_player::render_once(bundle.folder(), &state, None).unwrap();
        assert_eq!(size, support::SIZE);
        let difference = support::largest_difference(&ours, &bundle.evaluate(&materials, |_| true));
        assert!(difference <= 1e-5, "{difference}: exposure must not touch radiance");
    }
}

#[test]
fn ggx_is_rendered_as_the_cpu_does() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write_ggx();
    let text = "[materials.a]\nbase_color = [0.1, 0.9, 0.3]\nroughness = 0.7\n[materials.b]\nmetallic = 0.25";
    let (_, ours) =
        relume_player::render_once(bundle.folder(), &parse_toml(text, &Place::file("test")).unwrap(), None)
            .unwrap();
    let a = Ggx { base_color: [0.1, 0.9, 0.3], metallic: 0.0, roughness: 0.7 };
    let b = Ggx { base_color: [0.8, 0.5, 0.2], metallic: 0.25, roughness: 0.45 };
    let difference =
        support::largest_difference(&ours, &bundle.evaluate(&[Brdf::Ggx(a), Brdf::Ggx(b)], |_| true));
    assert!(difference <= 1e-5, "{difference}");
    let metal = parse_toml("[materials.a]\nmetallic = 0.5", &Place::file("metal.toml")).unwrap();
    let error = relume_player::render_once(bundle.folder(), &metal, None).unwrap_err();
    assert!(error.to_string().contains("material `a`: metallic 0.5") && error.exit_code() == 2, "{error}");
}

#[test]
fn cook_torrance_is_rendered_as_the_cpu_does() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write_cook_torrance();
    let text = "[materials.a]\nkd = [0.1, 0.4, 0.3]\nfresnel = 0.04\n[materials.b]\nroughness = 0.1";
    let (_, ours) =
        relume_player::render_once(bundle.folder(), &parse_toml(text, &Place::file("test")).unwrap(), None)
            .unwrap();
    let a = CookTorrance { kd: [0.1, 0.4, 0.3], fresnel: 0.04, ..support::COOK_TORRANCE };
    let b = CookTorrance { roughness: 0.1, ..support::COOK_TORRANCE };
    let materials = [Brdf::CookTorrance(a), Brdf::CookTorrance(b)];
    let difference = support::largest_difference(&ours, &bundle.evaluate(&materials, |_| true));
    assert!(difference <= 1e-5, "{difference}");
}

#[test]
fn files_of_different_bakes_are_refused() {
    if !gpu_there() {
        return;
    }
    use relume_formats::basis::lobe_table;
    use relume_formats::container::Stored as _;
    use relume_formats::kinds::brdf_basis::Functions;
    use relume_formats::kinds::manifest::FileEntry;
    use relume_formats::kinds::{BrdfBasis, StoredScene};
    let state = State::default();

    let mut bundle = Bundle::write(true);
    let mut scene = StoredScene::read_file(&bundle.folder().join("scene.relume")).unwrap();
    scene.meta.size = [23, 37];
    bundle.manifest.scene_file =
        FileEntry::of("scene.relume", &scene.write_file(&bundle.folder().join("scene.relume")).unwrap());
    bundle.manifest.write(bundle.folder()).unwrap();
    let error = relume_player::render_once(bundle.folder(), &state, None).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("film size [37, 23], the scene's is [23, 37]; bake the whole bundle again")
            && error.exit_code() == 2,
        "{error}"
    );

    let mut bundle = Bundle::write(true);
    let path = bundle.folder().join("basis.relume");
    let whole = BrdfBasis::read_file(&path).unwrap();
    let functions = Functions::BlinnPhong { lobes: vec![0.25; lobe_table::NODES] };
    let smaller = support::honest(BrdfBasis { coefficients: vec![0.5; 6], functions, ..whole });
    bundle.manifest.methods[0].files[0].1 =
        FileEntry::of("basis.relume", &smaller.write_file(&path).unwrap());
    bundle.manifest.write(bundle.folder()).unwrap();
    let error = relume_player::render_once(bundle.folder(), &state, None).unwrap_err();
    assert!(
        error.to_string().contains("4 bases, the BRDF basis has 2; bake the whole bundle again")
            && error.exit_code() == 2,
        "{error}"
    );
}

#[test]
fn sparse_rows_are_rendered_as_the_cpu_does() {
    if !gpu_there() {
        return;
    }
    use relume_formats::evaluate::sparse_transfer::{lights, radiance};
    use relume_formats::kinds::scene::EnvironmentLook;
    let bundle = support::sparse::Bundle::write(16, true);
    let text = "environment = { map = \"sun\", rotation_deg = 33.0, gain = [1.0, 0.5, 2.0] }\ncamera = { fov_deg = 20.0, exposure_ev = 3.0 }";
    let state: State = parse_toml(text, &Place::file("test")).unwrap();
    let look = EnvironmentLook { map: "sun".to_owned(), rotation_deg: 33.0, gain: [1.0, 0.5, 2.0] };
    let expected = radiance(&bundle.transfer, &lights(bundle.map("sun"), &look, &bundle.transfer.meta));
    let ours = relume_player::render_vertices(bundle.folder(), "sparse-transfer", &state, None).unwrap();
    let difference = support::largest_difference(&ours, &expected);
    assert!(difference <= 1e-4, "{difference}");
    let (size, film) = relume_player::render_once(bundle.folder(), &state, None).unwrap();
    assert_eq!((size, film.len()), (support::sparse::SIZE, 600));
    let images = Bundle::write(true);
    let error = relume_player::render_vertices(images.folder(), "transfer-images", &State::default(), None)
        .unwrap_err();
    assert!(error.to_string().contains("no radiance at vertices") && error.exit_code() == 2, "{error}");
}
