//! What a player does with a value that was read: none of it may fail or panic, whatever the file held.

use glam::Vec3;
use relume_formats::basis::suns::{MAX_SUNS, split};
use relume_formats::basis::{Angles, two_level};
use relume_formats::evaluate;
use relume_formats::evaluate::region_images::{self, OnBases};
use relume_formats::evaluate::sparse_transfer;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::transfer_tensor::{Lights, received};
use relume_formats::kinds::region_images::REGION_COUNT;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::sphere_shadows::NO_ROW;
use relume_formats::kinds::{
    BrdfBasis, BrdfTensor, Environment, HaarTable, RegionImages, SparseTransfer, SphereSet, SphereShadows,
    StoredScene, Textures, TransferImages, TransferTensor, VisibilityTable,
};
use relume_formats::shape::DeformingMesh;
use relume_formats::state::{Animation, BlinnPhong, Brdf, CookTorrance, Ggx, Model};

pub fn play_scene(scene: &StoredScene) {
    let direction = scene.meta.camera.film(scene.meta.size[0], scene.meta.size[1]).direction(0.5, 0.5);
    assert!((direction.length() - 1.0).abs() < 1e-3);
    scene.triangles.iter().flatten().for_each(|i| assert!((*i as usize) < scene.positions.len()));
    let triangles: u64 = scene.meta.objects.iter().map(|o| u64::from(o.triangles)).sum();
    assert_eq!(triangles, scene.triangles.len() as u64);
    scene.meta.objects.iter().for_each(|o| assert!((o.material as usize) < scene.meta.materials.len()));
}

pub fn play_animation(animation: &Animation) {
    for time_s in [-1.0, 0.0, 0.3, 1e9] {
        animation.sample(time_s).unwrap();
    }
}

pub fn play_basis(basis: &BrdfBasis) {
    let material = match basis.functions.model() {
        Model::BlinnPhong => Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.5; 3], shininess: 77.0 }),
        Model::Ggx => Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.5, roughness: 0.5 }),
        Model::CookTorrance => {
            Brdf::CookTorrance(CookTorrance { kd: [0.5; 3], ks: [0.5; 3], fresnel: 0.5, roughness: 0.5 })
        }
    };
    assert_eq!(basis.coefficients_of(&material).unwrap().len(), basis.bases());
    let mut values = vec![0.0; basis.bases()];
    for cosine in [0.0, 0.5, 1.0] {
        basis.evaluate(
            &Angles { cos_half: cosine, cos_difference: 1.0 - cosine, cos_in: cosine, cos_out: 0.7 },
            &mut values,
        );
    }
}

/// Of any material of the model.
pub fn play_tensor(tensor: &BrdfTensor) {
    for share in [0.0, 0.3, 1.0] {
        let material = match tensor.meta.model {
            Model::BlinnPhong => {
                Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess: 1.0 + 199.0 * share })
            }
            Model::Ggx => Brdf::Ggx(Ggx { base_color: [share; 3], metallic: 1.0, roughness: 0.5 }),
            Model::CookTorrance => Brdf::CookTorrance(CookTorrance {
                kd: [0.0; 3],
                ks: [1.0; 3],
                fresnel: share,
                roughness: 0.5,
            }),
        };
        let Some(mixture) = tensor.mixture(&material, 0) else { continue };
        assert!((mixture.iter().map(|(_, share)| share).sum::<f32>() - 1.0).abs() < 1e-3);
        let (weights, shares) = (tensor.weights_of(&mixture), tensor.shares_of(&mixture));
        for outgoing in [Vec3::Z, Vec3::X, Vec3::new(-0.36, 0.48, 0.8)] {
            assert!(tensor.residual(&weights, outgoing, Vec3::new(0.6, -0.8, 0.0)).is_finite());
            assert!(BrdfTensor::seen_from(&shares, outgoing).iter().all(|share| *share >= 0.0));
            let middles = tensor.cones.iter().flat_map(|cone| cone.directions(outgoing));
            assert!(middles.into_iter().all(|middle| (middle.length() - 1.0).abs() < 1e-5));
            assert_eq!(tensor.column_values(outgoing).len(), tensor.columns());
        }
    }
}

pub fn play_images(images: &TransferImages) {
    let meta = &images.head.meta;
    // Any size up to 16384² is legal, but a film of that size is too much for a test.
    if u64::from(meta.size[0]) * u64::from(meta.size[1]) < 1 << 20 {
        let on_bases = vec![vec![[0.5; 3]; meta.bases as usize]; meta.materials.len()];
        evaluate::transfer_images::evaluate(images, &on_bases);
    }
}

