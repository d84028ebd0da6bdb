//! Pictures in the light of suns alone, against rays from the very points that are seen.

use super::*;
use crate::testing::read_radiance;
use glam::Vec3;
use relume_formats::basis::suns::{Sun, split};
use relume_formats::basis::{EquirectMap, Filter, Texture, Wrap};
use relume_formats::evaluate::suns::{radiance, towards};
use relume_formats::kinds::Textures;
use relume_formats::kinds::textures::MaterialTexture;
use std::f32::consts::{PI, TAU};

const SIZE: [u32; 2] = [96, 64];
/// Half the side of the square that hangs before the wall, and how far before it, in parts of the scene.
const SQUARE: f32 = 0.3;
const BEFORE: f32 = 0.4;

/// A black map with a disc of 1° radius towards each direction.
fn night(discs: &[Vec3]) -> Environment {
    let [width, height] = [512, 256];
    let texel = |i: u32| {
        let lit = (0..64).filter(|k| {
            let (u, v) = (
                ((i % width) as f32 + ((k % 8) as f32 + 0.5) / 8.0) / width as f32,
                ((i / width) as f32 + ((k / 8) as f32 + 0.5) / 8.0) / height as f32,
            );
            let ((sin_a, cos_a), (sin, cos)) = ((TAU * (u - 0.5)).sin_cos(), (PI * v).sin_cos());
            let direction = Vec3::new(sin * sin_a, cos, -sin * cos_a);
            discs.iter().any(|disc| disc.normalize().dot(direction) > 1.0_f32.to_radians().cos())
        });
        [16.0 * lit.count() as f32; 3]
    };
    let texels = (0..width * height).map(texel).collect();
    Environment { name: "night".to_owned(), map: EquirectMap { width, height, texels } }
}

/// What hangs before the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hangs {
    Square,
    /// The same square, whose texture cuts away its left half.
    Half,
}

impl Hangs {
    /// Whether there is something of it at this point of its plane.
    fn is_at(self, point: Vec3) -> bool {
        point.x.abs().max(point.y.abs()) < SQUARE && (self == Self::Square || point.x > 0.0)
    }
}

/// White, and its left half not there.
fn right_half() -> Texture {
    let texels = (0..64 * 64).map(|i| [255, 255, 255, if i % 64 < 32 { 0 } else { 255 }]).collect();
    Texture { size: [64; 2], wrap: [Wrap::Clamp; 2], filter: Filter::Linear, texels }
}

/// A wall of side 2 at z = 0 with something before it, `scale` times as large.
fn hung(hangs: Hangs, scale: f32, map: Environment) -> Bundle {
    let mut scene = sparse::scene([9, 9]);
    let wall = scene.positions.len() as u32;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    scene.positions.extend(corners.map(|[x, y]| [SQUARE * x, SQUARE * y, BEFORE]));
    scene.positions.iter_mut().flatten().for_each(|x| *x *= scale);
    scene.normals.resize(scene.positions.len(), [0.0, 0.0, 1.0]);
    scene.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|corner| wall + corner)));
    let mut square = scene.meta.objects[0].clone();
    (square.name, square.triangles) = ("square".to_owned(), 2);
    // The first material is the one that may have a texture.
    scene.meta.objects[0].material = 1;
    square.material = 0;
    scene.meta.objects.push(square);
    scene.meta.size = SIZE;
    scene.meta.environment = Some(environment("night", 0.0, [1.0; 3]));
    let vertices = scene.positions.len() as u32;
    let textures = (hangs == Hangs::Half).then(|| {
        let mut uvs = vec![[0.0; 2]; wall as usize];
        uvs.extend(corners.map(|corner| corner.map(|x| 0.5 + 0.5 * x)));
        let cut = MaterialTexture { material: 0, alpha_cutoff: Some(0.5), texture: right_half() };
        Textures { uvs, textures: vec![cut] }
    });
    Bundle::of(scene, vec![map], textures.as_ref(), sparse::even_transfer(vertices, 4, 1.0))
}

