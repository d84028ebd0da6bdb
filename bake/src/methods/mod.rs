//! One folder per method: gather, project, compress, write.

pub mod transfer_images;
