//! The pictures of docs/STABILITY.md.
