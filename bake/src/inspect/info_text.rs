//! The text form of [`super::info`]: facts in two columns, sections as a table.

use super::info::facts::{BundleInfo, ClassInfo, ClipInfo, Details, FileInfo, SectionRow, Totals, ratio};
use super::info::file_bake::FileBake;
use super::sphere_metrics::SphereMetrics;
use relume_formats::counts::one_or;
use relume_formats::kinds::brdf_basis::BasisError;
use relume_formats::kinds::sphere_set::Solid;
use relume_formats::kinds::sphere_shadows::ShadowObject;
use relume_formats::name::plain;
use relume_formats::state::Model;
use serde_json::Value;
use std::collections::BTreeMap;

/// Longer tables show this many rows and the sum of the others.
const MOST_ROWS: usize = 12;
/// Rows shown of a longer table.
const ROWS_SHOWN: usize = 8;

/// The text for one file.
pub(super) fn file(info: &FileInfo) -> String {
    let mut facts = vec![
        ("kind", format!("{} version {}, container version {}", info.kind, info.kind_version, info.container_version)),
        ("bytes", totals(&info.totals)),
    ];
    facts.extend(details(&info.details));
    info.bake.iter().for_each(|bake| facts.extend(of_bake(bake)));
    format!("{}\n{}\n{}", plain(&info.file), lines(&facts), table(&info.sections))
}

/// The text for a bundle: what it is, then every file.
pub(super) fn bundle(info: &BundleInfo) -> String {
    let manifest = &info.manifest;
    let mut facts = vec![
        ("kind", "bundle".to_owned()),
        ("scene", format!("{}, hash {}", manifest.scene, manifest.scene_hash)),
        ("bytes", format!("{} in {} files", totals(&info.totals), info.files.len())),
    ];
    for method in &manifest.methods {
        facts.push(("method", method.name.clone()));
        facts.push(("  settings", settings(&method.settings)));
        facts.push(("  errors", errors(&method.errors)));
        if !method.measured_on.is_empty() {
            facts.push(("  measured", method.measured_on.clone()));
        }
    }
    if !manifest.animations.is_empty() {
        facts.push(("animations", list(manifest.animations.keys().cloned())));
    }
    for (object, set) in &manifest.sphere_sets {
        facts.push(("spheres", object.clone()));
        facts.push(("  settings", settings(&set.settings)));
    }
    let files: Vec<String> = info.files.iter().map(file).collect();
    format!("{}\n{}\n{}", plain(&info.folder), lines(&facts), files.join("\n"))
}

/// What the manifest beside a file says of it.
fn of_bake(bake: &FileBake) -> Vec<(&'static str, String)> {
    match bake {
        FileBake::Stranger { manifest } => {
            let reason = "lists this file with another hash, so the two do not belong together; its settings and errors are left out";
            vec![("manifest", format!("{manifest} {reason}"))]
        }
        FileBake::Listed { manifest, settings: of_method, errors: measured, measured_on, .. } => {
            let mut facts = vec![("manifest", manifest.clone()), ("settings", settings(of_method)), ("errors", errors(measured))];
            facts.extend((!measured_on.is_empty()).then(|| ("measured", measured_on.clone())));
            facts
        }
    }
}

fn settings(settings: &BTreeMap<String, Value>) -> String {
    list(settings.iter().map(|(name, value)| format!("{name} {value}")))
}

fn errors(errors: &BTreeMap<String, f64>) -> String {
    if errors.is_empty() {
        return "none, for nothing that was compared is lit".to_owned();
    }
    list(errors.iter().map(|(name, value)| format!("{name} {value:.6}")))
}

fn totals(totals: &Totals) -> String {
    format!("{} on disk, {} in memory, ratio {:.2}", grouped(totals.bytes_on_disk), grouped(totals.bytes_in_memory), totals.ratio)
}

