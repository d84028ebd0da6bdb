//! glTF as other programs write it.
