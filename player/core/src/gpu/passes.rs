//! The passes of one frame, timed where the device has timestamps.

use super::timer::{Slot, Timer};
use wgpu::{CommandEncoder, ComputePass, RenderPass, TextureView};

/// The passes of a frame as they are encoded.
pub(crate) struct Passes<'a> {
    encoder: &'a mut CommandEncoder,
    slot: Option<&'a mut Slot>,
}

impl<'a> Passes<'a> {
    /// No passes yet of frame number `frame`; they are timed by `timer`, if there is one and it has room.
    pub(crate) fn new(encoder: &'a mut CommandEncoder, timer: Option<&'a mut Timer>, frame: u64) -> Self {
        Self { encoder, slot: timer.and_then(|timer| timer.begin(frame)) }
    }

    /// Begins a compute pass.
    pub(crate) fn compute(&mut self, label: &'static str) -> ComputePass<'_> {
        let timestamp_writes =
            self.slot.as_deref_mut().and_then(|slot| Some((slot.next(label)?, &slot.queries)));
        let timestamp_writes =
            timestamp_writes.map(|([begin, end], query_set)| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(begin),
                end_of_pass_write_index: Some(end),
            });
        self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes })
    }

    /// Begins a pass that draws on `colour`, cleared to black, and on `depth`, cleared to 0; the depth is not
    /// kept.
    pub(crate) fn draw(
        &mut self,
        label: &'static str,
        colour: &TextureView,
        depth: &TextureView,
    ) -> RenderPass<'_> {
        let timestamp_writes = render_timestamps(&mut self.slot, label);
        self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(cleared(depth, wgpu::StoreOp::Discard)),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// Begins a pass that draws on `depth` alone, cleared to 0, which is kept.
    pub(crate) fn draw_depth(&mut self, label: &'static str, depth: &TextureView) -> RenderPass<'_> {
        let timestamp_writes = render_timestamps(&mut self.slot, label);
        self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            depth_stencil_attachment: Some(cleared(depth, wgpu::StoreOp::Store)),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// The end.
    pub(crate) fn finish(self) {
        if let Some(slot) = self.slot {
            slot.finish(self.encoder);
        }
    }
}

fn render_timestamps<'a>(
    slot: &'a mut Option<&mut Slot>,
    label: &'static str,
) -> Option<wgpu::RenderPassTimestampWrites<'a>> {
    let slot = slot.as_deref_mut()?;
    let ([begin, end], query_set) = (slot.next(label)?, &slot.queries);
    Some(wgpu::RenderPassTimestampWrites {
        query_set,
        beginning_of_pass_write_index: Some(begin),
        end_of_pass_write_index: Some(end),
    })
}

/// Depth that begins at 0.
fn cleared(depth: &TextureView, store: wgpu::StoreOp) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view: depth,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store }),
        stencil_ops: None,
    }
}
