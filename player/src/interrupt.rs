//! The wish to stop, from outside: set by a signal handler, seen by whoever works or waits.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Whether the user asked to stop, and whom to wake then.
#[derive(Default)]
pub struct Interrupt {
    raised: AtomicBool,
    wake: Mutex<Option<Box<dyn Fn() + Send>>>,
}

impl Interrupt {
    /// Nobody has asked yet.
    pub const fn new() -> Self {
        Self { raised: AtomicBool::new(false), wake: Mutex::new(None) }
    }

    /// Asks to stop. Returns whether that had been asked before.
    pub fn raise(&self) -> bool {
        let before = self.raised.swap(true, Ordering::Relaxed);
        if let Some(wake) = &*self.wake.lock().unwrap_or_else(PoisonError::into_inner) {
            wake();
        }
        before
    }

    /// Whether somebody asked to stop.
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// What to call when somebody asks, for those who sleep meanwhile. It replaces what was given before.
    pub fn on_raise(&self, wake: impl Fn() + Send + 'static) {
        *self.wake.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(wake));
    }
}
