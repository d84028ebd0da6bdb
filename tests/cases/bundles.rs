//! Bundles whose values make no sense, and those too large.
//!
//! A small bundle of each method is baked, then one value of one of its files is changed and all checksums
//! are mended. Whatever reads bundles must be of one mind about what comes of it, and what is accepted must
//! show a finite picture.

use crate::support::{copy_folder, job, run, write_scene};
use raw_file::{RawFile, RawSection};
use relume_bake::bundle;
use relume_bake::inspect;
use relume_bake::method::Method;
use relume_bake::methods::{sparse_transfer, sphere_shadows, transfer_images};
use relume_bake::unfinished::Leftover;
use relume_formats::Place;
use relume_formats::bundle::Look;
use relume_formats::container::Stored;
use relume_formats::evaluate::sphere_shadows::{Casters, Detail, Spheres, light, lobe, radiance, receivers};
use relume_formats::evaluate::{sparse_transfer as rows, transfer_images as images};
use relume_formats::kinds::manifest::FileEntry;
use relume_formats::kinds::{
    BrdfBasis, Environment, HaarTable, Manifest, SparseTransfer, SphereSet, SphereShadows, StoredScene,
    TransferImages,
};
use relume_formats::shape::Rims;
use relume_formats::state::{Rgb, State};
use relume_playback::{PlacedState, Progress};
use relume_player::gpu::Gpu;
use relume_player::session::{Request, Session};
use relume_scenes::Scene;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

mod sections;

#[path = "../../formats/tests/support/raw_file.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod raw_file;

/// A ball over a plane; the rest of the scene follows.
const SCENE: &str = "
    [render]
    size = [6, 5]
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
    kd = [0.5, 0.3, 0.1]
    ks = [0.3, 0.3, 0.3]
    shininess = 20.0
    [[object]]
    name = 'plane'
    shape = 'quad'
    segments = 3
    material = 'plane'
    transform = { scale = 4.0 }
    [environment]
    file = 'clear-sky'
    [[object]]
    name = 'ball'
    material = 'ball'
";
const BALL: &str =
    "shape = 'sphere'\n subdivisions = 1\n transform = { translation = [0.0, 1.0, 0.0], scale = 0.4 }\n";
const KNOT: &str = "shape = 'torus-knot'\n segments = 24\n sides = 4\n tube = 0.2\n twist_deg = 90.0\n twist_s = 2.0\n spheres = 3\n";

/// A bundle that is sound, and what its files are.
struct Sound {
    folder: tempfile::TempDir,
    files: Vec<(PathBuf, RawFile)>,
}

impl Sound {
    fn bake(vary: &str, object: &str, animation: &str, method: impl Fn(&Scene) -> Box<dyn Method>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("animations")).unwrap();
        std::fs::write(folder.path().join("animations/turn.toml"), animation).unwrap();
        let scene =
            relume_scenes::load(&write_scene(folder.path(), &format!("[vary]\n{vary}\n{SCENE}{object}")))
                .unwrap();
        let out = folder.path().join("out");
        bundle::run(&scene, &[method(&scene)], scene.size, &out, Leftover::Refuse, 0, &job()).unwrap();
        let manifest = Manifest::read(&out).unwrap();
        let file = |entry: &FileEntry| {
            (out.join(&entry.file), RawFile::parse(&std::fs::read(out.join(&entry.file)).unwrap()))
        };
        let files = manifest.entries().map(file).collect();
        Self { folder, files }
    }

    /// Another one of it.
    fn copy(&self) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (self.out(), folder.path().join("out"));
        copy_folder(&from, &to);
        let files = self
            .files
            .iter()
            .map(|(path, file)| (to.join(path.file_name().unwrap()), file.clone()))
            .collect();
        Self { folder, files }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn images() -> Self {
        let method = transfer_images::TransferImagesMethod {
            size: [6, 5],
            samples: 4,
            seed: 5,
            bases: transfer_images::Bases::Number(3),
            filter: true,
            noise: None,
        };
        let animation = "duration_s = 2.0\n[[key]]\nt_s = 0\nmaterials.ball.kd = [0.1, 0.2, 0.3]\n[[key]]\nt_s = 2\nmaterials.ball.kd = [0.6, 0.2, 0.3]";
        Self::bake("materials = ['ball']", BALL, animation, |_| Box::new(method))
    }

    fn rows() -> Self {
        let settings =
            sparse_transfer::Settings { rays_per_texel: 1, terms: sparse_transfer::Terms::Number(20) };
        Self::bake("light = true\nview = true", BALL, TURN, |_| {
            Box::new(sparse_transfer::SparseTransferMethod { settings })
        })
    }

    fn shadows() -> Self {
        let method = |scene: &Scene| -> Box<dyn Method> {
            Box::new(sphere_shadows::SphereShadowsMethod::new(scene, 0, sphere_shadows::Asked::Spheres))
        };
        Self::bake("light = true\nview = true\nshape = true", KNOT, TURN, method)
    }

    /// The file called `name`.
    fn file(&self, name: &str) -> &(PathBuf, RawFile) {
        self.files.iter().find(|(path, _)| path.ends_with(name)).unwrap()
    }

    /// Puts a file into the bundle with `change` made to it, hash and length mended.
    fn change(&self, path: &Path, change: impl FnOnce(&mut RawFile)) {
        let mut file = self.files.iter().find(|(other, _)| other == path).unwrap().1.clone();
        change(&mut file);
        file.section_count = file.sections.len() as u64;
        self.put(path, &file.bytes());
    }

    fn put(&self, path: &Path, bytes: &[u8]) {
        std::fs::write(path, bytes).unwrap();
        let mut manifest = Manifest::read(&self.out()).unwrap();
        let name = path.file_name().unwrap().to_str().unwrap();
        let mend = |entry: &mut FileEntry| {
            if entry.file == name {
                *entry = FileEntry::of(name, bytes);
            }
        };
        mend(&mut manifest.scene_file);
        manifest.animations.values_mut().for_each(mend);
        manifest.sphere_sets.values_mut().for_each(|set| mend(&mut set.file));
        manifest.methods.iter_mut().flat_map(|method| &mut method.files).for_each(|(_, entry)| mend(entry));
        manifest.write(&self.out()).unwrap();
    }

    /// Makes the file whole again.
    fn mend(&self, path: &Path) {
        self.change(path, |_| ());
    }
}

