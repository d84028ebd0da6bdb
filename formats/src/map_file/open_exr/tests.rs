use super::*;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    LayerAttributes, SmallVec, WritableImage as _,
};

/// Width and height of the display windows.
const SIZE: Vec2<usize> = Vec2(8, 4);

type Part = exr::prelude::Layer<AnyChannels<FlatSamples>>;

/// A part whose channel number k, of those in `names`, is `100·k + x + 10·y` at texel (x, y) of its data
/// window.
fn part(name: &str, names: &[&str], size: Vec2<usize>, change: impl Fn(&mut LayerAttributes)) -> Part {
    let samples =
        |k: usize| (0..size.area()).map(|i| (100 * k + i % size.0 + 10 * (i / size.0)) as f32).collect();
    let channels =
        names.iter().enumerate().map(|(k, name)| AnyChannel::new(*name, FlatSamples::F32(samples(k))));
    let channels = AnyChannels::sort(channels.collect::<SmallVec<[_; 4]>>());
    let mut attributes =
        if name.is_empty() { LayerAttributes::default() } else { LayerAttributes::named(name) };
    change(&mut attributes);
    let encoding =
        Encoding { compression: Compression::ZIP1, blocks: Blocks::ScanLines, ..Encoding::SMALL_LOSSLESS };
    exr::prelude::Layer::new(size, attributes, encoding, channels)
}

fn write(
    parts: Vec<Part>,
    chromaticities: Option<Chromaticities>,
) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    let window = IntegerBounds { position: Vec2(0, 0), size: SIZE };
    let attributes = ImageAttributes { chromaticities, ..ImageAttributes::new(window) };
    Image { attributes, layer_data: SmallVec::<[Part; 2]>::from_vec(parts) }.write().to_file(&path).unwrap();
    (folder, path)
}

fn parse(parts: Vec<Part>) -> std::result::Result<Vec<Rgb>, String> {
    let (_folder, path) = write(parts, None);
    read(&path, &Place::file("sky.exr")).map(|(map, _)| map.texels).map_err(|e| e.to_string())
}

/// The texel at (x, y) of channels number r, g, b.
fn texel(x: usize, y: usize, channels: [usize; 3]) -> Rgb {
    channels.map(|k| (100 * k + x + 10 * y) as f32)
}

fn all(channels: [usize; 3]) -> Vec<Rgb> {
    (0..SIZE.area()).map(|i| texel(i % 8, i / 8, channels)).collect()
}

fn plain(names: &[&str]) -> Part {
    part("", names, SIZE, |_| {})
}

#[test]
fn the_one_picture_of_a_file_is_found_whatever_it_is_called() {
    assert_eq!(parse(vec![plain(&["R", "G", "B"])]).unwrap(), all([0, 1, 2]));
    assert_eq!(parse(vec![plain(&["b", "g", "r", "A"])]).unwrap(), all([2, 1, 0]));
    assert_eq!(
        parse(vec![plain(&[
            "View Layer.Combined.R",
            "View Layer.Combined.G",
            "View Layer.Combined.B",
            "View Layer.Depth.Z"
        ])])
        .unwrap(),
        all([0, 1, 2])
    );
    assert_eq!(parse(vec![plain(&["beauty.red", "beauty.green", "beauty.blue"])]).unwrap(), all([0, 1, 2]));
    // Beside layers, what has no layer's name is the picture.
    assert_eq!(
        parse(vec![plain(&["albedo.R", "albedo.G", "albedo.B", "R", "G", "B"])]).unwrap(),
        all([3, 4, 5])
    );
    assert_eq!(
        parse(vec![part("depth", &["Z"], SIZE, |_| {}), part("rgba", &["A", "R", "G", "B"], SIZE, |_| {})])
            .unwrap(),
        all([1, 2, 3])
    );
    assert_eq!(parse(vec![plain(&["Y"])]).unwrap(), all([0, 0, 0]));
    assert_eq!(parse(vec![plain(&["Y", "R", "G", "B"])]).unwrap(), all([1, 2, 3]));
}

