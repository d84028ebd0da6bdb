//! Bundles whose values make no sense, and those too large.