/// A bundle of each method.
static SOUND: LazyLock<[Sound; 3]> = LazyLock::new(|| [Sound::images(), Sound::rows(), Sound::shadows()]);

const TURN: &str = "duration_s = 2.0\n[[key]]\nt_s = 0\nenvironment.rotation_deg = 0.0\ncamera.fov_deg = 40.0\n[[key]]\nt_s = 2\nenvironment.rotation_deg = 90.0";

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Changes one value of `section`: scaled, negated, zeroed, beyond all numbers, or exchanged with another; of
/// a record a byte.
fn change_value(section: &mut RawSection, random: &mut Random) {
    let mut raw = section.raw();
    let width = RawSection::width(section.element);
    if raw.len() < width {
        return;
    }
    let (at, other) = (random.below(raw.len() / width) * width, random.below(raw.len() / width) * width);
    let scale = [0.0, -1.0, 1000.0, 1e30, 3e38, f32::NAN, f32::INFINITY, 1e-3][random.below(8)];
    let value: [u8; 4] = std::array::from_fn(|k| raw.get(at + k).copied().unwrap_or(0));
    match section.element {
        _ if random.below(6) == 0 => (0..width).for_each(|k| raw.swap(at + k, other + k)),
        4 => raw[at..at + 4].copy_from_slice(&(f32::from_le_bytes(value) * scale).to_le_bytes()),
        3 => raw[at..at + 2].copy_from_slice(
            &half::f16::from_f32(half::f16::from_le_bytes([value[0], value[1]]).to_f32() * scale)
                .to_le_bytes(),
        ),
        _ => raw[at] = [raw[at].wrapping_add(1), raw[at] ^ 0x80, 0, 255][random.below(4)],
    }
    section.set_raw(&raw);
}

/// What the player says of the bundle in `folder`, all of it loaded and one frame drawn.
fn play(folder: &Path) -> relume_player::Result<Vec<Rgb>> {
    let state = PlacedState { state: State::default(), place: Place::file("defaults") };
    let request = Request {
        folder,
        method: None,
        state,
        animation: None,
        environment: None,
        meters: false,
        size: None,
        limits: Default::default(),
    };
    let mut session = Session::start(request, || Gpu::open(None))?;
    loop {
        match session.advance()? {
            Progress::Waiting => std::thread::yield_now(),
            Progress::Arrived => {}
            Progress::Loaded { .. } => return Ok(session.render(0.0)?.radiance),
        }
    }
}

