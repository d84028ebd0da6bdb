//! Manifests that break their rules, each with the line that a user reads.

use relume_formats::Error;
use relume_formats::kinds::Manifest;

const MANIFEST: &str = r#"{
    "version": 0, "scene": "box", "scene_hash": "00000000000000000000000000000000",
    "scene_file": {"file": "scene.relume", "bytes": 1, "hash": "00000000000000000000000000000000"},
    "animations": {"turn": {"file": "turn.relume", "bytes": 1, "hash": "00000000000000000000000000000000"}},
    "methods": [{"name": "transfer-images", "reads": "0123456789abcdef0123456789abcdef", "files": [["brdf-basis", {"file": "basis.relume", "bytes": 1, "hash": "00000000000000000000000000000000"}]],
                 "settings": {"bases": 6}, "errors": {"relative_l2": 0.001}}]
}"#;

fn read_manifest(text: &[u8]) -> Result<Manifest, Error> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("manifest.json"), text).unwrap();
    Manifest::read(folder.path())
}

#[test]
fn broken_manifests() {
    assert_eq!(read_manifest(MANIFEST.as_bytes()).unwrap().entries().count(), 3);
    let long = format!("\"errors\": {{}}, \"measured_on\": \"{}\"", "x".repeat(1_000_000));
    let cases = [
        ("\"version\": 0,", "", "has no version"),
        ("\"version\": 0", "\"version\": -1", "has no version"),
        ("\"version\": 0", "\"version\": \"0\"", "has no version"),
        ("\"scene\": \"box\",", "", "the manifest: key `scene` is missing"),
        ("\"scene\": \"box\"", "\"scene\": 3", "scene: 3 where a text is expected"),
        (
            "\"scene\": \"box\"",
            "\"scene\": \"a\\u001b[2J\"",
            "the name `a\\u{1b}[2J` of the scene has control characters",
        ),
        (
            "\"scene\": \"box\"",
            "\"scene\": \"box\", \"scene\": \"box\"",
            "line 2, column 48: key `scene` is there twice",
        ),
        (
            "\"bytes\": 1",
            "\"bytes\": -1",
            "scene_file.bytes: -1 where a whole number of at least 0 is expected",
        ),
        ("\"bytes\": 1", "\"bytes\": \"x\"", "scene_file.bytes: \"x\" where a whole number"),
        ("\"bytes\": 1", "\"bytes\": 1, \"more\": 2", "scene_file: key `more` is unknown"),
        ("\"bytes\": 1", "\"bytes\": 1, \"\\u001b\": 2", "scene_file: key `\\u{1b}` is unknown"),
        ("\"settings\"", "\"setings\"", "methods[0]: key `setings` is unknown; did you mean `settings`?"),
        ("\"animations\": {", "\"animations\": {\"turn\": 3}, \"x\": {", "key `x` is unknown"),
        ("\"turn\": {", "\"turn\": 3, \"turn\": {", "key `turn` is there twice"),
        ("\"turn\": {", "\"tu\\nrn\": {", "control characters"),
        ("[[\"brdf-basis\", ", "[[", "methods[0].files[0]: a kind and a file are expected"),
        ("[[\"brdf-basis\"", "[[7", "methods[0].files[0]: 7 where a text is expected"),
        ("\"reads\": \"0", "\"reads\": \"x", "method `transfer-images`: `reads` is no hash of 32 digits"),
        ("0.001", "null", "methods[0].errors.relative_l2: null where a number is expected"),
        ("0.001", "\"x\"", "methods[0].errors.relative_l2: \"x\" where a number is expected"),
        ("0.001", "-1", "measured error `relative_l2` is -1e0, outside 0..1e100"),
        ("0.001", "1e308", "measured error `relative_l2` is 1e308, outside 0..1e100"),
        ("0.001", "1e999", "line 6, column"),
        ("0.001", "NaN", "line 6, column"),
        (
            "\"relative_l2\": 0.001",
            "\"relative_l2_median\": 2, \"relative_l2_worst\": 1",
            "`relative_l2_median` is 2e0, above the worst, 1e0",
        ),
        ("\"relative_l2\"", "\"relative l2\"", "`relative l2` is no name of a setting or error"),
        (
            "\"bases\": 6",
            "\"bases\": \"x\"",
            "method `transfer-images`: setting `bases` is \"x\", expected a whole number of at least 0",
        ),
        ("\"bases\": 6", "\"size\": [9]", "setting `size` is [9], expected [width, height]"),
        ("\"bases\": 6", "\"basis\": 6", "setting `basis` is unknown; did you mean `bases`?"),
        ("\"bases\": 6", "\"max_error\": -0.5", "setting `max_error` is -0.5, expected a number above 0"),
        ("\"bases\": 6", "\"x\": \"\\u0007\"", "control characters"),
        (
            "\"errors\": {\"relative_l2\": 0.001}",
            long.as_str(),
            "`measured_on` has more than 1000 characters",
        ),
        (
            "\"scene_hash\": \"0",
            "\"scene_hash\": \"z",
            "the hash `z0000000000000000000000000000000` of `scene_hash` is not 32 digits",
        ),
        ("\"scene_hash\": \"0", "\"scene_hash\": \"", "is not 32 digits"),
        ("\"hash\": \"0", "\"hash\": \"A", "of `scene.relume` is not 32 digits"),
        ("]\n}", "", "ends early, at line 6; the file is cut short; copy the bundle again, or bake it again"),
        ("]\n}", "]\n", "ends early, at line 7"),
        ("]\n}", "],\n}", "line 7, column 1: trailing comma"),
        ("]\n}", "]\n} x", "line 7, column 3: trailing characters"),
        ("scene.relume", "../scene.relume", "`../scene.relume` is no plain file name"),
        ("scene.relume", "/etc/passwd", "`/etc/passwd` is no plain file name"),
        ("turn.relume", "sub/turn.relume", "is no plain file name"),
        ("turn.relume", "..", "is no plain file name"),
        ("basis.relume", ".hidden", "is no plain file name"),
        ("basis.relume", "", "is no plain file name"),
        ("basis.relume", "c:\\\\basis.relume", "is no plain file name"),
    ];
    for (from, to, expected) in cases {
        let text = MANIFEST.replacen(from, to, 1);
        assert_ne!(text, MANIFEST, "the case `{from}` changes something");
        let error = read_manifest(text.as_bytes()).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::Invalid { .. }) && message.contains(expected), "`{to}`: {message}");
        assert!(message.contains("manifest.json: ") && message.contains("bake it again"), "{message}");
        assert!(!message.chars().any(char::is_control) && message.chars().count() < 500, "{message}");
    }
}

#[test]
fn manifests_that_are_not_there_or_not_ours() {
    let error = read_manifest(MANIFEST.replace("\"version\": 0", "\"version\": 12").as_bytes()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }));
    assert!(error.to_string().contains("manifest version 12, this program reads version 0"), "{error}");
    assert!(read_manifest(b"\xff\xfe").unwrap_err().to_string().contains("not a text file"));
    assert!(read_manifest(&[b'['; 100_000]).unwrap_err().to_string().contains("recursion limit"));

    let folder = tempfile::tempdir().unwrap();
    let error = Manifest::read(folder.path()).unwrap_err();
    assert!(matches!(error, Error::Invalid { .. }));
    assert!(
        error.to_string().contains("holds no bundle (no manifest.json); make one with `bake run"),
        "{error}"
    );
}
