//! Radiance pictures (`.hdr`, `.pic`), as the reference manual's "file formats" describes them: a header of
//! lines, the resolution with its axis order, and scan lines of RGBE texels, flat or run-length encoded in
//! either of two ways.
//!
//! What programs multiplied into the picture, `EXPOSURE` and `COLORCORR`, each of them cumulative, is divided
//! out again: texels are the radiance that was. A picture without `PRIMARIES` is taken for Rec. 709, which is
//! what nearly all programs mean by it.

use super::expect_equirect;
use super::primaries::Primaries;
use crate::basis::EquirectMap;
use crate::state::Rgb;
use crate::{Error, Place, Result};
use std::io::{BufRead, Read};

/// Longest line and most bytes of a header.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// Widths that have the newer run-length encoding.
const RUN_LENGTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

type Rgbe = [u8; 4];

/// Reads a picture, and the primaries that it names.
pub(super) fn read(input: impl BufRead, place: &Place) -> Result<(EquirectMap, Option<Primaries>)> {
    let mut lines = Lines { input: input.take(MAX_HEADER_BYTES), place };
    let header = Header::read(&mut lines)?;
    let order = Order::parse(&lines.next("the line with its resolution")?, place)?;
    expect_equirect(order.width.into(), order.height.into(), place)?;
    let mut input = lines.input;
    input.set_limit(u64::MAX);
    let (count, length) = order.scan_lines();
    let (mut texels, mut line) = (Vec::new(), Vec::with_capacity(length));
    for number in 0..count {
        line.clear();
        read_scan_line(&mut input, length, &mut line).map_err(|reason| {
            Error::invalid(
                place,
                format!("scan line {} of {count} {reason}; save the picture again", number + 1),
            )
        })?;
        texels.extend(line.iter().map(|texel| header.radiance(*texel)));
    }
    Ok((
        EquirectMap { width: order.width, height: order.height, texels: order.upright(texels) },
        header.primaries,
    ))
}

/// Lines of text before the picture.
struct Lines<'a, R> {
    input: std::io::Take<R>,
    place: &'a Place,
}

impl<R: BufRead> Lines<'_, R> {
    /// The next line without its end; `what` was expected there.
    fn next(&mut self, what: &str) -> Result<String> {
        let refuse = || {
            Error::invalid(
                self.place,
                format!("not a Radiance map: {what} is missing; save the picture again"),
            )
        };
        self.until_end()?.ok_or_else(refuse)
    }

    /// The next line without its end, if it has one.
    fn until_end(&mut self) -> Result<Option<String>> {
        let mut bytes = Vec::new();
        self.input.read_until(b'\n', &mut bytes).map_err(|e| Error::io(self.place, e))?;
        let whole = bytes.pop() == Some(b'\n');
        Ok(whole.then(|| String::from_utf8_lossy(&bytes).trim_end_matches('\r').to_owned()))
    }
}

/// What of a header matters.
struct Header {
    /// What the texels were multiplied with.
    factor: [f64; 3],
    primaries: Option<Primaries>,
}

impl Header {
    fn read<R: BufRead>(lines: &mut Lines<'_, R>) -> Result<Self> {
        let signature = lines.until_end()?.filter(|line| line.starts_with("#?"));
        if signature.is_none() {
            return Err(Error::invalid(
                lines.place,
                "not a Radiance map: it does not begin with `#?RADIANCE`, `#?RGBE` or the like",
            ));
        }
        let mut header = Self { factor: [1.0; 3], primaries: None };
        loop {
            let line = lines.next("the empty line that ends its header")?;
            if line.is_empty() {
                return Ok(header);
            }
            // Indented lines tell of the pictures that this one was made from.
            if let Some((name, value)) = line.split_once('=').filter(|_| !line.starts_with([' ', '\t', '#']))
            {
                header.set(name.trim_end(), value.trim(), lines.place)?;
            }
        }
    }

    fn set(&mut self, name: &str, value: &str, place: &Place) -> Result<()> {
        let refuse = |what: &str| {
            Err(Error::invalid(
                place,
                format!("{name}={value} in its header: {what}; save the picture again"),
            ))
        };
        let numbers: Option<Vec<f64>> =
            value.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let factors = numbers.as_ref().filter(|numbers| numbers.iter().all(|x| *x > 0.0)).map(Vec::as_slice);
        match (name, factors, numbers.as_deref()) {
            ("FORMAT", ..) if value.is_empty() || value == "32-bit_rle_rgbe" => {}
            ("FORMAT", ..) if value == "32-bit_rle_xyze" => {
                let reason = "its texels are CIE XYZ (FORMAT=32-bit_rle_xyze), this version reads RGB; convert it (ra_xyze -r map.hdr > rgb.hdr)";
                return Err(Error::unsupported(place, reason));
            }
            ("FORMAT", ..) => {
                return refuse("a format that no Radiance picture has, 32-bit_rle_rgbe is expected");
            }
            ("EXPOSURE", Some(&[all]), _) => self.factor = self.factor.map(|f| f * all),
            ("COLORCORR", Some(&[r, g, b]), _) => {
                self.factor = [self.factor[0] * r, self.factor[1] * g, self.factor[2] * b]
            }
            ("PRIMARIES", _, Some(&[rx, ry, gx, gy, bx, by, wx, wy])) => {
                self.primaries =
                    Some(Primaries { red: [rx, ry], green: [gx, gy], blue: [bx, by], white: [wx, wy] });
            }
            ("EXPOSURE", ..) => return refuse("a number above 0 is expected"),
            ("COLORCORR", ..) => return refuse("three numbers above 0 are expected"),
            ("PRIMARIES", ..) => {
                return refuse("eight numbers are expected, x and y of red, green, blue and white");
            }
            _ => {}
        }
        Ok(())
    }

