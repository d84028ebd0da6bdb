//! What light is reflected by: basis functions of editable materials, each by itself, and all fixed materials
//! together.

use super::BASES;
use crate::brdf::{self, blinn_phong};
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;
use std::f32::consts::FRAC_1_PI;

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
    /// A fixed material as it is; `None` for one that varies.
    pub fixed: Option<Brdf>,
    /// Whether a texture colours its diffuse function.
    textured: bool,
}

/// The columns of a scene.
pub struct Classes {
    /// Those of each editable material: [diffuse, the first functions of its lobe], then those of the fixed
    /// ones, red, green and blue, if any object wears one. A diffuse function that a texture colours has
    /// three columns.
    pub columns: Vec<Column>,
    /// By material.
    of_material: Vec<Class>,
    basis: BrdfBasis,
}

/// Most planes of values that one material reflects.
pub const MOST: usize = BASES + 2;

impl Classes {
    /// For the materials of `scene` that vary and their `basis`, of [`BASES`] functions at most.
    pub fn new(scene: &Scene, basis: BrdfBasis) -> Self {
        let varying = &scene.vary.materials;
        let mut columns = Vec::new();
        let mut of_varying = Vec::new();
        for (class, material) in varying.iter().enumerate() {
            let textured = scene.materials[*material].texture.is_some();
            let first = columns.len();
            let channels: &[Option<usize>] = if textured { &[Some(0), Some(1), Some(2)] } else { &[None] };
            columns.extend(channels.iter().map(|channel| Column { class, basis: 0, channel: *channel }));
            columns.extend((1..basis.bases()).map(|basis| Column { class, basis, channel: None }));
            of_varying.push(Class { first, columns: columns.len() - first, fixed: None, textured });
        }
        let first = columns.len();
        let of_material = scene.materials.iter().enumerate().map(|(index, material)| {
            let varying = varying.iter().position(|m| *m == index).map(|class| of_varying[class].clone());
            varying.unwrap_or(Class { first, columns: 3, fixed: Some(material.brdf), textured: false })
        });
        let of_material: Vec<Class> = of_material.collect();
        if scene.objects.iter().any(|object| of_material[object.material].fixed.is_some()) {
            let class = varying.len();
            columns.extend((0..3).map(|c| Column { class, basis: 0, channel: Some(c) }));
        }
        Self { columns, of_material, basis }
    }

    /// How a material of the scene reflects.
    pub fn of(&self, material: u32) -> &Class {
        &self.of_material[material as usize]
    }

    /// What each column counts for in each channel if the varying materials are `materials`, in the order of
    /// `vary`; `None` if one is of another model.
    pub fn weights(&self, materials: &[Brdf]) -> Option<Vec<Rgb>> {
        let coefficients: Vec<Vec<Rgb>> =
            materials.iter().map(|material| self.basis.coefficients_of(material)).collect::<Option<_>>()?;
        let weight = |column: &Column| {
            let all = coefficients.get(column.class).map_or([1.0; 3], |of_class| of_class[column.basis]);
            std::array::from_fn(|c| if column.channel.is_none_or(|only| only == c) { all[c] } else { 0.0 })
        };
        Some(self.columns.iter().map(weight).collect())
    }

    /// The value that every column of `class` has in all directions, sr⁻¹, those that change with them 0, and
    /// how many of the first are such; `albedo` is the texture's at the point.
    pub fn even(&self, class: &Class, albedo: Vec3A) -> ([f32; MOST], usize) {
        let mut values = [0.0; MOST];
        let count = match &class.fixed {
            Some(Brdf::BlinnPhong(material)) if material.ks == [0.0; 3] => {
                values[..3].copy_from_slice(&blinn_phong::evaluate(material, albedo, 1.0).to_array());
                3
            }
            Some(_) => 0,
            None if self.has_even_diffuse() => {
                let count = class.columns + 1 - self.basis.bases();
                (0..count).for_each(|c| values[c] = FRAC_1_PI * if class.textured { albedo[c] } else { 1.0 });
                count
            }
            None => 0,
        };
        (values, count)
    }

    /// The value of every column of `class`, sr⁻¹.
    pub fn evaluate(&self, class: &Class, albedo: Vec3A, angles: &Angles) -> [f32; MOST] {
        let mut values = [0.0; MOST];
        match &class.fixed {
            Some(material) => {
                values[..3].copy_from_slice(&brdf::evaluate(material, albedo, angles).to_array());
            }
            None => {
                let first = class.columns - self.basis.bases();
                self.basis.evaluate(angles, &mut values[first..class.columns]);
                if class.textured {
                    let diffuse = values[first];
                    (0..3).for_each(|c| values[c] = diffuse * albedo[c]);
                }
            }
        }
        values
    }

    /// GGX's diffuse function leaves out what highlights reflect; the others' is Lambert's.
    fn has_even_diffuse(&self) -> bool {
        self.basis.functions.model() != relume_formats::state::Model::Ggx
    }
}
