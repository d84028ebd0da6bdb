//! Scenes drawn at random, mostly sensible and always a little odd: what is baked is taken by every reader,
//! and what is not is refused by a line.

use crate::support::{command, job};
use relume_bake::bundle;
use relume_bake::unfinished::Leftover;

use relume_bake::inspect;
use relume_bake::methods::asked::{Asked, Quality};
use relume_bake::methods::choice::METHODS;
use relume_bake::methods::registered::Registered;
use std::fmt::Write as _;
use std::path::Path;

/// Odd numbers one after the other.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// A sensible value, or now and then an odd one.
    fn draw<'a>(&mut self, sensible: &[&'a str], odd: &[&'a str]) -> &'a str {
        if !odd.is_empty() && self.one_in(24) {
            odd[self.below(odd.len())]
        } else {
            sensible[self.below(sensible.len())]
        }
    }
}

const NAMES: [&str; 4] = ["a", "torus knot", "x.y_z-1", "N"];
const ODD_NAMES: [&str; 7] = [
    "../up",
    "é",
    "\\u001b[2J",
    "a\\nb",
    "",
    "con",
    "zzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzz",
];
const ODD_LENGTHS: [&str; 8] = ["0", "-1", "1e-30", "1e-6", "1e6", "1e19", "1e30", "nan"];
const ODD_LIGHTS: [&str; 6] = [
    "[0, 0, 0]",
    "[1e12, 1e12, 1e12]",
    "[1e-38, 1e-38, 1e-38]",
    "[1e13, 0, 0]",
    "[1e9, 1e-9, 0]",
    "[-1, 1, 1]",
];

fn scene(dice: &mut Dice) -> String {
    let (moves, deforms) = (dice.one_in(2), dice.one_in(3));
    let mut text = format!(
        "[vary]\nlight = {moves}\nview = {moves}\nshape = {}\nmaterials = [\"{}\"]\n",
        moves && deforms,
        NAMES[0]
    );
    let size = dice.draw(
        &["[8, 8]", "[5, 9]", "[1, 1]", "[16, 3]"],
        &["[16384, 1]", "[1, 700]", "[0, 4]", "[16384, 16384]", "[20000, 1]"],
    );
    let _ = writeln!(
        text,
        "[render]\nsize = {size}\nreflections = {}",
        if moves { dice.draw(&["1"], &["2", "0", "9"]) } else { dice.draw(&["1", "2"], &["0", "3"]) }
    );
    let eye = dice.draw(
        &["[0, 1, 3]", "[0, 0.1, 0]", "[3, -2, 1]"],
        &["[0, 0, 0]", "[1e30, 0, 0]", "[nan, 0, 0]", "[0, 1e-30, 1]", "[1e6, 1e6, 1e6]"],
    );
    let fov = dice.draw(&["40", "90", "0.5"], &["0.1", "170", "180", "0", "1e-3"]);
    let ev = dice.draw(&["0", "-2.5"], &["32", "33", "-32", "inf"]);
    let _ =
        writeln!(text, "[camera]\nposition = {eye}\ntarget = [0, 0, 0]\nfov_deg = {fov}\nexposure_ev = {ev}");
    for name in &NAMES[..2] {
        let colour = dice.draw(
            &["[0.5, 0.5, 0.5]", "[0, 0, 0]", "[1, 0, 0.2]"],
            &["[1, 1, 1.1]", "[1e-38, 0, 0]", "[nan, 0, 0]"],
        );
        let _ = match dice.below(3) {
            0 => writeln!(
                text,
                "[materials.\"{name}\"]\nbrdf = \"blinn-phong\"\nkd = {colour}\nshininess = {}",
                dice.draw(&["1", "20", "200"], &["201", "0", "1e9"])
            ),
            1 => writeln!(
                text,
                "[materials.\"{name}\"]\nbrdf = \"cook-torrance\"\nkd = {colour}\nfresnel = {}\nroughness = {}",
                dice.draw(&["0.04", "1"], &["1.1", "-1", "nan"]),
                dice.draw(&["0.1", "1"], &["0.015", "0.01", "2"])
            ),
            _ => writeln!(
                text,
                "[materials.\"{name}\"]\nbrdf = \"ggx\"\nbase_color = {colour}\nroughness = {}",
                dice.draw(&["0.5", "1"], &["0.32", "0.1", "0", "2"])
            ),
        };
    }
    for number in 0..1 + dice.below(3) {
        object(dice, number, moves && deforms, &mut text);
    }
    match moves {
        true => {
            let file = dice.draw(&["clear-sky", "white", "lamps"], &["nowhere", "../../x.hdr"]);
            let gain = dice.draw(&["[1, 1, 1]", "[0.1, 2, 3]"], &ODD_LIGHTS);
            let turn = dice.draw(&["0", "45", "-721"], &["1e30", "nan"]);
            let _ = writeln!(text, "[environment]\nfile = \"{file}\"\ngain = {gain}\nrotation_deg = {turn}");
        }
        false => {
            let (kind, unit) =
                [("point", "intensity"), ("area", "radiance"), ("directional", "irradiance")][dice.below(3)];
            let (name, emission) =
                (dice.draw(&NAMES, &ODD_NAMES), dice.draw(&["[10, 9, 8]", "[1, 1, 1]"], &ODD_LIGHTS));
            let scale = dice.draw(&["1", "0.2"], &ODD_LENGTHS);
            let _ = writeln!(text, "[[light]]\nname = \"{name}\"\nkind = \"{kind}\"\n{unit} = {emission}");
            let _ = writeln!(
                text,
                "transform = {{ translation = [0, 2, 1], rotation_deg = [-70, 0, 0], scale = {scale} }}"
            );
        }
    }
    text
}

