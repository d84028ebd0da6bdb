//! The scene file, with comments for somebody who has never seen one.

use super::framing::FOV_DEG;
use super::model::WORN;
use super::quoting::{Digits, key, quoted};
use super::{Look, Starter};
use crate::scene::Material;
use relume_formats::counts::counted;
use relume_formats::name::plain;
use relume_formats::state::{Brdf, Rgb};
use std::fmt::Write as _;

/// Most materials that vary: each adds some fifty images to a bundle, which a frame sums.
const MOST_VARYING: usize = 6;
/// A material with a texture varies only if it is no metal. Where this much of it is, or less, it is shown as
/// none.
const HARDLY_METALLIC: f32 = 0.5;
/// The material that glTF gives to what has none: a rough metal, which nobody meant.
const UNMEANT: &str = "material-default";
/// Longest list of clips that anybody would read.
const MOST_CLIPS: usize = 20;

/// How a material of the model may vary.
enum Varies {
    AsItIs,
    /// As what is no metal.
    AsNoMetal,
    /// Not at all, and why.
    Not(&'static str),
}

/// The scene file.
pub(super) fn of(starter: &Starter, look: Option<&Look>) -> String {
    let writer = Writer { starter, look, ground: ground_name(&starter.model.materials) };
    [
        writer.head(),
        writer.vary(),
        writer.film(),
        writer.model(),
        writer.ground(),
        writer.light(),
        writer.materials(),
    ]
    .join("\n")
}

/// The key and value that name a model.
pub(super) fn file_line(path: &str) -> String {
    format!("file = {}", quoted(path))
}

/// A name that no material of the model has.
fn ground_name(materials: &[Material]) -> String {
    let is_free = |name: &String| materials.iter().all(|material| material.name != *name);
    let mut names =
        std::iter::once("ground".to_owned()).chain((2..).map(|number| format!("ground-{number}")));
    names.find(is_free).unwrap_or_default()
}

struct Writer<'a> {
    starter: &'a Starter,
    look: Option<&'a Look>,
    /// Name of the ground's material.
    ground: String,
}

