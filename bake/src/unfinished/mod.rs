//! The folder within a bundle that holds what is not finished yet: its lock, the logs and new files in it.

mod lock;
pub(crate) mod names;
pub(crate) mod work;

pub use lock::FolderLock;
pub use work::{Leftover, Work, holds_work};
