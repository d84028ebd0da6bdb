use super::*;

fn parse(bytes: &[u8]) -> Result<(EquirectMap, Option<Primaries>)> {
    read(bytes, &Place::file("sky.hdr"))
}

/// A picture with `lines` in its header.
fn picture(lines: &str, resolution: &str, scan_lines: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{lines}\n{resolution}\n").as_bytes(), scan_lines].concat()
}

/// Flat texels of red 0.5, 1, 2, … in the order of the file.
fn doubling(count: u8) -> Vec<u8> {
    (0..count).flat_map(|i| [128, 0, 0, 128 + i]).collect()
}

fn reds(bytes: &[u8]) -> Vec<f32> {
    parse(bytes).unwrap().0.texels.iter().map(|texel| texel[0]).collect()
}

#[test]
fn any_signature_and_any_harmless_header_are_read() {
    let texels = doubling(2);
    let expected = [0.5, 1.0];
    for header in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?AUTOPANO\n\n-Y 1 +X 2\n",
        "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 2\r\n",
        "#?RADIANCE\n# EXPOSURE=7\nSOFTWARE=gegl = good\nFORMAT=\nVIEW= -vtv\n\tEXPOSURE=3\n\n-Y 1 +X 2\n",
        "#?RADIANCE\n\u{fc}ber\nPRIMARIES= .64 .33 .30 .60 .15 .06 .3127 .3290\nGAMMA=1\n\n -Y  1  +X  2 \n",
    ] {
        assert_eq!(reds(&[header.as_bytes(), &texels].concat()), expected, "{header}");
    }
}

#[test]
fn exposures_and_colour_corrections_multiply_and_are_divided_out() {
    let lines = "EXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR= 1 2 0.5\nCOLORCORR=1 1 0.5\n";
    let (map, _) = parse(&picture(lines, "-Y 1 +X 2", &[128, 64, 32, 132, 0, 0, 0, 0])).unwrap();
    // 8, 4 and 2 in the file, over 8·(1, 2, 1/4).
    assert_eq!(map.texels, [[1.0, 0.25, 1.0], [0.0; 3]]);
}

/// Each of the eight orders, with the place of the file's texels in the map below: y points up, and the
/// slower axis stands first.
#[test]
fn all_axis_orders_are_turned_upright() {
    for (resolution, rows) in [
        ("-Y 2 +X 4", [[0, 1, 2, 3], [4, 5, 6, 7]]),
        ("-Y 2 -X 4", [[3, 2, 1, 0], [7, 6, 5, 4]]),
        ("+Y 2 +X 4", [[4, 5, 6, 7], [0, 1, 2, 3]]),
        ("+Y 2 -X 4", [[7, 6, 5, 4], [3, 2, 1, 0]]),
        ("+X 4 -Y 2", [[0, 2, 4, 6], [1, 3, 5, 7]]),
        ("-X 4 -Y 2", [[6, 4, 2, 0], [7, 5, 3, 1]]),
        ("+X 4 +Y 2", [[1, 3, 5, 7], [0, 2, 4, 6]]),
        ("-X 4 +Y 2", [[7, 5, 3, 1], [6, 4, 2, 0]]),
    ] {
        let bytes = picture("", resolution, &doubling(8));
        let expected: Vec<f32> = rows.as_flattened().iter().map(|i| 0.5 * f32::exp2(*i as f32)).collect();
        assert_eq!(reds(&bytes), expected, "{resolution}");
        let map = parse(&bytes).unwrap().0;
        assert_eq!((map.width, map.height), (4, 2));
    }
}

#[test]
fn both_run_length_encodings_are_read() {
    // Newer: each channel of a scan line by itself. 16 texels: red a run, green different ones, blue and
    // exponents runs.
    let mut line = vec![2, 2, 0, 16, 128 + 16, 128, 16];
    line.extend((0..16).map(|i| 8 * i));
    line.extend([128 + 10, 0, 128 + 6, 64, 128 + 16, 129]);
    let (map, _) = parse(&picture("", "-Y 8 +X 16", &line.repeat(8))).unwrap();
    let expected: Vec<Rgb> =
        (0..16u8).map(|i| [1.0, f32::from(i) / 16.0, if i < 10 { 0.0 } else { 0.5 }]).collect();
    assert_eq!(map.texels, expected.repeat(8));
    // Older: one texel and 1 + 1·256 repeats, in a scan line of 260, with two more texels after it.
    let mut line = vec![128, 0, 0, 129, 1, 1, 1, 1, 1, 1, 1, 1];
    line.extend([128, 0, 0, 130, 128, 0, 0, 131]);
    let map = reds(&picture("", "-Y 130 +X 260", &line.repeat(130)));
    assert_eq!(map[..260], [vec![1.0; 258], vec![2.0, 4.0]].concat()[..]);
    assert_eq!(map[129 * 260..], map[..260]);
}

