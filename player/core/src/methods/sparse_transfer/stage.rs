//! A bake at play: light, columns, picture, and which of them has to be computed again.

use super::columns::Columns;
use crate::controls::Look;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Light, Map, Picture};
use relume_formats::kinds::Environment;
use relume_formats::kinds::sparse_transfer::Block;
use relume_formats::state::Rgb;

/// Everything that it takes to draw a frame.
pub(super) struct Stage {
    light: Light,
    columns: Columns,
    pub(super) picture: Picture,
    /// Factor on all light.
    gain: Rgb,
    light_changed: bool,
    columns_changed: bool,
}

impl Stage {
    pub(super) fn new(light: Light, columns: Columns, picture: Picture) -> Self {
        Self { light, columns, picture, gain: [1.0; 3], light_changed: false, columns_changed: false }
    }

    /// Takes the next block of columns.
    pub(super) fn block_arrived(&mut self, gpu: &Gpu, block: &Block) {
        self.columns.block_arrived(gpu, block);
        self.columns_changed = true;
    }

    /// Adds an environment map, or puts it in the place of the one that has its name.
    pub(super) fn add_map(&mut self, gpu: &Gpu, map: &Environment) {
        let index = self.light.add(gpu, Map::new(gpu, map));
        self.picture.set_map(gpu, index, &self.light);
    }

    /// Sets how things look.
    pub(super) fn update(&mut self, gpu: &Gpu, look: &Look) {
        if let Some(environment) = &look.environment {
            if self.light.set(gpu, environment) {
                self.picture.set_suns(gpu, &self.light);
                self.light_changed = true;
            }
            self.gain = environment.gain;
        }
        self.picture.set(gpu, &look.camera, self.gain);
    }

    /// Encodes a frame, and of what comes before the picture no more than has changed.
    pub(super) fn encode(&mut self, passes: &mut Passes<'_>) {
        if self.light_changed {
            self.light.encode(passes);
        }
        if self.light_changed || self.columns_changed {
            self.columns.encode(passes);
        }
        self.picture.encode(self.light.map(), passes);
        (self.light_changed, self.columns_changed) = (false, false);
    }

    /// Radiance by vertex, and the gain.
    pub(super) fn vertex_radiance(&self) -> (&wgpu::Buffer, Rgb) {
        (self.columns.radiance(), self.gain)
    }

    pub(super) fn columns(&self) -> &Columns {
        &self.columns
    }

    pub(super) fn film(&self) -> &Film {
        self.picture.film()
    }

    #[cfg(test)]
    pub(super) fn light(&self) -> &Light {
        &self.light
    }

    /// Whether the next frame computes the light, and whether there are new columns.
    #[cfg(test)]
    pub(super) fn changes(&self) -> [bool; 2] {
        [self.light_changed, self.columns_changed]
    }
}
