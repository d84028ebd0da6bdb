//! The radiance of the receivers without a GPU: the fast path of `relume_formats` on all cores.

use super::receivers::Receivers;
use crate::gpu::Gpu;
use glam::Vec3;
use relume_formats::basis::suns::split;
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sparse_transfer;
use relume_formats::evaluate::sphere_shadows::{Detail, Function, Receiver, light};
use relume_formats::fast::sphere_shadows::{Shading, order};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{Environment, HaarTable};
use relume_formats::state::Rgb;

/// Light and lobes on the CPU.
pub(super) struct OnCpu {
    /// Without their suns, which are drawn.
    maps: Vec<Environment>,
    lobes: Vec<Function>,
    detail: Detail,
    table: HaarTable,
    /// The receivers in the order in which they are shaded.
    order: Vec<u32>,
    /// As soon as there is light, with its gain.
    folded: Option<(Shading, Rgb)>,
}

fn without_suns(map: Environment) -> Environment {
    let rest = split(&map.map).rest.into_owned();
    Environment { map: rest, ..map }
}

impl OnCpu {
    /// Of `lobes`, cut to the terms of `detail`, in the light of `maps`, for `receivers`, whose
    /// neighbourhoods at rest serve in all poses.
    pub(super) fn new(
        maps: Vec<Environment>,
        lobes: Vec<Function>,
        detail: Detail,
        receivers: &Receivers,
    ) -> Self {
        let positions: Vec<Vec3> = receivers.now().iter().map(|receiver| receiver.position).collect();
        let maps = maps.into_iter().map(without_suns).collect();
        Self { maps, lobes, detail, table: HaarTable::bake(), order: order(&positions), folded: None }
    }

    /// Adds an environment map, or puts it in the place of the one that has its name.
    pub(super) fn add_map(&mut self, map: Environment) {
        let map = without_suns(map);
        match self.maps.iter_mut().find(|known| known.name == map.name) {
            Some(known) => *known = map,
            None => self.maps.push(map),
        }
    }

    /// Folds the light of `look` into the lobes.
    pub(super) fn set_light(&mut self, look: &EnvironmentLook) {
        let Some(map) = self.maps.iter().find(|map| map.name == look.map) else { return };
        let light = light(sparse_transfer::light(&map.map, look, SIDE), self.detail.terms);
        self.folded = Some((Shading::new(&self.lobes, &light, self.detail.levels), look.gain));
    }

    /// Computes and uploads the radiance of `receivers`, before the gain, with which the picture is drawn.
    pub(super) fn shade(&self, gpu: &Gpu, receivers: &mut Receivers, radiance: &wgpu::Buffer) {
        let Some((shading, gain)) = &self.folded else { return };
        let ordered: Vec<Receiver> =
            self.order.iter().map(|index| receivers.now()[*index as usize]).collect();
        let mut lit = vec![[0.0; 3]; ordered.len()];
        shading.radiance(&ordered, receivers.placed(), &self.table, &mut lit);
        let without_gain =
            |channel: usize, value: f32| if gain[channel] > 0.0 { value / gain[channel] } else { 0.0 };
        let mut padded = vec![[0.0; 4]; ordered.len()];
        for (index, rgb) in self.order.iter().zip(lit) {
            padded[*index as usize] =
                [without_gain(0, rgb[0]), without_gain(1, rgb[1]), without_gain(2, rgb[2]), 0.0];
        }
        gpu.write(radiance, 0, bytemuck::cast_slice(&padded));
    }
}