/// The radiance that the bundle in `folder` means, as the scene has it and with every clip at its middle.
fn evaluate(folder: &Path) -> Vec<Rgb> {
    let manifest = Manifest::read(folder).unwrap();
    let scene = StoredScene::read_file(&folder.join(&manifest.scene_file.file)).unwrap();
    let method = &manifest.methods[0];
    let of_kind = |kind: &'static str| {
        method.files.iter().filter(move |(k, _)| k == kind).map(|(_, entry)| folder.join(&entry.file))
    };
    let mut main = of_kind(match method.name.as_str() {
        "transfer-images" => "transfer-images",
        "sparse-transfer" => "sparse-transfer",
        _ => "sphere-shadows",
    });
    let main = main.next_back().unwrap();
    let look = Look::default_of(&scene.meta);
    if method.name == "transfer-images" {
        let basis = BrdfBasis::read_file(&of_kind("brdf-basis").next_back().unwrap()).unwrap();
        let bundle = TransferImages::read_file(&main).unwrap();
        let on_bases: Vec<_> = bundle
            .head
            .meta
            .materials
            .iter()
            .map(|name| basis.coefficients_of(&look.materials[name]).unwrap())
            .collect();
        return images::evaluate(&bundle, &on_bases);
    }
    let look = look.environment.unwrap();
    let maps: Vec<Environment> =
        of_kind("environment").map(|path| Environment::read_file(&path).unwrap()).collect();
    let map = &maps.iter().find(|map| map.name == look.map).unwrap().map;
    if method.name == "sparse-transfer" {
        let bundle = SparseTransfer::read_file(&main).unwrap();
        return rows::radiance(&bundle, &rows::light(map, &look, bundle.meta.face_size as usize));
    }
    static TABLE: LazyLock<HaarTable> = LazyLock::new(HaarTable::bake);
    let bundle = SphereShadows::read_file(&main).unwrap();
    let detail = Detail::of(&bundle.meta);
    let sets: Vec<SphereSet> = manifest
        .sphere_sets
        .values()
        .map(|set| SphereSet::read_file(&folder.join(&set.file.file)).unwrap())
        .collect();
    let places = Rims::new(scene.positions.len(), &scene.triangles).received(&scene.positions);
    let receivers = receivers(&bundle, &sets, &places, &scene.normals);
    let lobes: Vec<_> =
        (0..bundle.normals.len()).map(|row| lobe(bundle.lobe(row).to_vec(), detail.terms)).collect();
    let spheres: Vec<Spheres> = sets.iter().map(Spheres::at_rest).collect();
    radiance(
        &receivers,
        &Casters { spheres, triangles: Vec::new() },
        &lobes,
        &light(rows::light(map, &look, 32), detail.terms),
        detail.levels,
        &TABLE,
    )
}

fn is_finite(picture: &[Rgb]) -> bool {
    picture.iter().flatten().all(|x| x.is_finite())
}

/// All readers are of one mind about the bundle in `folder`; returns their verdict. `shown` says whether the
/// player is asked, too.
fn verdict(folder: &Path, what: &str, shown: bool) -> Result<(), String> {
    let verified = inspect::verify(folder).map_err(|e| e.to_string());
    let told = inspect::info(folder, false).map_err(|e| e.to_string());
    let out = tempfile::tempdir().unwrap();
    let exported = inspect::export_file(folder, out.path()).map_err(|e| e.to_string());
    assert_eq!((told.err(), exported.err()), (verified.clone().err(), verified.clone().err()), "{what}");
    if let Err(message) = &verified {
        assert!(message.contains("bake") && !message.contains('\n'), "{what}: {message}");
    } else {
        assert!(is_finite(&evaluate(folder)), "{what} is accepted and shows no picture");
    }
    if shown {
        match (play(folder), &verified) {
            (Ok(picture), Ok(_)) => assert!(is_finite(&picture), "{what}"),
            (Err(error), Err(_)) => assert_eq!(error.exit_code(), 2, "{what}: {error}"),
            (Ok(_), Err(message)) => panic!("{what}: the player shows what verify refuses: {message}"),
            (Err(error), Ok(_)) => panic!("{what}: the player refuses what verify accepts: {error}"),
        }
    }
    verified.map(drop)
}

fn gpu_there() -> bool {
    let there = relume_player::gpu::list().is_ok();
    assert!(
        there || std::env::var("RELUME_REQUIRE_GPU").as_deref() != Ok("1"),
        "RELUME_REQUIRE_GPU=1, but there is no adapter"
    );
    there
}

