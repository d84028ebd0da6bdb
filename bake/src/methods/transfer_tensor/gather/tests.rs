use super::super::lobe_table::tests::{exact, points};
use super::super::tests::{CORNER, Whole, scene};
use super::*;
use crate::trace::sampler::PixelSampler;
use relume_formats::state::Rgb;

/// Light after one reflection as harmonics, [channels, harmonics].
type Light = [[f64; sh::COUNT]; 3];

/// A light that no texel knows of its neighbour.
fn light(texel: usize) -> Rgb {
    let sample = PixelSampler::new(11, texel as u32).sample(0);
    [0, 1, 2].map(|c| sample.pair(c)[0].powi(3))
}

/// By the tensor, whose lobes are a table's.
fn by_table(whole: &Whole, weights: &[Rgb], vertex: usize, rays: u32) -> Light {
    let gather = whole.gather(rays);
    let mut tensor = vec![0.0; gather.shape().iter().product()];
    gather.tensor(vertex, &mut tensor);
    let mut found = [[0.0; sh::COUNT]; 3];
    for (index, values) in tensor.chunks_exact(sh::COUNT).enumerate() {
        let (column, texel) = (index / gather.texels, index % gather.texels);
        for (c, found) in found.iter_mut().enumerate() {
            let by = f64::from(weights[column][c] * light(texel)[c]);
            found.iter_mut().zip(values).for_each(|(sum, value)| *sum += by * f64::from(*value));
        }
    }
    found
}

/// By functions over 64 points of every texel.
fn by_points(whole: &Whole, weights: &[Rgb], vertex: usize, rays: u32) -> Light {
    let points = points();
    let around = Around::new(&whole.scene, (&whole.world, &whole.receivers), 1);
    let mut found = [[0.0; sh::COUNT]; 3];
    for ray in around.met(vertex, rays, Spread::Evenly) {
        let class = whole.classes.of(ray.material);
        let terms = class.terms(ray.meeting.albedo);
        let mut reflected = [0.0f64; 3];
        for (corner, share) in around.corners(&ray.meeting) {
            let normal = whole.receivers[corner].normal;
            for (texel, arriving) in whole.arriving.at(corner) {
                let texel = usize::from(*texel);
                let mut columns = terms.even;
                if let Some(functions) = class.functions.map(|at| &whole.classes.functions[at]) {
                    let (means, _) = exact(functions, &points[texel], normal, -ray.direction);
                    terms.shares().iter().for_each(|s| columns[s.column] += s.of * means[s.function]);
                }
                for (column, value) in columns.iter().enumerate().take(class.columns) {
                    let by = weights[class.first + column];
                    (0..3).for_each(|c| {
                        reflected[c] += f64::from(share * arriving * by[c] * light(texel)[c] * value);
                    });
                }
            }
        }
        let y = sh::evaluate(Vec3::from(ray.direction)).map(|y| f64::from(y * TAU / rays as f32));
        (0..3).for_each(|c| found[c].iter_mut().zip(y).for_each(|(sum, y)| *sum += y * reflected[c]));
    }
    found
}

/// Tables in place of means over 64 points of every texel, for materials of all models, editable and fixed, in
/// a corner of two glossy planes: errors of lobes, some per cent from texel to texel, have any sign and many
/// rays to cancel in. That light changes from texel to texel at random is the worst for it.
#[test]
fn tables_lose_little_of_the_light_of_exact_means() {
    let materials = [
        ["", ""],
        ["brdf = 'ggx'\nbase_color = [0.7, 0.5, 0.2]\nmetallic = 0.8\nroughness = 0.4", ""],
        [
            "brdf = 'cook-torrance'\nkd = [0.2, 0.1, 0.1]\nks = [0.8, 0.6, 0.5]\nfresnel = 0.6\nroughness = 0.15",
            "brdf = 'ggx'\nbase_color = [0.9, 0.7, 0.2]\nmetallic = 0.5\nroughness = 0.2",
        ],
    ];
    for [wall, floor] in materials {
        let mut text = CORNER.to_owned();
        for (name, keys) in
            [("wall", wall), ("floor", floor)].into_iter().filter(|(_, keys)| !keys.is_empty())
        {
            let start = text.find(&format!("[materials.{name}]")).unwrap();
            let end = start + text[start..].find("\n    [").unwrap();
            text.replace_range(start..end, &format!("[materials.{name}]\n{keys}"));
        }
        let whole = Whole::new(scene(&text));
        let own: Vec<_> = whole.scene.vary.materials.iter().map(|m| whole.scene.materials[*m].brdf).collect();
        let weights = whole.classes.weights(&own).unwrap();
        let of_object = whole.scene.objects[0].mesh.positions.len();
        let (mut off, mut size) = (0.0, 0.0);
        for vertex in [210, 60, of_object + 220, of_object + 45] {
            let [found, exact] = [by_table, by_points].map(|by| by(&whole, &weights, vertex, 256));
            for (found, exact) in found.as_flattened().iter().zip(exact.as_flattened()) {
                off += (found - exact).powi(2);
                size += exact * exact;
            }
        }
        let error = (off / size).sqrt();
        println!("{:?}: {error:.5}", own[0].model());
        assert!(size > 0.01 && error < 0.015, "{own:?}: {error}");
    }
}