    /// (mantissa / 256) · 2^(exponent − 128), and what was multiplied with it divided out.
    fn radiance(&self, [r, g, b, exponent]: Rgbe) -> Rgb {
        let unit = if exponent == 0 { 0.0 } else { (f64::from(exponent) - 136.0).exp2() };
        let [r, g, b] = [r, g, b].map(|mantissa| f64::from(mantissa) * unit);
        [(r / self.factor[0]) as f32, (g / self.factor[1]) as f32, (b / self.factor[2]) as f32]
    }
}

/// How texels follow each other in the file.
struct Order {
    width: u32,
    height: u32,
    /// Scan lines are columns.
    by_columns: bool,
    from_right: bool,
    from_bottom: bool,
}

impl Order {
    /// A line such as `-Y 512 +X 1024`: the slower axis first, each with the way it runs; y points up.
    fn parse(line: &str, place: &Place) -> Result<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let parsed = match words[..] {
            [slow, m, fast, n] => {
                m.parse().ok().zip(n.parse().ok()).and_then(|(m, n)| Self::of([(slow, m), (fast, n)]))
            }
            _ => None,
        };
        parsed.ok_or_else(|| {
            let reason =
                format!("not a Radiance map: `{line}` where a resolution such as `-Y 512 +X 1024` is expected; save the picture again");
            Error::invalid(place, reason)
        })
    }

    fn of(axes: [(&str, u32); 2]) -> Option<Self> {
        let by_columns = axes[0].0.ends_with('X');
        let [(y, height), (x, width)] = if by_columns { [axes[1], axes[0]] } else { axes };
        let legal = ["-Y", "+Y"].contains(&y) && ["-X", "+X"].contains(&x);
        legal.then(|| Self { width, height, by_columns, from_right: x == "-X", from_bottom: y == "+Y" })
    }

    /// Number and length of scan lines.
    fn scan_lines(&self) -> (usize, usize) {
        let (width, height) = (self.width as usize, self.height as usize);
        if self.by_columns { (width, height) } else { (height, width) }
    }

    /// Texels in the order of the file, row by row from the top left.
    fn upright(&self, texels: Vec<Rgb>) -> Vec<Rgb> {
        if !(self.by_columns || self.from_right || self.from_bottom) {
            return texels;
        }
        let (width, height) = (self.width as usize, self.height as usize);
        let at = |row: usize, column: usize| {
            let y = if self.from_bottom { height - 1 - row } else { row };
            let x = if self.from_right { width - 1 - column } else { column };
            texels[if self.by_columns { x * height + y } else { y * width + x }]
        };
        (0..height)
            .flat_map(|row| (0..width).map(move |column| (row, column)))
            .map(|(row, column)| at(row, column))
            .collect()
    }
}

/// Why a scan line could not be read, as the end of a sentence that begins with the scan line.
type Fault = String;

/// Reads `length` texels into `line`, which is empty.
fn read_scan_line(
    input: &mut impl Read,
    length: usize,
    line: &mut Vec<Rgbe>,
) -> std::result::Result<(), Fault> {
    let first: Rgbe = bytes(input)?;
    match first {
        [2, 2, high @ 0..128, low] if RUN_LENGTHS.contains(&length) => {
            let given = usize::from(high) << 8 | usize::from(low);
            if given != length {
                return Err(format!("has {given} texels, {length} are expected"));
            }
            line.resize(length, [0; 4]);
            (0..4).try_for_each(|channel| read_runs(input, line, channel))
        }
        _ => read_repeats(input, first, length, line),
    }
}

/// One channel of the newer encoding: runs of up to 127 equal bytes, and up to 128 different ones.
fn read_runs(input: &mut impl Read, line: &mut [Rgbe], channel: usize) -> std::result::Result<(), Fault> {
    let mut rest = line;
    while !rest.is_empty() {
        let [code] = bytes(input)?;
        let (count, repeated) = if code > 128 { (code - 128, true) } else { (code, false) };
        let count = usize::from(count);
        if count == 0 || count > rest.len() {
            return Err(format!("has a run of {count} texels where 1 to {} are expected", rest.len()));
        }
        let (run, after) = rest.split_at_mut(count);
        let mut value = [0];
        for (index, texel) in run.iter_mut().enumerate() {
            if index == 0 || !repeated {
                value = bytes(input)?;
            }
            texel[channel] = value[0];
        }
        rest = after;
    }
    Ok(())
}

/// The older encoding and flat texels: (1, 1, 1, n) repeats the texel before it n times; several of them in a
/// row are digits of n, the lowest first.
fn read_repeats(
    input: &mut impl Read,
    first: Rgbe,
    length: usize,
    line: &mut Vec<Rgbe>,
) -> std::result::Result<(), Fault> {
    let (mut texel, mut shift) = (first, 0);
    loop {
        if let [1, 1, 1, digit] = texel {
            let count = if shift < 32 { usize::from(digit) << shift } else { 0 };
            let Some(last) = line.last().copied() else {
                return Err("repeats a texel before there is one".to_owned());
            };
            if count > length - line.len() {
                return Err(format!("repeats a texel {count} times where {} are left", length - line.len()));
            }
            line.resize(line.len() + count, last);
            shift += 8;
        } else {
            line.push(texel);
            shift = 0;
        }
        if line.len() == length {
            return Ok(());
        }
        texel = bytes(input)?;
    }
}

fn bytes<const N: usize>(input: &mut impl Read) -> std::result::Result<[u8; N], Fault> {
    let mut bytes = [0; N];
    let reason = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => "is cut short".to_owned(),
        _ => format!("cannot be read ({e})"),
    };
    input.read_exact(&mut bytes).map_err(reason)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
