//! A slot that holds the latest value. Neither side ever waits for the other.

use std::sync::{Mutex, TryLockError};

/// A slot for the latest value of a small type.
///
/// The session loop writes, and the panel's threads read. A reader holds the lock for one copy. A writer that meets a
/// reader does not wait: its value is dropped, and the next one is at most a round later.
#[derive(Debug)]
pub struct Latest<T>(Mutex<T>);

impl<T: Copy> Latest<T> {
    /// A slot with its first value.
    #[must_use]
    pub const fn new(value: T) -> Self {
        Self(Mutex::new(value))
    }

    /// Writes a value, unless the slot is just being read. Returns whether it was written.
    pub fn put(&self, value: T) -> bool {
        match self.0.try_lock() {
            Ok(mut slot) => *slot = value,
            Err(TryLockError::Poisoned(broken)) => *broken.into_inner() = value,
            Err(TryLockError::WouldBlock) => return false,
        }
        true
    }

    /// Keeps everyone from the slot, as a thread does that stalls.
    #[cfg(test)]
    pub(crate) fn hold(&self) -> std::sync::MutexGuard<'_, T> {
        self.0.lock().expect("nobody failed")
    }

    /// A copy of the value, unless the slot is just being written.
    pub fn get(&self) -> Option<T> {
        match self.0.try_lock() {
            Ok(slot) => Some(*slot),
            Err(TryLockError::Poisoned(broken)) => Some(*broken.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_value_stays_and_a_held_slot_stops_nobody() {
        let slot = Latest::new(1);
        assert!(slot.put(2) && slot.put(3));
        assert_eq!(slot.get(), Some(3));
        let held = slot.hold();
        assert!(!slot.put(4) && slot.get().is_none());
        drop(held);
        assert_eq!(slot.get(), Some(3));
    }
}