/// Where a ray from `eye` meets the scene of scale 1.
fn seen(hangs: Hangs, eye: Vec3, direction: Vec3) -> Option<Vec3> {
    let at = |z: f32| eye + direction * ((z - eye.z) / direction.z);
    let (before, wall) = (at(BEFORE), at(0.0));
    if hangs.is_at(before) { Some(before) } else { (wall.x.abs().max(wall.y.abs()) < 1.0).then_some(wall) }
}

/// The share of a disc around `towards` of radius `tangent` that is not behind what hangs there.
fn visibility(hangs: Hangs, point: Vec3, towards: Vec3, tangent: f32) -> f32 {
    if point.z > 0.5 * BEFORE {
        return 1.0;
    }
    let (right, rays) = (towards.any_orthonormal_vector(), 24 * 24);
    let up = towards.cross(right);
    let open = (0..rays).filter(|k| {
        let distance = tangent * ((*k as f32 + 0.5) / rays as f32).sqrt();
        let (sin, cos) = (2.399_963_2 * *k as f32).sin_cos();
        let way = towards + distance * (cos * right + sin * up);
        !hangs.is_at(point + way * ((BEFORE - point.z) / way.z))
    });
    open.count() as f32 / rays as f32
}

/// What the film shows of `suns`: by pixel the least, the mean and the greatest, over suns a third larger,
/// true and a third smaller, of radiance.
fn expected(hangs: Hangs, camera: &Camera, suns: &[Sun], look: &EnvironmentLook) -> Vec<[Rgb; 3]> {
    let film = camera.film(SIZE[0], SIZE[1]);
    let pixel = |index: u32| {
        let mut sums = [[0.0; 3]; 3];
        for sample in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]] {
            let direction =
                film.direction((index % SIZE[0]) as f32 + sample[0], (index / SIZE[0]) as f32 + sample[1]);
            let Some(point) = seen(hangs, camera.position.into(), direction.into()) else { continue };
            for sun in suns {
                let way = towards(sun, look.rotation_deg);
                if way.z <= 0.0 {
                    continue;
                }
                let shares =
                    [0.67, 1.0, 1.33].map(|size| visibility(hangs, point, way, size * sun.radius.tan()));
                let least = shares.into_iter().fold(1.0, f32::min);
                let most = shares.into_iter().fold(0.0, f32::max);
                for (sum, share) in sums.iter_mut().zip([least, shares[1], most]) {
                    let shown = radiance(sun, look, Vec3::Z, share);
                    (0..3).for_each(|c| sum[c] += 0.25 * shown[c] * sparse::ALBEDO[c]);
                }
            }
        }
        sums
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// A bowl of 16 x 16 squares, each turned by 7° from the next, under a sun: nothing of it hides any of the
/// disc, so that it looks everywhere the same with normals that are.
#[test]
fn facets_of_a_bowl_do_not_shadow_each_other() {
    let Some(gpu) = gpu() else { return };
    let towards_sun = Vec3::new(0.05, 0.03, 1.0);
    let map = night(&[towards_sun]);
    let sun = split(&map.map).suns[0];
    for rotation_deg in [0.0, 0.25, 0.5] {
        let mut scene = sparse::scene([17, 17]);
        scene.positions.iter_mut().for_each(|[x, y, z]| *z = 0.5 * (*x * *x + *y * *y));
        scene.meta.size = SIZE;
        let look_of_map = environment("night", rotation_deg, [1.0; 3]);
        scene.meta.environment = Some(look_of_map.clone());
        let vertices = scene.positions.len() as u32;
        let bundle = Bundle::of(scene, vec![map.clone()], None, sparse::even_transfer(vertices, 4, 1.0));
        let camera = Camera { position: [1.0, 0.7, 2.5], target: [0.0; 3], fov_deg: 20.0, exposure_ev: 0.0 };
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &look_of_map) });
        let shown = read_radiance(&gpu, &method.film().unwrap().bands);
        let expected = radiance(&sun, &look_of_map, Vec3::Z, 1.0);
        let wrong = |pixel: &&Rgb| {
            (0..3).any(|c| (pixel[c] - expected[c] * sparse::ALBEDO[c]).abs() > 1e-3 * expected[c])
        };
        let wrong = shown.iter().filter(wrong).count();
        assert_eq!(wrong, 0, "of {} pixels at {rotation_deg}°", shown.len());
    }
}