/// `RELUME_BUNDLE_CASES` is how many changes each bundle gets; every twentieth goes to the player.
#[test]
fn all_readers_are_of_one_mind_about_changed_bundles() {
    let asked = std::env::var("RELUME_BUNDLE_CASES").ok().and_then(|n| n.parse().ok());
    let shown = gpu_there();
    for (sound, cases) in SOUND.iter().map(Sound::copy).zip([40, 40, 6]) {
        assert_eq!(verdict(&sound.out(), "the sound bundle", shown), Ok(()));
        let mut refused = 0;
        let cases = asked.unwrap_or(cases);
        for case in 0..cases {
            let random = &mut Random(case as u64);
            let (path, file) = &sound.files[random.below(sound.files.len())];
            let at = random.below(file.sections.len());
            sound.change(path, |file| match random.below(12) {
                0 => drop(file.sections.remove(at)),
                _ => change_value(&mut file.sections[at], random),
            });
            let what = format!("case {case}: section `{}` of {}", file.sections[at].name, path.display());
            refused += u32::from(verdict(&sound.out(), &what, shown && case % 20 == 0).is_err());
            sound.mend(path);
        }
        assert!(refused as usize > cases / 4, "{refused} of {cases} changes were noticed");
    }
}

/// A float of a section, in place.
fn floats(file: &mut RawFile, section: &str, change: impl Fn(&mut [f32])) {
    let section = file.sections.iter_mut().find(|s| s.name == section).unwrap();
    let mut values: Vec<f32> = section.raw().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    change(&mut values);
    section.set_raw(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
}

/// Each of the values that `bake verify` and the player once took for sound, by the commands that users type.
#[test]
fn wrong_values_are_refused_by_every_command() {
    type Change = fn(&mut RawFile);
    let [images, rows, shadows] = SOUND.each_ref().map(Sound::copy);
    let cases: [(&Sound, &str, Change, &str); 9] = [
        (
            &images,
            "scene.relume",
            |f| floats(f, "normals", |v| v[..3].fill(0.0)),
            "section `normals`: the normal of vertex 0 is of length 0",
        ),
        (
            &shadows,
            "sphere-shadows.relume",
            |f| floats(f, "lobes", |v| v.iter_mut().for_each(|c| *c *= 1000.0)),
            "not that of the lobe",
        ),
        (
            &shadows,
            "sphere-shadows.relume",
            |f| floats(f, "lobes", |v| v.iter_mut().for_each(|c| *c = -*c)),
            "not that of the lobe",
        ),
        (
            &shadows,
            "spheres-ball.relume",
            |f| floats(f, "spheres", |v| v[3] = 1e30),
            "section `spheres`: sphere 0 of radius 1e30",
        ),
        (
            &images,
            "brdf-basis.relume",
            |f| floats(f, "parameters", |v| v.iter_mut().for_each(|p| *p = 1.0 + *p * 5e-4)),
            "expected 1 to 200",
        ),
        (&images, "brdf-basis.relume", |f| floats(f, "parameters", |v| v[0] = -1.0), "runs from -1 to 200"),
        (
            &images,
            "brdf-basis.relume",
            |f| floats(f, "coefficients", |v| v[1] = 3e38),
            "section `coefficients`: element 1, 3e38, is beyond",
        ),
        (
            &images,
            "transfer-images.relume",
            |f| floats(f, "scales", |v| v[0] = 3e38),
            "section `scales`: element 0, 3e38, is beyond",
        ),
        (&rows, "sparse-transfer.relume", unit_beyond_numbers, "section `scale/0000`: the values of vertex"),
    ];
    let shown = gpu_there();
    for (sound, name, change, expected) in cases {
        let (path, _) = sound.file(name);
        sound.change(path, change);
        let folder = sound.out().display().to_string();
        let export = sound.folder.path().join("exported").display().to_string();
        let player = ["--headless", "--exr", &format!("{export}.exr")];
        let commands: [(&str, Vec<&str>); 4] = [
            ("bake", vec!["verify", &folder]),
            ("bake", vec!["info", &folder]),
            ("bake", vec!["export", &folder, "-o", &export]),
            ("player", [&[folder.as_str()], &player[..]].concat()),
        ];
        for (binary, arguments) in commands.into_iter().take(if shown { 4 } else { 3 }) {
            let output = run(binary, &arguments);
            let text = String::from_utf8(output.stderr).unwrap();
            let refused = text.starts_with(&format!("error: {}: ", path.display()))
                && text.contains(expected)
                && text.lines().count() == 1;
            assert!(output.status.code() == Some(2) && refused, "{binary} {arguments:?}: {text}");
        }
        sound.mend(path);
    }
}

/// The unit stands before the list of blocks, two of them with 5 bytes each behind a count of 8, and a number
/// of 4.
fn unit_beyond_numbers(file: &mut RawFile) {
    let mut raw = file.sections[0].raw();
    let blocks = file.sections.len() / 3;
    let at = raw.len() - 4 - 5 * blocks - 8 - 4;
    raw[at..at + 4].copy_from_slice(&1e38f32.to_le_bytes());
    file.sections[0].set_raw(&raw);
}
