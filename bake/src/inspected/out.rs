//! The folder that an export goes into.

use crate::exr_file::write_exr;
use crate::output::create_folder;
use relume_formats::container::replace_file;
use relume_formats::{Error, Place, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Writes files into one folder, each atomically, and remembers them.
pub struct Out {
    folder: PathBuf,
    written: Vec<PathBuf>,
}

impl Out {
    /// Makes the folder if it is not there.
    ///
    /// # Errors
    /// Those of [`create_folder`].
    pub fn new(folder: &Path) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.to_path_buf(), written: Vec::new() })
    }

    /// Every file written, in order.
    pub fn written(self) -> Vec<PathBuf> {
        self.written
    }

    /// A file of these bytes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(name);
        replace_file(&path, bytes)?;
        self.written.push(path);
        Ok(())
    }

    /// A value as JSON.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn json(&mut self, name: &str, value: &impl Serialize) -> Result<()> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|e| Error::invalid(&Place::file(self.folder.join(name)), e.to_string()))?;
        self.bytes(name, (text + "\n").as_bytes())
    }

    /// A row-major array; `values` must give as many as `shape` says.
    ///
    /// # Errors
    /// If it cannot be written, or `values` give fewer or more.
    pub fn npy<T: npyz::AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        use npyz::WriterBuilder as _;
        let shape: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
        let mut bytes = Vec::new();
        let write = || {
            let mut writer =
                npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
            writer.extend(values)?;
            writer.finish()
        };
        write().map_err(|e| Error::output(&Place::file(self.folder.join(name)), e))?;
        self.bytes(name, &bytes)
    }

    /// An image of named planes, row by row from the top.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn exr(&mut self, name: &str, [width, height]: [u32; 2], channels: &[(&str, &[f32])]) -> Result<()> {
        let path = self.folder.join(name);
        write_exr(&path, width as usize, height as usize, channels)?;
        self.written.push(path);
        Ok(())
    }
}

/// `name` as part of a file name: other characters than letters, digits, `-` and `_` become `_`, and it is
/// cut at 60.
pub fn file_name_part(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    name.chars().take(60).map(plain).collect()
}
