//! What goes out comes back; what is wrong is refused with a line that helps.

use super::figures::{CSV, Chart, JSON, SVG, machine, today};
use super::files::write;
use super::test_chart::chart;

#[test]
fn a_chart_comes_back_bit_for_bit_and_its_files_repeat() {
    let [a, b] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let mut chart = chart();
    chart.points[1].errors.maximum.worst = f64::INFINITY;
    chart.points[2].errors.flip.median = 0.1 + 0.2;
    chart.points[3].bytes_on_disk = u64::MAX;
    [&a, &b].into_iter().for_each(|folder| write(&chart, folder.path()).unwrap());
    assert_eq!(Chart::read(a.path()).unwrap(), chart);
    for name in [JSON, CSV, SVG] {
        assert_eq!(
            std::fs::read(a.path().join(name)).unwrap(),
            std::fs::read(b.path().join(name)).unwrap(),
            "{name}"
        );
    }
    assert_eq!(std::fs::read_dir(a.path()).unwrap().count(), 3, "nothing else is left there");
}

#[test]
fn a_bad_file_is_refused_with_its_name_and_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |what: &str| {
        let message = Chart::read(folder.path()).unwrap_err().to_string();
        assert!(
            message.contains(JSON)
                && message.ends_with(&format!("`bake chart SCENE -o {}`", folder.path().display())),
            "{message}"
        );
        assert!(message.contains(what) && !message.contains('\n'), "{message}");
    };
    refused("there is no chart here");
    let path = folder.path().join(JSON);
    let good = serde_json::to_value(chart()).unwrap();
    let changed = |pointer: &str, value: serde_json::Value| {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = value;
        std::fs::write(&path, bad.to_string()).unwrap();
    };
    std::fs::write(&path, "{").unwrap();
    refused("EOF");
    changed("/points/0/errors/flip/median", "large".into());
    refused("an error is `large`");
    changed("/points/0/errors/flip/median", (-0.5).into());
    refused("-0.5");
    changed("/points/4/frame/median_ms", (-1.0).into());
    refused("a time of transfer-images, 256 spp, 6 bases is -1");
    changed("/points", serde_json::json!([]));
    refused("0 points");
    changed("/points", vec![good["points"][0].clone(); 500].into());
    refused("500 points");
    changed("/points", vec![good["points"][0].clone(); 2].into());
    refused("two points are called transfer-images, 256 spp, 2 bases");
    changed("/size", serde_json::json!([256, 0]));
    refused("256×0 pixels");
    changed("/scene", "x".repeat(300).into());
    refused("longer than 200 bytes");
    changed("/scene", "a\nb".into());
    refused("not one line");
    changed("/noise", serde_json::json!({ "flip": 3 }));
    refused("expected struct OverStates");
    let mut extra = good.clone();
    extra["speed"] = 3.into();
    std::fs::write(&path, extra.to_string()).unwrap();
    refused("unknown field `speed`");
}

#[test]
fn figures_that_are_no_numbers_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut bad = chart();
    bad.points[0].errors.flip.worst = f64::NAN;
    assert!(
        write(&bad, folder.path())
            .unwrap_err()
            .to_string()
            .contains("transfer-images, 256 spp, 2 bases is NaN")
    );
    let mut bad = chart();
    bad.points[0].frame.ratio = f64::INFINITY;
    assert!(write(&bad, folder.path()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn machine_and_day_can_be_told() {
    assert!(machine().contains(" cores, "), "{}", machine());
    let today = today();
    let day: Vec<u32> = today.split('-').map(|part| part.parse().unwrap()).collect();
    assert!(
        today.len() == 10
            && day.len() == 3
            && day[0] >= 2026
            && (1..=12).contains(&day[1])
            && (1..=31).contains(&day[2]),
        "{today}"
    );
}
