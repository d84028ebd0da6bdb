//! Where things are. Lengths are in points: pixels of a display without scaling.

use egui::{Panel, Pos2, Rect, Vec2};

/// Width of the panel on the right.
const PANEL_WIDTH: f32 = 344.0;
/// In a window narrower than this the panel is below the picture.
const LEAST_WIDTH: f32 = 600.0;
/// How much of such a window's height the panel takes.
const PANEL_SHARE: f32 = 0.5;
/// Least distance between the picture and what surrounds it.
const MARGIN: f32 = 12.0;

/// The panel's place in a window of `size`.
pub(super) fn panel(size: Vec2) -> Panel {
    let panel = if size.x < LEAST_WIDTH {
        Panel::bottom("panel below").exact_size((PANEL_SHARE * size.y).round())
    } else {
        Panel::right("panel").exact_size(PANEL_WIDTH)
    };
    panel.resizable(false)
}

/// The largest rectangle of the film's shape in the middle of `area`, its edges on whole pixels of the
/// display.
pub(super) fn image_rect(area: Rect, [width, height]: [u32; 2], pixels_per_point: f32) -> Rect {
    let room = (area.size() - Vec2::splat(2.0 * MARGIN)).max(Vec2::splat(1.0));
    let film = Vec2::new(width.max(1) as f32, height.max(1) as f32);
    let scale = (room / film).min_elem();
    let on_pixel = |x: f32| (x * pixels_per_point).round() / pixels_per_point;
    let size = Vec2::new(on_pixel(film.x * scale), on_pixel(film.y * scale))
        .max(Vec2::splat(1.0 / pixels_per_point));
    let corner = area.center() - 0.5 * size;
    Rect::from_min_size(Pos2::new(on_pixel(corner.x), on_pixel(corner.y)), size)
}

/// The pixel of the film under `position`, if it is on the picture.
pub(super) fn pixel_at(image: Rect, [width, height]: [u32; 2], position: Pos2) -> Option<[u32; 2]> {
    let within = (position - image.min) / image.size();
    let inside = (0.0..1.0).contains(&within.x) && (0.0..1.0).contains(&within.y);
    inside.then_some([(within.x * width as f32) as u32, (within.y * height as f32) as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_fits_keeps_its_shape_and_stands_on_pixels() {
        for (area, film, scale) in [
            ([900.0, 700.0], [512, 512], 1.0),
            ([900.0, 300.0], [640, 480], 1.5),
            ([80.0, 900.0], [37, 23], 2.0),
            ([5.0, 5.0], [512, 64], 1.0),
        ] {
            let area = Rect::from_min_size(Pos2::new(3.0, 7.0), area.into());
            let image = image_rect(area, film, scale);
            let room = area.shrink(MARGIN);
            if room.is_positive() {
                assert!(room.expand(1.0 / scale).contains_rect(image), "{image} in {area}");
                let touches = (image.width() - room.width()).abs() <= 1.0 / scale
                    || (image.height() - room.height()).abs() <= 1.0 / scale;
                assert!(touches, "{image} in {area}");
                let stretched = (image.width() - image.height() * film[0] as f32 / film[1] as f32).abs();
                assert!(stretched <= (1.0 + film[0] as f32 / film[1] as f32) / scale, "{image}");
            }
            for edge in [image.min.x, image.min.y, image.max.x, image.max.y] {
                assert!((edge * scale - (edge * scale).round()).abs() < 1e-3, "{image}");
            }
        }
    }

    #[test]
    fn every_pixel_is_found_under_its_centre() {
        let film = [37, 23];
        let image = image_rect(Rect::from_min_size(Pos2::ZERO, Vec2::new(500.0, 400.0)), film, 1.0);
        for y in 0..film[1] {
            for x in 0..film[0] {
                let centre = image.min
                    + (Vec2::new(x as f32, y as f32) + Vec2::splat(0.5)) / Vec2::new(37.0, 23.0)
                        * image.size();
                assert_eq!(pixel_at(image, film, centre), Some([x, y]));
            }
        }
        for outside in [image.min - Vec2::splat(0.1), image.max, Pos2::new(f32::NAN, 30.0)] {
            assert_eq!(pixel_at(image, film, outside), None);
        }
    }
}
