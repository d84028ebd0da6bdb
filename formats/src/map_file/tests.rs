use super::*;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    Vec2, WritableImage, f16,
};

const SIZE: (usize, usize) = (64, 32);

fn texel(x: usize, y: usize) -> Rgb {
    [x as f32 / 64.0, 1.0 + y as f32, 1000.0]
}

fn texels() -> Vec<Rgb> {
    (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| texel(x, y))).collect()
}

fn write_exr(path: &Path, texels: &[Rgb], half: bool, compression: Compression) {
    let channel = |k: usize, name: &str| {
        let values = texels.iter().map(|t| t[k]);
        let samples = if half {
            FlatSamples::F16(values.map(f16::from_f32).collect())
        } else {
            FlatSamples::F32(values.collect())
        };
        AnyChannel::new(name, samples)
    };
    let channels =
        AnyChannels::sort(SmallVec::from_vec(vec![channel(0, "R"), channel(1, "G"), channel(2, "B")]));
    let encoding = Encoding { compression, ..Encoding::SMALL_LOSSLESS };
    let layer = Layer::new(Vec2(SIZE.0, SIZE.1), LayerAttributes::named("sky"), encoding, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

fn read(path: &Path) -> (EquirectMap, Vec<String>) {
    let mut warnings = Vec::new();
    (read_map(path, &mut warnings).unwrap(), warnings)
}

#[test]
fn exr_maps_read_back_in_any_lossless_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        for half in [false, true] {
            write_exr(&path, &texels(), half, compression);
            let (map, warnings) = read(&path);
            assert_eq!((map.width, map.height), (64, 32));
            // All values are exact in half floats.
            assert_eq!(map.texels, texels(), "{compression} half {half}");
            assert_eq!(warnings, [] as [&str; 0]);
        }
    }
}

#[test]
fn illegal_texels_are_mended_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    let mut broken = texels();
    broken[3] = [-1.0, f32::NAN, 2.0];
    broken[70] = [f32::INFINITY, 1.0, f32::NEG_INFINITY];
    // Ringing beside a sun: the sun itself must stay as bright as it is.
    broken[90] = [1e6, -0.001, 2e6];
    write_exr(&path, &broken, false, Compression::ZIP16);
    let (map, warnings) = read(&path);
    assert_eq!(
        (map.texels[3], map.texels[70], map.texels[4]),
        ([0.0, 0.0, 2.0], [65_504.0, 1.0, 0.0], texel(4, 0))
    );
    assert_eq!(map.texels[90], [1e6, 0.0, 2e6]);
    assert!(
        warnings[0].ends_with("mended 3 of 2048 texels, which are negative, infinite or NaN"),
        "{warnings:?}"
    );
}

/// A Radiance picture of that size, all its texels of radiance 1.
fn write_hdr(path: &Path, header: &str, width: usize, height: usize) {
    let texels = [128, 128, 128, 129].repeat(width * height);
    std::fs::write(
        path,
        [format!("#?RADIANCE\n{header}\n-Y {height} +X {width}\n").as_bytes(), &texels].concat(),
    )
    .unwrap();
}

#[test]
fn only_maps_twice_as_wide_as_high_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    for (width, height) in [(2, 1), (32, 16), (33, 16), (32, 17), (64, 31)] {
        write_hdr(&path, "", width, height);
        assert_eq!(read(&path).0.texels.len(), width * height);
    }
    for (width, height, what) in [
        (8, 8, "8 × 8 texels, square as mirror balls and angular probes are"),
        (40, 30, "40 × 30 texels, as photographs are, or a cube map's horizontal cross"),
        (30, 40, "30 × 40 texels, as photographs are, or a cube map's vertical cross"),
        (48, 8, "48 × 8 texels, as a strip of a cube map's faces"),
        (8, 48, "8 × 48 texels, as a strip of a cube map's faces"),
        (64, 29, "64 × 29 texels"),
        (3, 1, "3 × 1 texels"),
    ] {
        write_hdr(&path, "", width, height);
        let message = read_map(&path, &mut Vec::new()).unwrap_err().to_string();
        let expected = format!(
            "{}: {what}; an equirectangular map is twice as wide as high, convert it to one",
            path.display()
        );
        assert_eq!(message, expected);
    }
}