fn object(dice: &mut Dice, number: usize, deforms: bool, text: &mut String) {
    let shape = dice.draw(
        &[
            "shape = \"box\"",
            "shape = \"sphere\"\nsubdivisions = 1",
            "shape = \"quad\"\nsegments = 3",
            "shape = \"torus\"\nsegments = 6\nsides = 4",
        ],
        &[
            "shape = \"quad\"\nsegments = 2049",
            "shape = \"torus\"\nmajor_radius = 1e-9\nminor_radius = 1e-10",
            "shape = \"ring\"\nheight = 1e-12",
        ],
    );
    let scale = dice.draw(&["1", "0.3", "[1, 2, 1]", "-1"], &ODD_LENGTHS);
    let at = dice.draw(&["[0, 0, 0]", "[0.5, -0.7, 0]"], &["[1e20, 0, 0]", "[1e6, 1e6, 0]"]);
    let _ = writeln!(
        text,
        "[[object]]\nname = \"{}{number}\"\nmaterial = \"{}\"\n{shape}",
        dice.draw(&NAMES, &ODD_NAMES),
        NAMES[dice.below(2)]
    );
    let _ = writeln!(text, "transform = {{ translation = {at}, scale = {scale} }}");
    if deforms && number == 0 {
        let seconds = dice.draw(&["4", "0.5"], &["1e-300", "0.001", "86400", "1e9", "0"]);
        let _ = writeln!(
            text,
            "spheres = {}\ntwist_deg = {}\ntwist_s = {seconds}",
            dice.draw(&["1", "3"], &["0", "4097"]),
            dice.draw(&["40", "-360"], &["0", "1e-30", "400"])
        );
    }
}

/// What came of a scene.
enum Outcome {
    Baked,
    Refused(String),
}

fn outcome(folder: &Path, method: &Registered) -> Outcome {
    let scene = match relume_scenes::load(&folder.join("scene.toml")) {
        Ok(scene) => scene,
        Err(error) => {
            assert!(error.is_bad_input(), "{error}");
            return Outcome::Refused(error.to_string());
        }
    };
    let asked = Asked {
        quality: Quality::Draft,
        samples: Some(1),
        bases: Some(3),
        terms: Some(4),
        ..Asked::of_scene(&scene)
    };
    match bundle::run(
        &scene,
        &[(method.new)(&asked, &scene)],
        scene.size,
        &folder.join("out"),
        Leftover::Refuse,
        0,
        &job(),
    ) {
        Ok(_) => Outcome::Baked,
        Err(error) => {
            assert_eq!(error.exit_code(), 2, "{error}");
            Outcome::Refused(error.to_string())
        }
    }
}

/// Bakes the scenes of some seeds by a method that fits what varies; every so many bundles are played too.
fn bake_all(seeds: std::ops::Range<u64>, play_one_in: usize) {
    let mut baked = 0;
    for seed in seeds.clone() {
        let mut dice = Dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let text = scene(&mut dice);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), &text).unwrap();
        let method = if text.contains("shape = true") {
            METHODS[2]
        } else {
            METHODS[usize::from(text.contains("view = true"))]
        };
        let out = folder.path().join("out");
        match outcome(folder.path(), method) {
            Outcome::Refused(reason) => {
                assert!(!reason.chars().any(char::is_control), "{reason:?}");
                assert!(!out.exists(), "seed {seed}: {reason}, but something was written for\n{text}");
            }
            Outcome::Baked => {
                inspect::verify(&out).unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
                if baked % play_one_in == 0 {
                    let frame = folder.path().join("f.exr");
                    let output = command("player")
                        .arg(&out)
                        .args(["--headless", "--exr"])
                        .arg(frame)
                        .output()
                        .unwrap();
                    let said = String::from_utf8_lossy(&output.stderr);
                    assert_eq!(output.status.code(), Some(0), "seed {seed}: {said}\n{text}");
                }
                baked += 1;
            }
        }
    }
    let count = (seeds.end - seeds.start) as usize;
    println!("{baked} of {count} scenes were baked");
    // Most scenes are sensible enough to bake, or nothing would be tested; some are not.
    assert!(baked * 4 >= count && baked < count, "{baked} of {count}");
}

#[test]
fn what_is_baked_is_taken_by_every_reader() {
    bake_all(0..20, 4);
}

#[test]
#[ignore = "takes minutes"]
fn what_is_baked_is_taken_by_every_reader_of_many_scenes() {
    bake_all(1000..3000, 10);
}
