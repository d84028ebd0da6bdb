//! Environment maps.

use super::out::Out;
use super::{Described, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::Environment;
use relume_formats::state::Rgb;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::Environment, describe, export };

#[derive(Serialize)]
struct Details {
    name: String,
    /// Texels, width and height.
    size: [u32; 2],
    brightest: Rgb,
}

fn describe(path: &Path) -> Result<Described> {
    let Environment { name, map } = Environment::read_file(path)?;
    let brightest = map.texels.iter().fold([0.0f32; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
    let facts = vec![
        ("name", name.clone()),
        ("size", format!("{} × {} texels", map.width, map.height)),
        ("brightest", format!("{brightest:?} W/(sr·m²)")),
    ];
    Ok(Described { facts, details: Box::new(Details { name, size: [map.width, map.height], brightest }) })
}

/// `environment.exr`, `environment.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let Environment { name, map } = Environment::read_file(path)?;
    let plane = |channel: usize| -> Vec<f32> { map.texels.iter().map(|texel| texel[channel]).collect() };
    let (red, green, blue) = (plane(0), plane(1), plane(2));
    out.exr("environment.exr", [map.width, map.height], &[("R", &red), ("G", &green), ("B", &blue)])?;
    out.json(
        "environment.json",
        &json!({
            "name": name,
            "mapping": "equirectangular: u = 0.5 + atan2(x, -z)/2pi, v = acos(y)/pi; radiance in W/(sr m^2)",
            "width": map.width,
            "height": map.height,
        }),
    )
}
