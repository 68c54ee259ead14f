//! Which domains of DDS are in use: episodes on several threads must not hear each other.

use std::collections::BTreeSet;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// The domains in use.
#[derive(Clone, Debug, Default)]
pub struct Domains(Arc<(Mutex<BTreeSet<u16>>, Condvar)>);

/// A domain that an episode has to itself until this is dropped.
#[derive(Debug)]
pub struct Domain {
    pub number: u16,
    all: Domains,
}

impl Domains {
    /// The first free one of `wanted`; waits until one is free. `None` if none is wanted.
    pub fn take(&self, wanted: &[u16]) -> Option<Domain> {
        let (used, freed) = &*self.0;
        // A panic elsewhere leaves a set of numbers, not broken memory.
        let mut used = used.lock().unwrap_or_else(PoisonError::into_inner);
        while !wanted.is_empty() {
            if let Some(number) = wanted.iter().find(|number| !used.contains(number)) {
                used.insert(*number);
                let (number, all) = (*number, self.clone());
                return Some(Domain { number, all });
            }
            used = freed.wait(used).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        let (used, freed) = &*self.all.0;
        used.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .remove(&self.number);
        freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_domain_is_had_by_one_at_a_time() {
        let domains = Domains::default();
        assert!(domains.take(&[]).is_none());
        let first = domains.take(&[7, 8]).expect("free");
        let second = domains.take(&[7, 8]).expect("free");
        assert_eq!((first.number, second.number), (7, 8));
        let waits = std::thread::spawn({
            let domains = domains.clone();
            move || domains.take(&[7, 8]).map(|domain| domain.number)
        });
        drop(second);
        assert_eq!(waits.join().expect("it ends"), Some(8));
        assert_eq!(domains.take(&[8]).expect("free again").number, 8);
        drop(first);
    }
}
