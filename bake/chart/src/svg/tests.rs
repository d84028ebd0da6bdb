use super::*;
use crate::test_chart::chart;
use std::collections::BTreeMap;

fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    document
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .map(|n| n.text().unwrap_or_default().to_owned())
        .collect()
}

#[test]
fn the_same_chart_makes_the_same_well_formed_drawing_with_every_label_in_every_panel() {
    let chart = chart();
    let svg = draw(&chart).unwrap();
    assert_eq!(svg, draw(&chart).unwrap());
    let texts = texts(&svg);
    for label in chart.points.iter().map(|p| &p.label) {
        assert_eq!(texts.iter().filter(|text| *text == label).count(), 3, "{label}");
    }
    let all = texts.join(" ");
    for fact in [
        "made-up",
        "256×256",
        "16 random states",
        "4096 samples",
        &chart.adapter,
        &chart.machine,
        &chart.date,
        &chart.program,
        &chart.baseline,
    ] {
        assert!(all.contains(fact), "{fact}");
    }
    assert_eq!(texts.iter().filter(|text| *text == "noise of the reference, 0.11 %").count(), 3);
}

#[test]
fn names_may_hold_what_xml_does_not() {
    let mut chart = chart();
    chart.points[3].label = "a < b & \"c\"".to_owned();
    assert!(texts(&draw(&chart).unwrap()).contains(&chart.points[3].label));
}

#[test]
fn what_has_no_place_on_the_axes_is_named_below() {
    let mut chart = chart();
    chart.points[2].errors.relative_l2.median = f64::INFINITY;
    chart.points[7].bake_seconds = 0.0;
    chart.noise.relative_l2.median = 1e-9;
    let all = texts(&draw(&chart).unwrap()).join(" ");
    assert_eq!(all.matches("transfer-images, 256 spp, 4 bases at").count(), 3);
    assert_eq!(all.matches("transfer-images, 256 spp, 16 bases at 0 ms").count(), 1);
    assert_eq!(all.matches("below the axis: the noise of the reference").count(), 3);
}

#[test]
fn points_too_many_for_labels_are_still_all_named() {
    let mut chart = chart();
    let one = chart.points[0].clone();
    chart.points = (0..100)
        .map(|at| Point { label: format!("a point with a long name, number {at}"), ..one.clone() })
        .collect();
    let texts = texts(&draw(&chart).unwrap());
    // Notes are broken into lines, also within a name.
    let all: BTreeMap<usize, usize> = (0..100)
        .map(|at| (at, texts.join(" ").matches(&format!("a point with a long name, number {at}")).count()))
        .collect();
    assert!(all.iter().all(|(_, count)| *count >= 3), "{all:?}");
}

#[test]
fn one_point_alone_is_a_chart() {
    let mut chart = chart();
    chart.points.truncate(1);
    assert_eq!(
        texts(&draw(&chart).unwrap()).iter().filter(|text| **text == chart.points[0].label).count(),
        3
    );
}

#[test]
fn labels_that_two_series_share_are_told_apart_at_the_end_of_their_lines() {
    let mut chart = chart();
    chart.points.truncate(3);
    let others = chart.points.clone().into_iter().map(|p| Point {
        series: "64 spp".to_owned(),
        bake_seconds: 0.3 * p.bake_seconds,
        ..p
    });
    chart.points.extend(others);
    let texts = texts(&draw(&chart).unwrap());
    for (text, count) in [("3 bases", 6), ("4 bases", 0), ("4 bases, 256 spp", 3), ("4 bases, 64 spp", 3)] {
        assert_eq!(texts.iter().filter(|shown| *shown == text).count(), count, "{text}");
    }
}
