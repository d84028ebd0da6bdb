use super::*;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Vec2, WritableImage, f16,
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
        let samples = if half { FlatSamples::F16(values.map(f16::from_f32).collect()) } else { FlatSamples::F32(values.collect()) };
        AnyChannel::new(name, samples)
    };
    let channels = AnyChannels::sort(SmallVec::from_vec(vec![channel(0, "R"), channel(1, "G"), channel(2, "B")]));
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
    for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ] {
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
    assert_eq!((map.texels[3], map.texels[70], map.texels[4]), ([0.0, 0.0, 2.0], [65_504.0, 1.0, 0.0], texel(4, 0)));
    assert_eq!(map.texels[90], [1e6, 0.0, 2e6]);
    assert!(warnings[0].ends_with("mended 3 of 2048 texels, which are negative, infinite or NaN"), "{warnings:?}");
}

#[test]
fn hdr_maps_read_rows_from_the_top() {
    // Flat RGBE: (m / 256) · 2^(e − 128).
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n".to_vec();
    bytes.extend([128, 64, 0, 129, 200, 0, 0, 136]);
    std::fs::write(&path, bytes).unwrap();
    let (map, _) = read(&path);
    assert_eq!((map.width, map.height), (1, 2));
    assert_eq!(map.texels, [[1.0, 0.5, 0.0], [200.0, 0.0, 0.0]]);
}

#[test]
fn broken_and_oversized_maps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let header = |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    for (name, content, part) in [
        ("a.hdr", b"hello".to_vec(), "not a Radiance map"),
        ("a.hdr", header("-Y 99999 +X 99999"), "99999×99999 texels"),
        ("a.hdr", header("-Y 2 +X 2"), "not a Radiance map"),
        ("a.exr", b"hello".to_vec(), "not an OpenEXR map"),
        ("a.png", Vec::new(), "it reads .hdr and .exr"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let message = read_map(&path, &mut Vec::new()).unwrap_err().to_string();
        assert!(message.contains(part) && message.contains(name) && !message.contains('\n'), "{message}");
    }
}
