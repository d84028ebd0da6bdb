//! Who goes first on a machine whose GPU is a program on the CPU: the window, then its picture.

/// By how much what draws the picture is nicer than the window.
#[cfg(target_os = "linux")]
const NICER: i32 = 5;

/// Lets this thread, and those that it starts from now on, give way to others of the process: a hand on a
/// slider waits for the window, and not for the picture. On systems where threads have no priority of their
/// own nothing changes.
pub fn give_way() {
    // Who may not be nice draws as fast as before.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::nice(NICER);
}