/// Where the sun is wholly in sight or wholly hidden, and would be if it were a third larger or smaller, the
/// picture shows just that; elsewhere what is seen of the disc is known to a few per cent.
#[test]
fn shadows_of_suns_are_those_of_rays() {
    let Some(gpu) = gpu() else { return };
    let (one, other) = (Vec3::new(0.35, 0.2, 1.0), Vec3::new(-0.4, 0.25, 1.0));
    // Along an edge of the cube, grazing, behind everything, two at once, and turned.
    let cases: [(Hangs, &[Vec3], f32, f32); 12] = [
        (Hangs::Square, &[one], 0.0, 1.0),
        (Hangs::Square, &[one], 0.0, 1000.0),
        (Hangs::Square, &[one], 0.0, 0.001),
        (Hangs::Square, &[Vec3::new(1.0, 0.3, 1.0)], 0.0, 1.0),
        (Hangs::Square, &[Vec3::new(1.0, 0.0, 0.06)], 0.0, 1.0),
        (Hangs::Square, &[Vec3::new(0.3, 1.2, -1.0)], 0.0, 1.0),
        (Hangs::Square, &[one, other], 0.0, 1.0),
        (Hangs::Square, &[one], 25.0, 1.0),
        (Hangs::Half, &[one], 0.0, 1.0),
        // Columns of pixels along the rims of penumbras, where a look that misses shows most.
        (Hangs::Half, &[Vec3::new(0.342, 0.2, 1.0)], 0.0, 1.0),
        (Hangs::Square, &[Vec3::new(0.362, 0.2, 1.0)], 0.0, 1.0),
        (Hangs::Half, &[one, other], 25.0, 1.0),
    ];
    for (hangs, discs, rotation_deg, scale) in cases {
        let map = night(discs);
        let suns = split(&map.map).suns;
        assert_eq!(suns.len(), discs.len());
        let bundle = hung(hangs, scale, map);
        let environment = environment("night", rotation_deg, [1.0, 2.0, 0.5]);
        let camera = Camera { position: [0.25, 0.2, 4.0], target: [0.0; 3], fov_deg: 30.0, exposure_ev: 0.0 };
        let there = Camera { position: camera.position.map(|x| x * scale), ..camera };
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &Look { camera: there, ..look(&bundle, &environment) });
        let shown = read_radiance(&gpu, &method.film().unwrap().bands);
        let expected = expected(hangs, &camera, &suns, &environment);
        let full = expected.iter().flatten().flatten().fold(0.0_f32, |m, v| m.max(*v));
        let (mut penumbra, mut off, mut wrong) = (0, 0.0, 0);
        for (shown, [least, mean, most]) in shown.iter().zip(&expected) {
            for c in 0..3 {
                if least[c] == most[c] {
                    wrong += usize::from((shown[c] - mean[c]).abs() > 1e-3 * full.max(1e-6));
                } else {
                    penumbra += 1;
                    off += ((shown[c] - mean[c]) / full).powi(2);
                }
            }
        }
        let off = (off / penumbra.max(1) as f32).sqrt();
        println!("{hangs:?} {discs:?} {rotation_deg} {scale}: {wrong} wrong, {off} off in {penumbra}");
        // Samples at the very edge of the square or the wall may fall to either side.
        assert!(wrong <= 12, "{hangs:?} {discs:?} {rotation_deg} {scale}: {wrong} are wrong");
        assert!(off < 0.03, "{hangs:?} {discs:?} {rotation_deg} {scale}: {off}");
        assert!((full > 0.0) == (discs[0].z > 0.0));
    }
}
