//! Environment maps as other programs write them.