fn details(details: &Details) -> Vec<(&'static str, String)> {
    match details {
        Details::Scene { name, size, camera, vertices, triangles, objects, materials } => vec![
            ("name", name.clone()),
            ("size", pixels(*size)),
            ("camera", format!("position {:?}, target {:?}, fov {}°", camera.position, camera.target, camera.fov_deg)),
            ("geometry", format!("{}, {}", many(*vertices, "vertex", "vertices"), many(*triangles, "triangle", "triangles"))),
            ("objects", list(objects.iter().cloned())),
            ("varies", list(materials.iter().filter(|m| m.varies).map(|m| m.name.clone()))),
            ("fixed", list(materials.iter().filter(|m| !m.varies).map(|m| m.name.clone()))),
        ],
        Details::Animation { name, duration_s, looping, tracks } => vec![
            ("name", name.clone()),
            ("duration", format!("{duration_s} s{}", if *looping { ", repeated" } else { "" })),
            ("tracks", list(tracks.iter().map(|t| format!("{} ({})", t.leaf, many(t.keys, "key", "keys"))))),
        ],
        Details::BrdfBasis { bases, model, nodes, range: [first, last], shared_diffuse, error_at_samples, error_between } => vec![
            ("model", model.name().to_owned()),
            (
                "bases",
                format!("{bases}, {}", if *shared_diffuse { "lobes use the diffuse one too" } else { "lobes leave the diffuse one alone" }),
            ),
            (parameter(*model), format!("{nodes} nodes from {first} to {last}")),
            ("error", format!("{} at the samples", error(error_at_samples))),
            ("", format!("{} between them", error(error_between))),
        ],
        Details::TransferImages { size, bases, chromaticity, samples, seed, rgb_images, single_channel_images, fragments, classes } => {
            vec![
                ("size", format!("{}, {} a pixel, seed {seed}", pixels(*size), many(*samples as usize, "sample", "samples"))),
                ("bases", bases.to_string()),
                ("light", chromaticity.map_or("of several colours".to_owned(), |c| format!("of one colour, {c:?}"))),
                ("images", format!("{rgb_images} RGB, {single_channel_images} single-channel")),
                ("fragments", format!("{}: {}", grouped(*fragments as u64), list(classes.iter().map(class)))),
            ]
        }
        Details::HaarTable { bitmaps, coefficients } => {
            vec![("table", format!("{coefficients} Haar coefficients of each of {} bitmaps of 4 × 4", grouped(*bitmaps)))]
        }
        Details::Environment { name, size: [width, height], brightest } => {
            vec![("name", name.clone()), ("size", format!("{width} × {height} texels")), ("brightest", format!("{brightest:?} W/(sr·m²)"))]
        }
        Details::Textures { uvs, sizes } => {
            vec![("vertices", grouped(*uvs as u64)), ("textures", list(sizes.iter().map(|[width, height]| format!("{width} × {height}"))))]
        }
        Details::SparseTransfer { rows, terms, face_size, bounces, channels, wide_terms, rays_per_texel, bytes_of_dense_matrix } => vec![
            (
                "rows",
                format!(
                    "{}, {} each, {wide_terms} of them 16-bit",
                    many(*rows as usize, "vertex", "vertices"),
                    many(*terms, "term", "terms")
                ),
            ),
            (
                "light",
                format!(
                    "6 × {face_size} × {face_size} texels, {}, {}, {} a texel",
                    many(*bounces as usize, "bounce", "bounces"),
                    many(*channels, "channel", "channels"),
                    many(*rays_per_texel as usize, "ray", "rays")
                ),
            ),
            ("dense", format!("{} bytes with every coefficient as f32", grouped(*bytes_of_dense_matrix))),
        ],
        Details::SphereShadows { receivers, exact_receivers, terms, second_level, rows, grid_rows, objects } => vec![
            (
                "receivers",
                format!("{}, {} of them with a lobe of their own normal", grouped(*receivers as u64), grouped(*exact_receivers as u64)),
            ),
            ("lobes", format!("{rows}, {grid_rows} of them on the grid of normals")),
            (
                "shown with",
                format!(
                    "{terms} terms of the light and of each lobe, visibility by {}",
                    if *second_level { "two levels" } else { "one level" }
                ),
            ),
            ("objects", list(objects.iter().map(shadow_object))),
        ],
        Details::VisibilityTable { directions, stored_directions, radii, texels, bytes_of_bitmaps } => vec![
            (
                "table",
                format!(
                    "a bitmap of {} texels for each of {} directions and {radii} radii",
                    grouped(*texels as u64),
                    grouped(*directions as u64)
                ),
            ),
            ("stored", format!("{stored_directions} directions, which the symmetries of the cube make all of")),
            ("expanded", format!("{} bytes", grouped(*bytes_of_bitmaps as u64))),
        ],
        Details::SphereSet { metrics, points, iterations_done } => spheres(metrics, *points, *iterations_done),
        Details::Shape { vertices, nodes, joints, morph_targets, clips } => vec![
            (
                "vertices",
                format!(
                    "{}, moved by {} of {} and {}",
                    grouped(*vertices as u64),
                    many(*joints, "joint", "joints"),
                    many(*nodes, "node", "nodes"),
                    many(*morph_targets, "morph target", "morph targets")
                ),
            ),
            ("clips", list(clips.iter().map(clip))),
        ],
    }
}