pub fn play_regions(images: &RegionImages) {
    let meta = &images.head.meta;
    if u64::from(meta.size[0]) * u64::from(meta.size[1]) < 1 << 16 {
        let of_all = OnBases(vec![[0.5; 3]; REGION_COUNT * meta.bases as usize]);
        let materials = vec![of_all; meta.materials.len()];
        let factors = region_images::row_factors(&images.head, meta.bases as usize, &materials);
        for (entries, factors) in images.indirect.iter().zip(&factors) {
            assert!(
                region_images::indirect(entries, factors).len() >= (meta.size[0] * meta.size[1]) as usize
            );
        }
    }
}

pub fn play_table(table: &HaarTable) {
    let mut coefficients = vec![f32::NAN; 6 * 32 * 32];
    two_level::two_level(&[0x5A; two_level::BYTES], table, &mut coefficients);
    assert!(coefficients.iter().all(|c| c.is_finite()));
}

pub fn play_environment(environment: &Environment) {
    let look = EnvironmentLook { map: environment.name.clone(), gain: [1.0; 3], rotation_deg: 77.0 };
    let light = sparse_transfer::light(&environment.map, &look, 2);
    assert!(light.iter().flatten().all(|c| c.is_finite()));
    let parts = split(&environment.map);
    assert!(
        parts.suns.len() <= MAX_SUNS && parts.suns.iter().flat_map(|sun| sun.irradiance).all(f32::is_finite)
    );
    assert!(parts.rest.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
}

pub fn play_textures(textures: &Textures) {
    for stored in &textures.textures {
        for uv in textures.uvs.iter().take(100) {
            assert!(stored.texture.sample(*uv).iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}

pub fn play_rows(transfer: &SparseTransfer) {
    let light = [(); 3].map(|()| vec![1e-3; transfer.meta.coefficients()]);
    assert_eq!(sparse_transfer::radiance(transfer, &light).len(), transfer.meta.vertices as usize);
}

/// In the light of a dim sky; what is not small is not added up.
pub fn play_received(transfer: &TransferTensor) {
    let plane = || vec![1e-3; 6 * 64 * 64];
    let planes = || [plane(), plane(), plane()];
    let lights =
        Lights { rest: planes(), whole: planes(), blurred: Vec::new(), rotation_deg: 0.0, gain: [1.0; 3] };
    if transfer.meta.clusters < 100 {
        let found = received(transfer, &lights, |_| Some(vec![[0.5; 3]; 4]));
        assert_eq!(found.once.len(), transfer.meta.vertices as usize);
    }
}

pub fn play_spheres(set: &SphereSet) {
    // A sphere without points looks for the nearest that has some: too many of them are too much for a test.
    if set.spheres.len() < 1 << 12 {
        let mut spheres = vec![[f32::NAN; 4]; 3];
        let rest = &set.points[..set.meta.vertices as usize];
        Follower::new(set).follow(rest, &mut spheres).unwrap();
        assert_eq!(spheres.len(), set.spheres.len());
    }
}

pub fn play_shape(shape: &DeformingMesh) {
    let mut positions = Vec::new();
    shape.positions(&shape.rest_pose(), &mut positions);
    for clip in shape.clips.iter().take(100) {
        for time_s in [-1.0, 0.3, clip.duration_s] {
            shape.positions_at(clip, time_s, &mut positions);
            assert_eq!(positions.len(), shape.positions.len());
        }
    }
}

pub fn play_visibility(table: &VisibilityTable) {
    for r in [f32::NAN, -1.0, 0.0, 1e-3, 0.5, 1.0, f32::INFINITY] {
        let blocked = table
            .look_up([0.3, -2.0, 1.0].into(), r)
            .map_or(0, |bits| bits.iter().map(|b| b.count_ones()).sum::<u32>());
        assert!(blocked <= 6 * 32 * 32 / 2, "a cap is narrower than a hemisphere");
    }
}

pub fn play_shadows(shadows: &SphereShadows) {
    let sparse = |row: usize| {
        shadows.terms(row).iter().map(|term| shadows.lobe(row)[usize::from(*term)].abs()).fold(0.0, f32::max)
    };
    assert!((0..shadows.normals.len()).all(|row| sparse(row).is_finite()));
    for object in &shadows.meta.objects {
        let rows = &shadows.rows[object.first_vertex as usize..][..object.vertices as usize];
        assert!(
            rows.iter()
                .all(|row| *row == NO_ROW || !object.deforms && shadows.lobe(*row as usize).len() == 6144)
        );
    }
}