#[test]
fn colours_of_other_primaries_become_rec_709() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    let texel = |header: &str, rgbe: [u8; 4]| {
        let bytes = [format!("#?RADIANCE\n{header}\n-Y 1 +X 2\n").as_bytes(), &rgbe.repeat(2)].concat();
        std::fs::write(&path, bytes).unwrap();
        let (map, warnings) = read(&path);
        (map.texels[0], warnings)
    };
    let p3 = "PRIMARIES= .680 .320 .265 .690 .150 .060 .3127 .3290\nEXPOSURE=2\n";
    // P3's (1, 0.5, 0.25), over an exposure of 2.
    let (colour, warnings) = texel(p3, [128, 64, 32, 130]);
    let expected = [1.2249402 - 0.1124701, -0.0420570 + 0.5210286, -0.0196376 - 0.0393181 + 0.2745684];
    assert!(colour.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{colour:?}, {expected:?}");
    assert_eq!(warnings, [] as [&str; 0]);
    let (green, warnings) = texel(p3, [0, 128, 0, 130]);
    assert!(green[0] == 0.0 && green[2] == 0.0 && (green[1] - 1.0420571).abs() < 1e-4, "{green:?}");
    assert!(
        warnings[0].ends_with("clipped the colours of 2 of 2 texels, which Rec. 709 does not reach"),
        "{warnings:?}"
    );
    let (colour, warnings) = texel("PRIMARIES= 0 0 0 0 0 0 0 0\n", [128, 64, 32, 129]);
    assert_eq!(colour, [1.0, 0.5, 0.25]);
    assert!(
        warnings[0].ends_with("its chromaticities span no colour space; its colours are taken for Rec. 709"),
        "{warnings:?}"
    );
}

#[test]
fn broken_and_oversized_maps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let header = |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    for (name, content, part) in [
        (
            "a.hdr",
            b"hello".to_vec(),
            "is no Radiance file, though its name says so, but a text; save the picture again",
        ),
        ("a.hdr", header("-Y 99999 +X 99999"), "99999 × 99999 texels"),
        ("a.hdr", header("-Y 1 +X 2"), "scan line 1 of 1 is cut short"),
        (
            "a.exr",
            b"hello".to_vec(),
            "is no OpenEXR file, though its name says so, but a text; save the picture again",
        ),
        ("a.png", Vec::new(), "it reads .hdr and .exr, convert it"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let message = read_map(&path, &mut Vec::new()).unwrap_err().to_string();
        assert!(message.contains(part) && message.contains(name) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn light_that_mending_adds_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    // Every fourth column takes away a quarter of what the others bring, whatever their solid angle: 2.25
    // without it is 3.
    let taking = |texel: f32| {
        (0..SIZE.0 * SIZE.1).map(|i| [if i % 4 == 0 { texel } else { 1.0 }; 3]).collect::<Vec<_>>()
    };
    for (texel, ending) in [
        (
            -0.75,
            "mended 512 of 2048 texels, which are negative, infinite or NaN; that adds 33.3 % to its light",
        ),
        (-0.002, "mended 512 of 2048 texels, which are negative, infinite or NaN"),
        (
            -3.0,
            "mended 512 of 2048 texels, which are negative, infinite or NaN; with its negative values it has no light in all",
        ),
    ] {
        write_exr(&path, &taking(texel), false, Compression::ZIP16);
        let (map, warnings) = read(&path);
        assert_eq!((map.texels[0], map.texels[1]), ([0.0; 3], [1.0; 3]));
        assert!(warnings[0].ends_with(ending), "{warnings:?}");
    }
}
