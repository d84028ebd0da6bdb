//! The page of the gallery in Markdown, made from the figures alone.

use crate::digits::{bytes, milliseconds, percent, rounded, seconds};
use crate::figures::{Chart, PICTURE, Point, SVG};

const HEAD: &str = "\
# Gallery

A chart of speed against accuracy, a picture beside its reference and the figures for each scene. `make gallery` measures and writes all of this anew and says what changed.

Errors are against path-traced references, over random states of what the scene varies. Relative L2 is the length of the difference over that of the reference, lights and background left
out; FLIP is the mean of what a person sees of it, 0 to 1. Each is the median over the states, with the worst in parentheses. Frame times are medians, with 95th percentiles in parentheses.
";

/// The page that shows `charts`.
pub fn page(charts: &[Chart]) -> String {
    charts.iter().fold(HEAD.to_owned(), |page, chart| page + "\n" + &section(chart))
}

/// What of a scene stands on the page.
fn section(chart: &Chart) -> String {
    let Chart { scene, size, states, reference_samples, picture, adapter, machine, date, program, .. } =
        chart;
    let (folder, factor) = (scene.replace(' ', "%20"), rounded(f64::from(picture.factor), 3));
    format!(
        "## {scene}\n\n\
         {}\n\n\
         ![{scene}: ours, the reference, the difference]({folder}/{PICTURE})\n\n\
         *From the left: {}; the reference; the difference{}. A row is a state.*\n\n\
         ![{scene}: error against frame time, size and baking]({folder}/{SVG})\n\n\
         {}\n\
         {}×{} pixels, {states} states, references of {reference_samples} samples a pixel; {adapter}; {machine}; {date}; {program}.\n",
        line(chart),
        picture.point,
        if factor > 1.0 { format!(", times {factor}") } else { String::new() },
        table(chart),
        size[0],
        size[1],
    )
}

fn error(point: &Point) -> f64 {
    point.errors.relative_l2.median
}

/// The point with the least `of`, the first of equals.
fn least<'a>(points: impl Iterator<Item = &'a Point>, of: impl Fn(&Point) -> f64) -> Option<&'a Point> {
    points.min_by(|a, b| of(a).total_cmp(&of(b)))
}

/// What the chart shows, in a line.
fn line(chart: &Chart) -> String {
    let best = |of: fn(&Point) -> f64| least(chart.points.iter(), of);
    let superlatives = [
        ("most exact", best(error)),
        ("fastest", best(|p| p.frame.median_ms)),
        ("smallest", best(|p| p.bytes_on_disk as f64)),
    ];
    let mut said: Vec<(String, &Point)> = Vec::new();
    for (word, point) in superlatives.into_iter().filter_map(|(word, point)| Some((word, point?))) {
        match said.iter_mut().find(|(_, other)| other.name() == point.name()) {
            Some((words, _)) => *words = format!("{words} and {word}"),
            None => said.push((word.to_owned(), point)),
        }
    }
    let clause = |(words, p): &(String, &Point)| {
        let cost =
            format!("{} a frame and {}", milliseconds(p.frame.median_ms), bytes(p.bytes_on_disk as f64));
        format!("{words} is {}: {} at {cost}", p.name(), percent(error(p)))
    };
    let mut text = said.iter().map(clause).collect::<Vec<_>>().join("; ");
    if let Some(first) = text.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    let noise = chart.noise.relative_l2.median;
    text + &format!(
        ". The references themselves are known to {}{}.",
        percent(noise),
        seen_through(best(error), noise)
    )
}

/// A word of caution where noise is a good part of the least error.
fn seen_through(best: Option<&Point>, noise: f64) -> &'static str {
    if best.is_some_and(|p| error(p) < 2.0 * noise) {
        ", which is a good part of the least error here"
    } else {
        ""
    }
}

