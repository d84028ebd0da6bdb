use super::*;
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, Rgba};

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn decoded(bytes: &[u8]) -> Result<Texture> {
    decode(bytes, &Place::file("t.png"))
}

#[test]
fn every_depth_and_channel_count_becomes_8_bit_rgba() {
    let rgb = RgbImage::from_fn(3, 2, |x, y| Rgb([x as u8 * 80, y as u8 * 200, 7]));
    let texture = decoded(&encoded(rgb, ImageFormat::Png)).unwrap();
    assert_eq!(texture.size, [3, 2]);
    assert_eq!(
        texture.texels[..4],
        [[0, 0, 7, 255], [80, 0, 7, 255], [160, 0, 7, 255], [0, 200, 7, 255]],
        "rows from the top"
    );
    let grey = decoded(&encoded(GrayImage::from_pixel(1, 1, Luma([90])), ImageFormat::Png)).unwrap();
    assert_eq!(grey.texels, [[90, 90, 90, 255]]);
    // 16 bits: 257 steps per step of 8 bits.
    let deep: ImageBuffer<Rgba<u16>, _> =
        ImageBuffer::from_pixel(1, 1, Rgba([257 * 10, 257 * 20, 257 * 30, 257 * 40]));
    assert_eq!(decoded(&encoded(deep, ImageFormat::Png)).unwrap().texels, [[10, 20, 30, 40]]);
    // JPEG keeps an even colour to within its quantisation.
    let jpeg =
        decoded(&encoded(RgbImage::from_pixel(16, 8, Rgb([200, 100, 50])), ImageFormat::Jpeg)).unwrap();
    assert_eq!(jpeg.size, [16, 8]);
    let far = |t: &[u8; 4]| t.iter().zip([200u8, 100, 50, 255]).any(|(a, b)| a.abs_diff(b) > 4);
    assert!(!jpeg.texels.iter().any(far), "{:?}", jpeg.texels[0]);
}

#[test]
fn what_is_no_picture_is_refused() {
    for (bytes, part) in [
        (b"GIF89a".as_slice(), "it reads PNG and JPEG"),
        (b"", "it reads PNG and JPEG"),
        (b"\x89PNG\r\n\x1a\n", "broken picture"),
    ] {
        let message = decoded(bytes).unwrap_err().to_string();
        assert!(
            message.starts_with("t.png: ") && message.contains(part) && !message.contains('\n'),
            "{message}"
        );
    }
    let noise =
        RgbImage::from_fn(64, 64, |x, y| Rgb([(x * 37 + y * 91) as u8, (x * y) as u8, (x ^ y) as u8]));
    let whole = encoded(noise, ImageFormat::Png);
    assert!(decoded(&whole).is_ok());
    // However it is cut short, it is refused and nothing panics.
    for length in (0..whole.len() - 12).step_by(61) {
        assert!(decoded(&whole[..length]).is_err(), "{length}");
    }
}

/// A PNG whose header declares a size that its few bytes cannot fill.
fn png_of_declared_size(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = encoded(GrayImage::new(1, 1), ImageFormat::Png);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let crc = !bytes[12..29].iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    });
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    bytes
}

#[test]
fn sizes_are_capped_before_texels_are_allocated() {
    for (width, height) in [(8193, 1), (1, 8193), (8192, 8192), (4097, 4096), (u32::MAX >> 1, u32::MAX >> 1)]
    {
        let message = decoded(&png_of_declared_size(width, height)).unwrap_err().to_string();
        assert!(message.contains("at most 8192 a side and 16777216 in all"), "{width}×{height}: {message}");
    }
    // The checksum is right, so that it is the size that was refused above: a small one goes on to miss its
    // data.
    assert!(decoded(&png_of_declared_size(2, 2)).unwrap_err().to_string().contains("broken picture"));
    let widest = decoded(&encoded(GrayImage::new(8192, 2), ImageFormat::Png)).unwrap();
    assert_eq!(widest.texels.len(), 16384);
}

#[test]
fn a_file_is_read_once_per_way_of_wrapping() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.png");
    std::fs::write(&path, encoded(GrayImage::new(1, 1), ImageFormat::Png)).unwrap();
    let mut textures = Textures::default();
    let first = textures.read(&path).unwrap();
    assert!(Arc::ptr_eq(&first, &textures.read(&path).unwrap()));
    let key = TextureKey { file: path.clone(), image: None, wrap: [Wrap::Clamp; 2], filter: Filter::Nearest };
    let clamped = textures.get_or_decode(key, &Place::file(&path), || read_bytes(&path)).unwrap();
    assert!(!Arc::ptr_eq(&first, &clamped) && clamped.texels == first.texels);
    assert!(textures.read(&folder.path().join("gone.png")).unwrap_err().is_bad_input());
}
