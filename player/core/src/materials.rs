//! Which material is seen through a pixel.

/// No material at all.
const NOTHING: u16 = u16::MAX;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen<'a> {
    /// A material that may be set.
    Material(&'a str),
    /// Something that does not vary.
    Fixed,
    /// Nothing.
    Nothing,
}

/// The material of every pixel of a film.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaterialMap {
    size: [u32; 2],
    materials: Vec<String>,
    /// By pixel: index of the material, their number for what is fixed, or [`NOTHING`].
    shown: Vec<u16>,
}

impl MaterialMap {
    /// Of a film of `size` pixels, nowhere of which any of these `materials` is seen yet. There are fewer
    /// than 65535.
    pub(crate) fn new(size: [u32; 2], materials: Vec<String>) -> Self {
        let shown = vec![NOTHING; size[0] as usize * size[1] as usize];
        Self { size, materials, shown }
    }

    /// Lets a pixel, by its number row by row, show material number `index`, or something fixed where there
    /// is none of this number.
    pub(crate) fn set(&mut self, pixel: usize, index: u16) {
        let fixed = self.materials.len() as u16;
        self.shown.get_mut(pixel).into_iter().for_each(|shown| *shown = index.min(fixed));
    }

    /// Film size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What the pixel in column x and row y shows; outside the film nothing.
    pub fn at(&self, [x, y]: [u32; 2]) -> Seen<'_> {
        if x < self.size[0] && y < self.size[1] {
            self.of_pixel(y as usize * self.size[0] as usize + x as usize)
        } else {
            Seen::Nothing
        }
    }

    /// What every pixel shows, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = Seen<'_>> {
        (0..self.shown.len()).map(|pixel| self.of_pixel(pixel))
    }

    fn of_pixel(&self, pixel: usize) -> Seen<'_> {
        match self.shown.get(pixel).copied().unwrap_or(NOTHING) {
            NOTHING => Seen::Nothing,
            index => self.materials.get(usize::from(index)).map_or(Seen::Fixed, |name| Seen::Material(name)),
        }
    }
}