#[test]
fn what_cannot_be_read_says_what_it_is() {
    let flat = doubling(2);
    for (bytes, expected) in [
        (b"hello".to_vec(), "not a Radiance map: it does not begin with `#?RADIANCE`, `#?RGBE` or the like"),
        (
            b"#?RADIANCE\nGAMMA=1\n".to_vec(),
            "not a Radiance map: the empty line that ends its header is missing; save the picture again",
        ),
        (
            b"#?RADIANCE\n\n".to_vec(),
            "not a Radiance map: the line with its resolution is missing; save the picture again",
        ),
        (
            picture("", "-Y 1 +Z 2", &flat),
            "not a Radiance map: `-Y 1 +Z 2` where a resolution such as `-Y 512 +X 1024` is expected; save the picture again",
        ),
        (
            picture("", "-Y 1 -Y 2", &flat),
            "not a Radiance map: `-Y 1 -Y 2` where a resolution such as `-Y 512 +X 1024` is expected; save the picture again",
        ),
        (
            picture("", "-Y 99999 +X 199998", &[]),
            "199998 × 99999 texels, expected 1 to 33554432 in all; scale it down",
        ),
        (picture("", "-Y 2 +X 4", &flat), "scan line 1 of 2 is cut short; save the picture again"),
        (
            picture("", "-Y 1 +X 2", &[1, 1, 1, 2]),
            "scan line 1 of 1 repeats a texel before there is one; save the picture again",
        ),
        (
            picture("", "-Y 1 +X 2", &[9, 9, 9, 9, 1, 1, 1, 2]),
            "scan line 1 of 1 repeats a texel 2 times where 1 are left; save the picture again",
        ),
        (
            picture("", "-Y 4 +X 8", &[2, 2, 0, 9]),
            "scan line 1 of 4 has 9 texels, 8 are expected; save the picture again",
        ),
        (
            picture("", "-Y 4 +X 8", &[2, 2, 0, 8, 128 + 9, 0]),
            "scan line 1 of 4 has a run of 9 texels where 1 to 8 are expected; save the picture again",
        ),
        (
            picture("FORMAT=32-bit_rle_xyze\n", "-Y 1 +X 2", &flat),
            "its texels are CIE XYZ (FORMAT=32-bit_rle_xyze), this version reads RGB; convert it (ra_xyze -r map.hdr > rgb.hdr)",
        ),
        (
            picture("EXPOSURE=0\n", "-Y 1 +X 2", &flat),
            "EXPOSURE=0 in its header: a number above 0 is expected; save the picture again",
        ),
        (
            picture("COLORCORR=1 2\n", "-Y 1 +X 2", &flat),
            "COLORCORR=1 2 in its header: three numbers above 0 are expected; save the picture again",
        ),
        (
            picture("PRIMARIES=1 2\n", "-Y 1 +X 2", &flat),
            "PRIMARIES=1 2 in its header: eight numbers are expected, x and y of red, green, blue and white; save the picture again",
        ),
    ] {
        assert_eq!(parse(&bytes).unwrap_err().to_string(), format!("sky.hdr: {expected}"));
    }
}

#[test]
fn primaries_are_told() {
    let lines = "PRIMARIES= .708 .292 .170 .797 .131 .046 .3127 .3290\n";
    let (_, primaries) = parse(&picture(lines, "-Y 1 +X 2", &doubling(2))).unwrap();
    let expected = Primaries {
        red: [0.708, 0.292],
        green: [0.170, 0.797],
        blue: [0.131, 0.046],
        white: [0.3127, 0.3290],
    };
    assert_eq!(primaries, Some(expected));
}
