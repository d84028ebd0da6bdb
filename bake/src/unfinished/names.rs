//! What the folder of unfinished work and the files that are not logs are called.

/// The folder, within that of the bundle.
pub(crate) const UNFINISHED: &str = "unfinished";
/// The file that says who holds the lock.
pub(crate) const LOCK: &str = "lock";
/// The file that says what a shard of a bake was asked for.
pub(crate) const SHARD: &str = "shard.json";