#[test]
fn what_is_no_picture_or_several_is_refused_by_name() {
    let two = &["a.R", "a.G", "a.B", "b.c.R", "b.c.G", "b.c.B"];
    let parts =
        vec![part("left", &["R", "G", "B"], SIZE, |_| {}), part("right", &["R", "G", "B"], SIZE, |_| {})];
    for (parts, expected) in [
        (
            vec![plain(two)],
            "has 2 pictures, in the layers `a`, `b.c`; save the one that is meant as a file of its own",
        ),
        (
            parts,
            "has 2 pictures, in the layers `left`, `right`; save the one that is meant as a file of its own",
        ),
        (
            vec![plain(&["Z", "N.X", "R"])],
            "no layer has R, G and B, its channels are `N.X`, `R`, `Z`; save the picture as plain RGB",
        ),
        (
            vec![plain(&["Y", "RY", "BY"])],
            "its texels are luminance and chroma (Y, RY, BY), this version reads R, G and B; save it as plain RGB",
        ),
        (
            vec![part("", &["R", "G", "B"], SIZE, |a| a.environment_map = Some(EnvironmentMap::Cube))],
            "its envmap attribute is cube, expected latlong; convert it (exrenvmap -l in.exr out.exr)",
        ),
        (
            vec![part("", &["R", "G", "B"], Vec2(3, 3), |a| a.layer_position = Vec2(8, 0))],
            "its data window lies outside its display window, so that nothing is left; save it uncropped",
        ),
    ] {
        assert_eq!(parse(parts).unwrap_err(), format!("sky.exr: {expected}"));
    }
}

#[test]
fn latlong_is_what_a_map_may_call_itself() {
    let latlong =
        part("", &["R", "G", "B"], SIZE, |a| a.environment_map = Some(EnvironmentMap::LatitudeLongitude));
    assert_eq!(parse(vec![latlong]).unwrap(), all([0, 1, 2]));
}

#[test]
fn a_data_window_lies_where_it_says() {
    let windows = [(Vec2(3, 2), Vec2(4, 1)), (Vec2(20, 9), Vec2(-5, -3)), (Vec2(4, 9), Vec2(6, -2))];
    for (blocks, (size, position)) in
        [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 2))].into_iter().flat_map(|b| windows.map(|w| (b, w)))
    {
        let mut part = part("", &["R", "G", "B"], size, |a| a.layer_position = position);
        part.encoding.blocks = blocks;
        let texels = parse(vec![part]).unwrap();
        for (i, found) in texels.iter().enumerate() {
            let [x, y] = [(i % 8) as i32 - position.0, (i / 8) as i32 - position.1];
            let inside = x >= 0 && y >= 0 && (x as usize) < size.0 && (y as usize) < size.1;
            let expected = if inside { texel(x as usize, y as usize, [0, 1, 2]) } else { [0.0; 3] };
            assert_eq!(*found, expected, "{blocks:?} {size:?} at {position:?}, texel {i}");
        }
    }
}

#[test]
fn chromaticities_are_told() {
    let aces = Chromaticities {
        red: Vec2(0.7347, 0.2653),
        green: Vec2(0.0, 1.0),
        blue: Vec2(0.0001, -0.077),
        white: Vec2(0.32168, 0.33767),
    };
    let (_folder, path) = write(vec![plain(&["R", "G", "B"])], Some(aces));
    let primaries = read(&path, &Place::file("sky.exr")).unwrap().1.unwrap();
    assert!(
        (primaries.red[0] - 0.7347).abs() < 1e-6
            && (primaries.blue[1] + 0.077).abs() < 1e-6
            && !primaries.are_rec_709()
    );
}

#[test]
fn deep_files_and_fewer_samples_are_refused_by_name() {
    let (_folder, path) = write(vec![plain(&["R", "G", "B"])], None);
    let whole = std::fs::read(&path).unwrap();
    let message = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read(&path, &Place::file("sky.exr")).unwrap_err().to_string()
    };
    // The flag of deep data, bit 11 of the version.
    let mut deep = whole.clone();
    deep[5] |= 8;
    assert_eq!(
        message(&deep),
        "sky.exr: holds deep data, many samples a texel; flatten it and save it as plain RGB scan lines"
    );
    // The first channel's sampling follows its name, type and flag.
    let at = whole.windows(9).position(|w| w == b"chlist\0\x37\0").unwrap() + 11 + 2 + 4 + 4;
    let mut sampled = whole.clone();
    (sampled[at], sampled[at + 4]) = (2, 2);
    assert_eq!(
        message(&sampled),
        "sky.exr: some of its channels have fewer samples than texels; save it as plain RGB, every channel at full resolution"
    );
    assert_eq!(message(&whole[..60]), "sky.exr: not an OpenEXR picture, or cut short; save it again");
    assert_eq!(
        message(b"hello"),
        "sky.exr: not an OpenEXR picture (invalid: file identifier missing); save it again"
    );
}
