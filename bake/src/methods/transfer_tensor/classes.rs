//! What light is reflected by: basis functions of editable materials, each by itself, and all fixed materials
//! together.

use super::BASES;
use super::functions::{Functions, Terms};
use crate::brdf::basis;
use glam::Vec3A;
use ndarray_linalg::error::LinalgError;
use relume_formats::kinds::BrdfBasis;
use relume_formats::state::{Brdf, Model, Rgb};
use relume_scenes::Scene;

/// A column of the tensor of a vertex: light that something reflected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Position of the material among those that vary, or their number for all fixed ones.
    pub class: usize,
    /// The basis function; 0 for fixed materials.
    pub basis: usize,
    /// The channel that this is alone for, if what reflects has a colour of its own; else it is for all
    /// three.
    pub channel: Option<usize>,
}

/// How a material reflects, and where among the columns what it reflects is.
#[derive(Debug, Clone)]
pub struct Class {
    /// The first of its columns.
    pub first: usize,
    /// How many there are.
    pub columns: usize,
    /// Position in [`Classes::functions`] of what of it changes with directions, if anything does.
    pub functions: Option<usize>,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    /// Basis functions, the diffuse one even or not, and coloured by a texture or not.
    Varying {
        even: bool,
        textured: bool,
    },
    Fixed(Brdf),
}

/// The columns of a scene.
pub struct Classes {
    /// Those of each editable material: [diffuse, the other functions of its basis], then those of the fixed
    /// ones, red, green and blue, if any object wears one. A diffuse function that a texture colours has
    /// three columns.
    pub columns: Vec<Column>,
    /// One for each model of the materials that vary.
    pub bases: Vec<BrdfBasis>,
    /// All there are, once each.
    pub functions: Vec<Functions>,
    /// By material.
    of_material: Vec<Class>,
}

impl Classes {
    /// For the materials of `scene`: bases of [`BASES`] functions where they vary.
    ///
    /// # Errors
    /// If LAPACK fails.
    pub fn new(scene: &Scene) -> Result<Self, LinalgError> {
        let bases = bases_for(scene)?;
        let mut classes = Self { columns: Vec::new(), bases, functions: Vec::new(), of_material: Vec::new() };
        let varying = &scene.vary.materials;
        let of_varying: Vec<Class> = varying
            .iter()
            .enumerate()
            .map(|(class, material)| classes.add_varying(class, &scene.materials[*material]))
            .collect();
        let first = classes.columns.len();
        for (index, material) in scene.materials.iter().enumerate() {
            let class = match varying.iter().position(|m| *m == index) {
                Some(position) => of_varying[position].clone(),
                None => classes.fixed(first, &material.brdf),
            };
            classes.of_material.push(class);
        }
        let is_fixed = |class: &Class| matches!(class.kind, Kind::Fixed(_));
        if scene.objects.iter().any(|object| is_fixed(&classes.of_material[object.material])) {
            let class = varying.len();
            classes.columns.extend((0..3).map(|c| Column { class, basis: 0, channel: Some(c) }));
        }
        Ok(classes)
    }

    fn add_varying(&mut self, class: usize, material: &relume_scenes::Material) -> Class {
        let textured = material.texture.is_some();
        let first = self.columns.len();
        let channels: &[Option<usize>] = if textured { &[Some(0), Some(1), Some(2)] } else { &[None] };
        self.columns.extend(channels.iter().map(|channel| Column { class, basis: 0, channel: *channel }));
        let model = material.brdf.model();
        let even = Functions::is_diffuse_even(model);
        let functions = self.bases.iter().find(|basis| basis.functions.model() == model).map(|basis| {
            self.columns.extend((1..basis.bases()).map(|basis| Column { class, basis, channel: None }));
            Functions::of_basis(basis)
        });
        let functions = functions.map(|functions| self.position_of(functions));
        let kind = Kind::Varying { even, textured };
        Class { first, columns: self.columns.len() - first, functions, kind }
    }

    fn fixed(&mut self, first: usize, brdf: &Brdf) -> Class {
        let functions = Functions::of_fixed(brdf).map(|functions| self.position_of(functions));
        Class { first, columns: 3, functions, kind: Kind::Fixed(*brdf) }
    }

    fn position_of(&mut self, functions: Functions) -> usize {
        self.functions.iter().position(|known| *known == functions).unwrap_or_else(|| {
            self.functions.push(functions);
            self.functions.len() - 1
        })
    }

    /// How a material of the scene reflects.
    pub fn of(&self, material: u32) -> &Class {
        &self.of_material[material as usize]
    }

    /// What each column counts for in each channel if the varying materials are `materials`, in the order of
    /// `vary`; `None` if one is of another model than the scene has there.
    pub fn weights(&self, materials: &[Brdf]) -> Option<Vec<Rgb>> {
        let of = |material| self.bases.iter().find_map(|basis| basis.coefficients_of(material));
        let coefficients: Vec<Vec<Rgb>> = materials.iter().map(of).collect::<Option<_>>()?;
        let weight = |column: &Column| {
            let all = coefficients.get(column.class).map_or([1.0; 3], |of_class| of_class[column.basis]);
            std::array::from_fn(|c| if column.channel.is_none_or(|only| only == c) { all[c] } else { 0.0 })
        };
        Some(self.columns.iter().map(weight).collect())
    }

    /// The columns that light of two reflections has, [that of the one nearer the light, that of the later],
    /// the first outside: all that some channel passes through both of.
    pub fn pairs(&self) -> Vec<[usize; 2]> {
        let meet = |a: &Column, b: &Column| match (a.channel, b.channel) {
            (Some(a), Some(b)) => a == b,
            _ => true,
        };
        let all = |first: usize| (0..self.columns.len()).map(move |second| [first, second]);
        let pairs = (0..self.columns.len()).flat_map(all);
        pairs.filter(|[a, b]| meet(&self.columns[*a], &self.columns[*b])).collect()
    }
}

impl Class {
    /// How its columns are made of functions where a texture has `albedo`.
    pub fn terms(&self, albedo: Vec3A) -> Terms {
        match &self.kind {
            Kind::Varying { even, textured } => {
                Terms::varying(self.columns, *even, textured.then_some(albedo))
            }
            Kind::Fixed(brdf) => Terms::fixed(brdf, albedo),
        }
    }
}

/// What a pair of columns counts for in each channel, by the weights of its columns.
pub fn pair_weight(pair: [usize; 2], weights: &[Rgb]) -> Rgb {
    let [a, b] = pair.map(|column| weights[column]);
    std::array::from_fn(|c| a[c] * b[c])
}

/// A basis for each model among the materials of `scene` that vary. The diffuse function carries the texture
/// of textured ones, so highlights may not use it then.
fn bases_for(scene: &Scene) -> Result<Vec<BrdfBasis>, LinalgError> {
    let varying = || scene.vary.materials.iter().map(|index| &scene.materials[*index]);
    let mut bases = Vec::new();
    for model in [Model::BlinnPhong, Model::Ggx, Model::CookTorrance] {
        let mut of_model = varying().filter(|material| material.brdf.model() == model).peekable();
        if of_model.peek().is_some() {
            let textured = of_model.any(|material| material.texture.is_some());
            bases.push(basis::build(model, BASES, !textured)?);
        }
    }
    Ok(bases)
}
