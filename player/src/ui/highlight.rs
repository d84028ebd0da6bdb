//! The line around a material, drawn over the picture.

use super::picker::Picker;
use super::style::ACCENT;
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};

/// How long a newly selected material stays outlined, in seconds.
const FLASH_S: f64 = 1.2;
/// One pixel of line for so many pixels of the film's longer side.
const PIXELS_PER_LINE: u32 = 320;

/// Which material is outlined, and the texture that does it.
#[derive(Default)]
pub struct Highlight {
    /// Material of the texture.
    outlined: Option<(String, TextureHandle)>,
    selected: Option<String>,
    flash_ends_s: f64,
}

impl Highlight {
    /// The texture to lay over the picture now: around what is `hovered`, or for a moment around what was
    /// `selected` last.
    pub fn texture(
        &mut self,
        ctx: &Context,
        picker: &Picker,
        hovered: Option<&str>,
        selected: Option<&str>,
    ) -> Option<&TextureHandle> {
        let now_s = ctx.input(|input| input.time);
        if self.selected.as_deref() != selected {
            self.selected = selected.map(str::to_owned);
            self.flash_ends_s = now_s + FLASH_S;
        }
        let flashes = now_s < self.flash_ends_s;
        if flashes {
            ctx.request_repaint_after_secs((self.flash_ends_s - now_s) as f32);
        }
        let wanted = hovered.or(selected.filter(|_| flashes))?;
        if self.outlined.as_ref().is_none_or(|(name, _)| name != wanted) {
            self.outlined = Some((
                wanted.to_owned(),
                ctx.load_texture("outline", outline(picker, wanted), TextureOptions::LINEAR),
            ));
        }
        self.outlined.as_ref().map(|(_, texture)| texture)
    }
}

fn outline(picker: &Picker, material: &str) -> ColorImage {
    let [width, height] = picker.size();
    let line = picker.outline(material, (width.max(height) / PIXELS_PER_LINE).max(1) as usize);
    let pixels =
        line.into_iter().map(|on_line| if on_line { ACCENT } else { Color32::TRANSPARENT }).collect();
    ColorImage::new([width as usize, height as usize], pixels)
}