/// Lengths in parts of the diagonal, for nobody knows what a mesh's units are.
fn spheres(m: &SphereMetrics, points: usize, iterations_done: usize) -> Vec<(&'static str, String)> {
    let percent = |length: f64| format!("{:.4} %", length / f64::from(m.diagonal) * 100.0);
    let solid = match m.solid {
        Solid::Closed => "closed, so its volumes are exact".to_owned(),
        Solid::WindingNumber { cells } => {
            format!("open or meets itself: inside is where it winds around, on a grid of {cells} cells along")
        }
    };
    let coverage =
        if m.tight > 0.0 { format!("up to {} % of the diagonal uncovered", m.tight * 100.0) } else { "complete coverage".to_owned() };
    let [mean, p95, max] = [m.protrusion.mean, m.protrusion.p95, m.protrusion.max].map(percent);
    vec![
        (
            "mesh",
            format!(
                "{}, {}, {}, diagonal {}",
                m.mesh,
                many(m.vertices as usize, "vertex", "vertices"),
                many(m.triangles as usize, "triangle", "triangles"),
                m.diagonal
            ),
        ),
        ("solid", solid),
        ("spheres", format!("{}, which follow {}", grouped(m.n as u64), many(points, "point", "points"))),
        (
            "fit",
            format!("seed {}, {iterations_done} of at most {}, {coverage}", m.seed, many(m.iterations as usize, "iteration", "iterations")),
        ),
        ("E/V(T)", format!("{:.6}, of the volume {}", m.relative_outside_volume, m.volume)),
        ("coverage", format!("{:.4} % of the surface, {:.4} % of the volume", m.coverage_surface * 100.0, m.coverage_volume * 100.0)),
        ("gap", format!("{} of the diagonal at most", percent(m.largest_uncovered_gap))),
        ("protrusion", format!("{mean} of the diagonal in the mean, {p95} at 95 %, {max} at most")),
        ("overlap", format!("{:.4}", m.overlap)),
    ]
}

/// What the sharpness of a lobe is called.
fn parameter(model: Model) -> &'static str {
    match model {
        Model::BlinnPhong => "exponent",
        Model::Ggx => "roughness",
    }
}

fn clip(clip: &ClipInfo) -> String {
    format!("{} ({} s, {}, {})", clip.name, clip.duration_s, many(clip.tracks, "track", "tracks"), many(clip.keys, "key", "keys"))
}

fn shadow_object(object: &ShadowObject) -> String {
    let (casts, moves) =
        (if object.sphere_set { " casts shadows" } else { " only receives" }, if object.deforms { " and deforms" } else { "" });
    format!("{} ({},{casts}{moves})", object.name, many(object.vertices as usize, "vertex", "vertices"))
}

fn class(class: &ClassInfo) -> String {
    format!("{} {}", class.material.as_deref().unwrap_or("(fixed)"), grouped(class.fragments as u64))
}

fn error(error: &BasisError) -> String {
    format!("{:.4} % mean, {:.4} % worst at {}", error.mean * 100.0, error.worst * 100.0, error.worst_at)
}

/// "1,839 vertices", "1 vertex".
fn many(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count as u64), one_or(count, one, many))
}

fn pixels(size: [u32; 2]) -> String {
    format!("{} × {} pixels", size[0], size[1])
}

fn list(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.collect();
    if items.is_empty() { "none".to_owned() } else { items.join(", ") }
}

/// A line a fact, whatever the names in it do elsewhere.
fn lines(facts: &[(&str, String)]) -> String {
    facts.iter().map(|(name, value)| format!("  {name:<11} {}\n", plain(value))).collect()
}

/// Names to the left, numbers to the right.
fn table(sections: &[SectionRow]) -> String {
    let shown = if sections.len() > MOST_ROWS { ROWS_SHOWN } else { sections.len() };
    let (first, others) = sections.split_at(shown);
    let mut rows = vec![["section", "element", "shape", "codec", "stored", "raw", "ratio"].map(str::to_owned)];
    rows.extend(first.iter().map(|s| {
        [
            plain(&s.name).into_owned(),
            s.element.to_owned(),
            shape(&s.shape),
            s.codec.to_owned(),
            grouped(s.stored_bytes),
            grouped(s.raw_bytes),
            format!("{:.2}", s.ratio),
        ]
    }));
    if !others.is_empty() {
        rows.push(sum(format!("… {} more", others.len()), others));
    }
    rows.push(sum("total".to_owned(), sections));
    let widths: [usize; 7] = std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    rows.iter().map(|row| aligned(row, &widths)).collect()
}

fn sum(name: String, sections: &[SectionRow]) -> [String; 7] {
    let stored = sections.iter().map(|s| s.stored_bytes).sum();
    let raw = sections.iter().map(|s| s.raw_bytes).sum();
    let blank = String::new;
    [name, blank(), blank(), blank(), grouped(stored), grouped(raw), format!("{:.2}", ratio(raw, stored))]
}

fn aligned(row: &[String; 7], widths: &[usize; 7]) -> String {
    let mut line = String::from(" ");
    for (column, (cell, &width)) in row.iter().zip(widths).enumerate() {
        line += &if column < 4 { format!(" {cell:<width$} ") } else { format!(" {cell:>width$} ") };
    }
    line.trim_end().to_owned() + "\n"
}

fn shape(shape: &[u64]) -> String {
    shape.iter().map(u64::to_string).collect::<Vec<_>>().join(" × ")
}

/// 1234567 as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_by_three() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (65_536, "65,536"), (1_234_567, "1,234,567")];
        cases.iter().for_each(|(number, text)| assert_eq!(grouped(*number), *text));
    }
}
