//! Looks now and then whether the bundle on show was baked again.

use crate::error::{Error, Result};
use crate::stream::Edition;
use std::convert::Infallible;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// From one look to the next.
const PAUSE: Duration = Duration::from_secs(1);

/// Watches until it is dropped.
pub struct Watch {
    /// Nothing is ever sent: its end is the message.
    _stop: Sender<Infallible>,
}

impl Watch {
    /// Watches the place of `edition`, and tells by `tell` whenever another bake has come there (`true`), or
    /// the same again.
    ///
    /// # Errors
    /// If there can be no thread.
    pub fn start(edition: Edition, tell: impl Fn(bool) + Send + 'static) -> Result<Self> {
        let (stop, stopped) = channel::<Infallible>();
        let watch = move || {
            let (mut seen, mut replaced) = (None, false);
            while stopped.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                // While it is away, a bake is putting files in place.
                let stamp = edition.stamp();
                if stamp.is_none() || stamp == seen {
                    continue;
                }
                seen = stamp;
                let was = std::mem::replace(&mut replaced, edition.is_replaced());
                if was != replaced {
                    tell(replaced);
                }
            }
        };
        std::thread::Builder::new()
            .name("watch".to_owned())
            .spawn(watch)
            .map_err(|e| Error::Failed(format!("cannot start the thread that watches the bundle: {e}")))?;
        Ok(Self { _stop: stop })
    }
}
