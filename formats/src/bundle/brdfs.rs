//! The parameters of all materials of a scene, as they are at one moment.

use crate::kinds::scene::StoredMaterial;
use crate::state::Brdf;
use std::collections::HashMap;
use std::ops::Index;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The next revision; each is given once.
static NEXT: AtomicU64 = AtomicU64::new(0);

fn new_revision() -> u64 {
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// The parameters of every material of a scene, in the scene's order. Copies share them until one is changed.
#[derive(Debug, Clone)]
pub struct Brdfs {
    /// Index of each name.
    names: Arc<HashMap<String, usize>>,
    brdfs: Arc<Vec<Brdf>>,
    revision: u64,
}

impl Brdfs {
    /// The default parameters of `materials`.
    pub fn of(materials: &[StoredMaterial]) -> Self {
        let names =
            materials.iter().enumerate().map(|(index, material)| (material.name.clone(), index)).collect();
        let brdfs = materials.iter().map(|material| material.brdf).collect();
        Self { names: Arc::new(names), brdfs: Arc::new(brdfs), revision: new_revision() }
    }

    /// A number that is another whenever parameters have changed: what has the same revision has the same
    /// parameters, whatever it was copied from.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Index of the material `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.names.get(name).copied()
    }

    /// Parameters of the material `name`.
    pub fn get(&self, name: &str) -> Option<&Brdf> {
        self.brdfs.get(self.index_of(name)?)
    }

    /// Name and parameters of every material, in no order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Brdf)> {
        self.names.iter().filter_map(|(name, index)| Some((name.as_str(), self.brdfs.get(*index)?)))
    }

    /// Sets the parameters of the material `name`; where there is none of this name, nothing.
    pub fn set(&mut self, name: &str, brdf: Brdf) {
        if let Some(index) = self.index_of(name) {
            self.set_at(index, brdf);
        }
    }

    /// Sets the parameters of material number `index`.
    pub(super) fn set_at(&mut self, index: usize, brdf: Brdf) {
        if let Some(old) = Arc::make_mut(&mut self.brdfs).get_mut(index) {
            *old = brdf;
            self.revision = new_revision();
        }
    }
}

impl<N: AsRef<str> + ?Sized> Index<&N> for Brdfs {
    type Output = Brdf;

    /// Parameters of the material `name`.
    ///
    /// # Panics
    /// If there is none of this name.
    fn index(&self, name: &N) -> &Brdf {
        &self.brdfs[self.names[name.as_ref()]]
    }
}

/// Equal revisions are equal without a look at the parameters.
impl PartialEq for Brdfs {
    fn eq(&self, other: &Self) -> bool {
        self.revision == other.revision || (self.names == other.names && self.brdfs == other.brdfs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::BlinnPhong;

    fn matte(kd: f32) -> Brdf {
        Brdf::BlinnPhong(BlinnPhong { kd: [kd; 3], ks: [0.0; 3], shininess: 1.0 })
    }

    fn brdfs() -> Brdfs {
        let material = |name: &str, kd| StoredMaterial {
            name: name.to_owned(),
            brdf: matte(kd),
            varies: true,
            textured: false,
            sharpest: 200.0,
        };
        Brdfs::of(&[material("b", 0.1), material("a", 0.2)])
    }

    #[test]
    fn materials_are_in_the_order_of_the_scene() {
        let brdfs = brdfs();
        assert_eq!(["b", "a", "c"].map(|name| brdfs.index_of(name)), [Some(0), Some(1), None]);
        assert_eq!((brdfs["b"], brdfs.get("a"), brdfs.get("c")), (matte(0.1), Some(&matte(0.2)), None));
    }

    #[test]
    fn a_change_is_a_new_revision_and_leaves_copies_alone() {
        let (first, mut second) = (brdfs(), brdfs());
        assert_ne!(first.revision(), second.revision());
        assert_eq!(first, second, "other revisions of the same parameters are equal");
        let copy = second.clone();
        assert_eq!(copy.revision(), second.revision());
        second.set("c", matte(0.5));
        assert_eq!(copy.revision(), second.revision(), "nothing has changed");
        second.set("a", matte(0.5));
        assert_ne!(copy.revision(), second.revision());
        assert_ne!(copy, second);
        assert_eq!((copy["a"], second["a"]), (matte(0.2), matte(0.5)));
        let mut third = copy.clone();
        third.set("a", matte(0.6));
        assert_ne!(third.revision(), second.revision(), "two copies that change differently differ");
        assert_ne!(third, second);
    }
}
