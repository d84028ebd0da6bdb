//! A stage of which every piece is of some receivers.

use crate::error::Result;
use crate::stage::Stage;
use crate::trace::receivers::Receiver;

/// Receivers of one piece.
pub const PIECE: usize = 64;

/// Some receivers a piece.
pub struct Pieces<'a, F> {
    /// All of them.
    pub receivers: &'a [Receiver],
    /// See [`Stage::name`].
    pub name: String,
    /// See [`Stage::label`].
    pub label: &'static str,
    /// See [`Stage::key`].
    pub key: u128,
    /// Makes a piece.
    pub bytes: F,
}

impl<F: Fn(&[Receiver]) -> Result<Vec<u8>> + Sync> Stage for Pieces<'_, F> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn label(&self) -> Option<&'static str> {
        Some(self.label)
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.receivers.len().div_ceil(PIECE) as u32
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        (self.bytes)(receivers_of(self.receivers, number as usize))
    }

    fn keeps_log(&self) -> bool {
        true
    }
}

/// The receivers of piece number `piece`.
pub fn receivers_of(receivers: &[Receiver], piece: usize) -> &[Receiver] {
    let first = (piece * PIECE).min(receivers.len());
    &receivers[first..(first + PIECE).min(receivers.len())]
}
