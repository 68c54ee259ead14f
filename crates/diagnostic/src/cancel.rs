//! The one way to ask work to stop.

use std::sync::atomic::{AtomicBool, Ordering};

/// Asks work to stop; looked at often, from any thread. Once asked it stays asked.
///
/// ```
/// let cancel = diagnostic::Cancel::default();
/// assert!(!cancel.is_cancelled());
/// cancel.cancel();
/// assert!(cancel.is_cancelled());
/// ```
#[derive(Debug, Default)]
pub struct Cancel(AtomicBool);

impl Cancel {
    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`Cancel::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