impl Writer<'_> {
    fn digits(&self) -> Digits {
        Digits::beside(self.starter.placing.radius)
    }

    fn head(&self) -> String {
        let name = self.starter.model_path.rsplit('/').next().unwrap_or_default();
        format!(
            "# A first scene for {}, written by `bake new`. All of it may be changed; what follows a # is a comment.\n\
             # docs/reference/scene.md tells what there is besides.\n",
            plain(name)
        )
    }

    /// The material as a scene has it, and how it may vary.
    fn variation(material: &Material) -> Varies {
        match material.brdf {
            Brdf::Ggx(ggx) if material.texture.is_some() && ggx.metallic > HARDLY_METALLIC => {
                Varies::Not("a metal with a texture; to let it vary, set its metallic to 0 below")
            }
            Brdf::Ggx(ggx) if material.texture.is_some() && ggx.metallic > 0.0 => Varies::AsNoMetal,
            _ => Varies::AsItIs,
        }
    }

    /// Materials of the model that vary, the one that is seen most first.
    fn varying(&self) -> Vec<&Material> {
        let named =
            |name: &String| self.starter.model.materials.iter().find(|material| material.name == *name);
        let may = |material: &&Material| !matches!(Self::variation(material), Varies::Not(_));
        self.seen().iter().filter_map(|(name, _)| named(name)).filter(may).take(MOST_VARYING).collect()
    }

    fn seen(&self) -> &[(String, u32)] {
        self.look.map(|look| look.seen.as_slice()).unwrap_or_default()
    }

    /// Which part a material is of what is seen of the model, percent.
    fn share(&self, material: &Material) -> f64 {
        let pixels = |of: &Material| {
            self.seen().iter().find(|(seen, _)| *seen == of.name).map_or(0, |(_, pixels)| *pixels)
        };
        let all: u32 = self.starter.model.materials.iter().map(pixels).sum();
        100.0 * f64::from(pixels(material)) / f64::from(all.max(1))
    }

    fn varies(&self, material: &Material) -> bool {
        self.varying().iter().any(|varying| varying.name == material.name)
    }

    fn vary(&self) -> String {
        let mut text = "\
# What may change while playing; all else is baked in. A bundle serves one of two:
# A. materials, with highlights, reflections and any lamps, seen from this camera;
# B. light and view, without highlights, under maps alone. For B, follow the lines that begin with # B.
[vary]
materials = [
"
        .to_owned();
        for material in self.varying() {
            let share = self.share(material);
            let _ = writeln!(
                text,
                "    {},  # {share:.0} % of what is seen of the model",
                quoted(&material.name)
            );
        }
        let mut fixed: Vec<&Material> =
            self.starter.model.materials.iter().filter(|material| !self.varies(material)).collect();
        fixed.sort_by(|a, b| self.share(b).total_cmp(&self.share(a)));
        for material in fixed {
            let reason = match Self::variation(material) {
                Varies::Not(reason) => reason,
                _ if self.share(material) == 0.0 => "not in view",
                _ => "less is seen of it than of the others; each makes the bundle larger",
            };
            let _ = writeln!(text, "    # {},  # {reason}", quoted(&material.name));
        }
        // Without anything that varies there is nothing to bake.
        let sign = if self.varying().is_empty() && self.look.is_some() { "" } else { "# " };
        let _ = writeln!(text, "    {sign}{},  # what the model stands on", quoted(&self.ground));
        text += "]\n# B, which keeps materials as they are: take the list above away, and write\n# B: light = true\n# B: view = true\n";
        if !self.starter.model.clips.is_empty() {
            let clips: Vec<String> =
                self.starter.model.clips.iter().take(MOST_CLIPS).map(|clip| quoted(clip)).collect();
            let _ = writeln!(
                text,
                "# The model moves: {}. For that, docs/guide/scenes.md, \"Shapes vary\", goes on from B.",
                clips.join(", ")
            );
        }
        text
    }

    fn film(&self) -> String {
        let (framing, digits) = (&self.starter.framing, self.digits());
        format!(
            "[render]\n\
             size = [512, 512]  # width and height, pixels\n\
             reflections = 2  # 1 is direct light alone, 2 adds what surfaces throw on each other\n\
             # B bakes sooner with 1, and shows finer shadows.\n\n\
             [camera]\n\
             position = {}  # metres; +Y is up\n\
             target = {}\n\
             fov_deg = {FOV_DEG:?}  # vertical\n\
             exposure_ev = {:?}  # each step of 1 doubles the brightness\n\n\
             [error]\n\
             max = 0.05  # 0.02 looks exact and makes larger bundles\n",
            digits.list(framing.position),
            digits.list(framing.target),
            self.look.map_or(0.0, |look| look.exposure_ev)
        )
    }

    fn model(&self) -> String {
        let (model, placing, digits) = (&self.starter.model, &self.starter.placing, self.digits());
        let [width, height, depth] = placing.units.map(short);
        let [w, h, d] = placing.units.map(|units| short(units * placing.scale));
        let mut text = format!(
            "# {width} wide, {height} high and {depth} deep in its own units, taken for {}: {w} m × {h} m × {d} m.\n\
             # If its unit is another, say how many metres that is: `bake new … --scale 0.001` for millimetres; camera and ground follow.\n\
             [[object]]\n\
             name = \"model\"\n\
             {}  # read where it is, so that what its program exports again is baked again\n",
            placing.unit,
            file_line(&self.starter.model_path)
        );
        if !model.is_gltf {
            let _ = writeln!(text, "material = {}", quoted(WORN));
        } else if model.lamps > 0 || model.glows {
            let lamps = counted(model.lamps, "lamp", "lamps");
            let _ =
                writeln!(text, "# B: lights = false  # leaves out its {lamps} and what its surfaces emit");
        }
        let _ = writeln!(
            text,
            "[object.transform]\n\
             scale = {}\n\
             translation = {}  # onto the ground, at the origin\n\
             # If it lies on its back, its program has +Z up. Then instead of the last line:\n\
             # rotation_deg = [-90.0, 0.0, 0.0]\n\
             # translation = {}",
            float(placing.scale),
            digits.list(placing.translation),
            digits.list(placing.translation_if_z_up)
        );
        text
    }

    fn ground(&self) -> String {
        let (framing, digits) = (&self.starter.framing, self.digits());
        let y = digits.number(framing.ground_y);
        let transform = |side: f64| {
            format!("transform = {{ scale = {}, translation = [0.0, {y}, 0.0] }}", digits.number(side))
        };
        format!(
            "# All that the camera sees beside the model. Leave it out if the model brings its own.\n\
             [[object]]\n\
             name = \"ground\"\n\
             shape = \"quad\"\n\
             material = {}\n\
             {}\n\
             # B, whose shadows are as fine as this grid, instead of the last line:\n\
             # segments = 96\n\
             # {}\n",
            quoted(&self.ground),
            transform(framing.ground),
            transform(framing.small_ground)
        )
    }

    fn light(&self) -> String {
        let others =
            "# B: others = [\"clear-sky\", \"white\"]  # further maps to choose from while playing\n";
        match self.starter.model.lamps {
            0 => format!(
                "# Light from all sides: \"lamps\" is a studio, \"clear-sky\" has a sun, \"white\" is even; or a .hdr or .exr of yours.\n\
                 [environment]\n\
                 file = \"lamps\"\n\
                 rotation_deg = 0.0  # about the vertical axis\n\
                 gain = [{LAMPS_GAIN:?}, {LAMPS_GAIN:?}, {LAMPS_GAIN:?}]\n\
                 {others}"
            ),
            lamps => format!(
                "# Besides the {} of the model's file, a dim even sky; `file` names a map: \"lamps\", \"clear-sky\", or a .hdr or .exr of yours.\n\
                 [environment]\n\
                 # B, where the map is all the light: instead of the next line\n\
                 # file = \"lamps\"\n\
                 # gain = [{LAMPS_GAIN:?}, {LAMPS_GAIN:?}, {LAMPS_GAIN:?}]\n\
                 gain = [0.3, 0.3, 0.3]\n\
                 {others}",
                counted(lamps, "lamp", "lamps")
            ),
        }
    }

    fn materials(&self) -> String {
        let mut text = format!(
            "[materials.{}]\nbrdf = \"ggx\"\nbase_color = [0.5, 0.5, 0.5]\nmetallic = 0.0\nroughness = 0.8\n",
            key(&self.ground)
        );
        if !self.starter.model.is_gltf {
            let of = "the file brings no colours that are read";
            let _ = write!(
                text,
                "\n[materials.{WORN}]  # {of}\nbrdf = \"ggx\"\nbase_color = [0.6, 0.6, 0.6]\nmetallic = 0.0\nroughness = 0.5\n"
            );
            return text;
        }
        text += "\n# The model's materials are its file's. To change one, remove the # before its lines.\n";
        for material in &self.starter.model.materials {
            text += &self.material(material);
        }
        text
    }

    /// What there is to change of a material of the file, or what had to be changed.
    fn material(&self, material: &Material) -> String {
        let Brdf::Ggx(ggx) = material.brdf else { return String::new() };
        let name = key(&material.name);
        if material.name == UNMEANT && material.texture.is_none() {
            return format!(
                "\n[materials.{name}]  # what the file gives no material; by glTF it would be a rough metal\n\
                 base_color = [0.6, 0.6, 0.6]\nmetallic = 0.0\nroughness = 0.5\n"
            );
        }
        let times = if material.texture.is_some() { "  # times its texture" } else { "" };
        let no_metal = matches!(Self::variation(material), Varies::AsNoMetal) && self.varies(material);
        let (sign, metallic) = if no_metal { ("", 0.0) } else { ("# ", ggx.metallic) };
        let why = if no_metal {
            format!("  # {:?} in the file; what has a texture and varies is no metal", ggx.metallic)
        } else {
            String::new()
        };
        format!(
            "\n{sign}[materials.{name}]\n# base_color = {}{times}\n{sign}metallic = {metallic:?}{why}\n# roughness = {:?}\n",
            colour(ggx.base_color),
            ggx.roughness
        )
    }
}

/// With this gain the studio shows grey ground in the middle of the display's range.
const LAMPS_GAIN: f64 = 0.6;

fn colour([r, g, b]: Rgb) -> String {
    format!("[{r:?}, {g:?}, {b:?}]")
}

/// A length in three digits, for a reader.
fn short(x: f64) -> String {
    let digits = (2.0 - x.abs().max(1e-12).log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number that may be of any size, as a TOML float.
fn float(x: f64) -> String {
    format!("{x:?}")
}
