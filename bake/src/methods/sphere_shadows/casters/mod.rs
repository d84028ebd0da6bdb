//! What objects cast shadows by: their spheres, some triangles of their mesh, or nothing where nobody would
//! see it.
//!
//! For each object there are options ([`options`]): its mesh simplified to more and more triangles
//! ([`surface`]), and its spheres if it has some. Of each is known what it costs a frame and by how much the
//! light at some receivers differs from that under the whole mesh, in the poses and under the held-out lights
//! that bakes are measured on. From these [`choose`] takes the cheapest that keep the error asked for.

mod choose;
mod options;
mod solids;
pub mod surface;

pub use choose::{Choice, chosen};
pub use options::{CasterOption, options};

use super::method::Asked;
use crate::error::Result;
use crate::job::Job;
use relume_formats::kinds::sphere_shadows::Casts;
use relume_formats::kinds::{Environment, SphereSet, SphereShadows};
use relume_scenes::{Object, Scene};
use surface::Simplified;

/// The part of the error asked for that casters may make: errors add by their squares, so three quarters of
/// these are left for texels, lobes and terms.
const SHARE: f64 = 0.5;

/// The part of what casters may make that an object may make by casting nothing.
const UNSEEN: f64 = 0.25;

/// What an object casts by.
#[derive(Debug, Clone, PartialEq)]
pub enum By {
    /// Nothing.
    Nothing,
    /// Its sphere set, of so many.
    Spheres(u32),
    /// Triangles, at least one.
    Mesh(Simplified),
}

impl From<Simplified> for By {
    /// Casting by no triangles, all that may be left of a small or thin object, is casting nothing.
    fn from(mesh: Simplified) -> Self {
        if mesh.triangles.is_empty() { Self::Nothing } else { Self::Mesh(mesh) }
    }
}

impl By {
    /// What a frame takes for it, in nanoseconds of one core for a receiver of a plane. Measured by `cargo bench
    /// -p relume-formats --bench sphere_shadows` for spheres and closed meshes, both sides of whose triangles
    /// are looked at and one is added; of open ones both are.
    pub fn cost(&self) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Spheres(count) => 10.0 * f64::from(*count),
            Self::Mesh(mesh) => mesh.triangles.len() as f64 * if mesh.closed { 4.0 } else { 7.0 },
        }
    }

    /// For the user.
    pub fn words(&self) -> String {
        match self {
            Self::Nothing => "nothing".to_owned(),
            Self::Spheres(count) => format!("{count} spheres"),
            Self::Mesh(mesh) => {
                let count = mesh.triangles.len();
                format!("{count} triangle{}", if count == 1 { "" } else { "s" })
            }
        }
    }
}

/// What each object of `scene`, whose receivers are those of `shadows`, casts by. `sets` are those of the objects
/// that have spheres; without them none casts by spheres if it need not.
///
/// # Errors
/// If a clip leads beyond all numbers, a sphere cannot follow, or the user interrupts.
pub fn choose(
    scene: &Scene,
    shadows: &SphereShadows,
    maps: &[Environment],
    sets: Option<&[SphereSet]>,
    asked: Asked,
    job: &Job,
) -> Result<Vec<Choice>> {
    let (asked, error) = match asked {
        Asked::Error(max) => (Asked::Error(SHARE * max), SHARE * max),
        other => (other, 0.0),
    };
    let mut options = options(scene, shadows, maps, sets, asked, job)?;
    // An eye misses the shadow of a ground before all others add up to that much.
    let is_missed = |option: &CasterOption| option.by == By::Nothing && option.error() > UNSEEN * error;
    options.iter_mut().for_each(|options| options.retain(|option| !is_missed(option)));
    Ok(chosen(&options, error))
}

/// What objects of `scene` cast by, and why, a sentence each.
pub fn sentences(scene: &Scene, choices: &[Choice]) -> Vec<String> {
    let sentence = |(object, Choice { by, error, spheres }): (&Object, &Choice)| {
        let (name, error) = (&object.name, 100.0 * error);
        let is = match by {
            By::Nothing => format!("`{name}` casts nothing: its shadow is {error:.2} % of the light"),
            by => format!("`{name}` casts by {}, {error:.2} % off", by.words()),
        };
        let asked = object.spheres.filter(|count| *by != By::Spheres(*count));
        match (asked, spheres) {
            (Some(count), Some((off, cost))) => {
                let off = 100.0 * off;
                format!("{is}; its {count} spheres would be {off:.2} % off, in {cost:.2} times the time")
            }
            (Some(count), None) if By::Spheres(count).cost() < by.cost() => {
                format!("{is}; by its {count} spheres if these, once fitted, are as good")
            }
            _ => is,
        }
    };
    scene.objects.iter().zip(choices).map(sentence).collect()
}

/// Puts into `shadows` what its objects cast by, one of `by` for each.
pub fn put(shadows: &mut SphereShadows, by: &[By]) {
    (shadows.casters, shadows.caster_offsets, shadows.caster_errors) = Default::default();
    for (object, by) in shadows.meta.objects.iter_mut().zip(by) {
        object.casts = match by {
            By::Nothing => Casts::Nothing,
            By::Spheres(_) => Casts::Spheres,
            By::Mesh(mesh) => {
                let first = object.first_vertex;
                shadows.casters.extend(mesh.triangles.iter().map(|t| t.map(|vertex| first + vertex)));
                shadows.caster_offsets.extend(&mesh.offsets);
                shadows.caster_errors.extend(&mesh.errors);
                Casts::Mesh { triangles: mesh.triangles.len() as u32, closed: mesh.closed }
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_triangles_are_nothing() {
        let none = Simplified { triangles: vec![], closed: true, offsets: vec![], errors: vec![] };
        assert_eq!(By::from(none), By::Nothing);
    }
}
