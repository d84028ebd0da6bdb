//! Bakes of sparse-transfer and what they show under any light.

use super::{job, relative_l2};
use relume_bake::bundle;
use relume_bake::methods::sparse_transfer::{Settings, SparseTransferMethod, Terms};
use relume_bake::unfinished::Leftover;
use relume_formats::basis::suns::split;
use relume_formats::basis::{EquirectMap, haar};
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::{light, radiance};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{Environment, Manifest, SparseTransfer, StoredScene};
use relume_scenes::Scene;

/// A ball 1 m above the middle of a plane; more keys may follow those of the environment.
pub const BALL: &str = "
    [vary]
    light = true
    view = true
    [render]
    size = [32, 24]
    reflections = 1
    [camera]
    position = [0.0, 2.0, 5.0]
    target = [0.0, 0.5, 0.0]
    fov_deg = 40.0
    [materials.plane]
    brdf = 'blinn-phong'
    kd = [0.2, 0.5, 0.8]
    [materials.ball]
    brdf = 'blinn-phong'
    kd = [0.7, 0.7, 0.1]
    [[object]]
    name = 'plane'
    shape = 'quad'
    segments = 12
    material = 'plane'
    transform = { scale = 4.0 }
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 3
    material = 'ball'
    transform = { translation = [0.0, 1.0, 0.0], scale = 0.4 }
    [environment]
";

/// With so many rays at the edges of shadows, and so many terms.
pub fn wanted(rays_per_texel: u32, terms: usize) -> SparseTransferMethod {
    SparseTransferMethod { settings: Settings { rays_per_texel, terms: Terms::Number(terms) } }
}

/// What a bundle holds.
pub struct Baked {
    pub transfer: SparseTransfer,
    pub stored: StoredScene,
    pub maps: Vec<Environment>,
    pub manifest: Manifest,
}

/// Bakes `scene` into a bundle and reads it back.
pub fn bake(scene: &Scene, wanted: SparseTransferMethod) -> Baked {
    let folder = tempfile::tempdir().unwrap();
    bundle::run(scene, &[Box::new(wanted)], scene.size, folder.path(), Leftover::Refuse, 0, &job()).unwrap();
    let manifest = Manifest::read(folder.path()).unwrap();
    let path = |file: &str| folder.path().join(file);
    let maps = manifest.methods[0].files.iter().filter(|(kind, _)| kind == "environment");
    Baked {
        transfer: SparseTransfer::read_file(&path("sparse-transfer.relume")).unwrap(),
        stored: StoredScene::read_file(&path("scene.relume")).unwrap(),
        maps: maps.map(|(_, file)| Environment::read_file(&path(&file.file)).unwrap()).collect(),
        manifest,
    }
}

impl Baked {
    /// Radiance of white vertices under a map that is turned, its suns not set apart.
    pub fn under(&self, map: &EquirectMap, rotation_deg: f32) -> Vec<[f32; 3]> {
        let look = EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg };
        let (n, count) = (self.transfer.meta.face_size as usize, self.transfer.meta.coefficients());
        let repeated = |plane: Vec<f32>| plane.into_iter().cycle().take(count).collect();
        radiance(&self.transfer, &light(map, &look, n).map(repeated))
    }

    /// How far the rows are from those of `exact` where `map` gives them what its suns leave, relative L2 of all that is
    /// seen with these.
    pub fn error_under(&self, exact: &Self, map: &EquirectMap) -> f64 {
        let rest = split(map).rest;
        let [ours, theirs] = [self, exact].map(|rows| rows.under(&rest, 0.0));
        let seen = exact.under(map, 0.0);
        let both = ours.iter().zip(&theirs).zip(&seen);
        let shown = both.map(|((ours, theirs), seen)| std::array::from_fn(|c| seen[c] + ours[c] - theirs[c]));
        relative_l2(&shown.collect::<Vec<[f32; 3]>>(), &seen)
    }

    /// Under a light given by its texels.
    pub fn under_texels(&self, texels: &[f32]) -> Vec<f32> {
        let mut plane: Vec<f32> =
            texels.iter().copied().cycle().take(self.transfer.meta.coefficients()).collect();
        haar::forward_cube(&mut plane, self.transfer.meta.face_size as usize);
        radiance(&self.transfer, &[plane.clone(), plane.clone(), plane]).iter().map(|r| r[0]).collect()
    }

    /// Vertices of the plane.
    pub fn plane(&self) -> impl Iterator<Item = usize> {
        0..13 * 13
    }
}
