//! What the folder of unfinished work and the files in it are called.

/// The folder, within that of the bundle.
pub(crate) const UNFINISHED: &str = "unfinished";
/// The file that says who holds the lock.
pub(crate) const LOCK: &str = "lock";
/// The file that says what a shard of a bake was asked for.
pub(crate) const SHARD: &str = "shard.json";
/// What names of logs end with.
const LOG: &str = ".log";

/// Name of the log of a stage.
pub(crate) fn log_name(stage: &str) -> String {
    format!("{stage}{LOG}")
}

/// The stage whose log is called so; `None` if that is no log's name.
pub(crate) fn stage_of(log: &str) -> Option<&str> {
    log.strip_suffix(LOG)
}
