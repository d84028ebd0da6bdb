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

/// `area` with its edges on whole pixels of the display, and how many those are; one at least.
pub(super) fn whole_pixels(area: Rect, pixels_per_point: f32) -> (Rect, [u32; 2]) {
    let ends = |least: f32, most: f32| {
        let first = (least * pixels_per_point).round();
        (first, (most * pixels_per_point).round().max(first + 1.0))
    };
    let (x, y) = (ends(area.min.x, area.max.x), ends(area.min.y, area.max.y));
    let whole = Rect::from_min_max(Pos2::new(x.0, y.0), Pos2::new(x.1, y.1)) / pixels_per_point;
    (whole, [(x.1 - x.0) as u32, (y.1 - y.0) as u32])
}

/// Where a picture of so many pixels is shown in the middle of `area`, which one that is under way will fill:
/// as high as that, for the camera's vertical field of view is the same. What is beside `area` is not seen.
pub(super) fn as_high_as(area: Rect, [width, height]: [u32; 2], pixels_per_point: f32) -> Rect {
    let shown = area.height() * width.max(1) as f32 / height.max(1) as f32;
    // One that was made smaller to be drawn at all is of the shape of `area` but for rounding.
    if (shown - area.width()).abs() * pixels_per_point < 2.0 {
        return area;
    }
    Rect::from_center_size(area.center(), Vec2::new(shown, area.height()))
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
    fn a_picture_fills_whole_pixels_and_keeps_its_height() {
        for (area, scale) in [([856.0, 770.0], 1.0), ([856.4, 769.7], 1.5), ([0.0, -3.0], 2.0)] {
            let area = Rect::from_min_size(Pos2::new(3.3, 7.0), area.into());
            let (whole, [width, height]) = whole_pixels(area, scale);
            assert!(width >= 1 && height >= 1);
            assert!((whole.width() * scale - width as f32).abs() < 1e-3, "{whole}");
            assert!((whole.height() * scale - height as f32).abs() < 1e-3, "{whole}");
            assert!((whole.min.x * scale - (whole.min.x * scale).round()).abs() < 1e-3, "{whole}");
            let off = (whole.max - area.max).abs().max_elem() * scale;
            assert!(off <= 0.501 || !area.is_positive(), "{whole} in {area}");
            assert_eq!(as_high_as(whole, [width, height], scale), whole);
            // Half as many pixels, rounded, are shown on the same place.
            assert_eq!(as_high_as(whole, [width.div_ceil(2), height.div_ceil(2)], scale), whole);
        }
        let area = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(400.0, 200.0));
        let shown = as_high_as(area, [512, 512], 1.0);
        assert_eq!(shown, Rect::from_center_size(area.center(), Vec2::splat(200.0)));
        let shown = as_high_as(area, [900, 300], 1.0);
        assert_eq!((shown.height(), shown.width(), shown.center()), (200.0, 600.0, area.center()));
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