/// Of each method the most exact and the cheapest point, and the noise.
fn table(chart: &Chart) -> String {
    let mut text =
        "| method | point | relative L2 | FLIP | frame | on disk | bake |\n|---|---|---|---|---|---|---|\n"
            .to_owned();
    let mut methods: Vec<&str> = Vec::new();
    chart.points.iter().for_each(|p| {
        if !methods.contains(&p.method.as_str()) {
            methods.push(&p.method)
        }
    });
    for method in methods {
        let own = || chart.points.iter().filter(|p| p.method == method);
        let (exact, cheap) = (least(own(), error), least(own(), |p| p.frame.median_ms));
        let same = exact.zip(cheap).is_some_and(|(a, b)| a.name() == b.name());
        exact
            .into_iter()
            .for_each(|p| text += &row(p, if same { "most exact and fastest" } else { "most exact" }));
        cheap.filter(|_| !same).into_iter().for_each(|p| text += &row(p, "fastest"));
    }
    let noise = &chart.noise;
    text + &format!(
        "| *reference* | its own noise | {} | {} | | | {} |\n",
        both(noise.relative_l2, percent),
        both(noise.flip, three),
        seconds(chart.reference_seconds)
    )
}

fn row(p: &Point, which: &str) -> String {
    let frame = format!("{} ({})", milliseconds(p.frame.median_ms), milliseconds(p.frame.p95_ms));
    let (l2, flip) = (both(p.errors.relative_l2, percent), both(p.errors.flip, three));
    format!(
        "| {} | {}, {}: {which} | {l2} | {flip} | {frame} | {} | {} |\n",
        p.method,
        p.series,
        p.label,
        bytes(p.bytes_on_disk as f64),
        seconds(p.bake_seconds)
    )
}

fn three(value: f64) -> String {
    rounded(value, 3).to_string()
}

fn both(over: crate::figures::OverStates, told: fn(f64) -> String) -> String {
    format!("{} ({})", told(over.median), told(over.worst))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_chart::chart;

    #[test]
    fn the_extremes_of_each_method_are_in_the_table_and_its_rows_are_whole() {
        let table = table(&chart());
        let rows: Vec<&str> = table.lines().collect();
        assert_eq!(rows.len(), 2 + 2 * 3 + 1);
        assert!(rows.iter().all(|row| row.matches('|').count() == 8), "{table}");
        for (row, start) in rows[2..].iter().zip([
            "| transfer-images | 8 bases, 1024 samples: most exact |",
            "| transfer-images | 256 spp, 2 bases: fastest |",
            "| sparse-transfer | 8 bits, 1024 terms: most exact |",
            "| sparse-transfer | 8 bits, 16 terms: fastest |",
            "| sphere-shadows | level II, 128 spheres, II: most exact |",
            "| sphere-shadows | level I, 32 spheres, I: fastest |",
            "| *reference* | its own noise | 0.11 % (0.275 %) | 0.00044 (0.0011) |",
        ]) {
            assert!(row.starts_with(start), "{row}");
        }
    }

    #[test]
    fn a_line_says_which_point_is_best_at_what() {
        let expected = "Most exact is transfer-images, 8 bases, 1024 samples: 0.214 % at 1.5 ms a frame and 4.46 MB; fastest is transfer-images, 256 spp, 2 bases: \
                        5.16 % at 1.12 ms a frame and 1.2 MB; smallest is sparse-transfer, 8 bits, 16 terms: 5.4 % at 2.18 ms a frame and 144 kB. \
                        The references themselves are known to 0.11 %, which is a good part of the least error here.";
        assert_eq!(line(&chart()), expected);
        let mut alone = chart();
        alone.points.truncate(1);
        assert!(
            line(&alone).starts_with(
                "Most exact and fastest and smallest is transfer-images, 256 spp, 2 bases: 5.16 % at"
            ),
            "{}",
            line(&alone)
        );
        assert_eq!(table(&alone).lines().count(), 2 + 1 + 1);
    }

    #[test]
    fn the_page_shows_chart_and_picture_of_every_scene() {
        let charts = ["one scene", "two"].map(|scene| Chart { scene: scene.to_owned(), ..chart() });
        let page = page(&charts);
        for link in
            ["(one%20scene/picture.png)", "(one%20scene/chart.svg)", "(two/picture.png)", "(two/chart.svg)"]
        {
            assert_eq!(page.matches(link).count(), 1, "{link}");
        }
        assert!(page.contains(
            "From the left: transfer-images, 256 spp, 6 bases; the reference; the difference, times 20."
        ));
    }
}
