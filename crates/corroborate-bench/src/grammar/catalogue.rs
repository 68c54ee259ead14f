//! Which generated studies there are: so many of each fault in each family, each with a number of its own.

use super::draft::Draft;
use super::family::Kind;
use super::files::{File, files};
use super::plant::{Plant, Planted, plant};

/// A generated study.
#[derive(Clone, Debug)]
pub struct Generated {
    /// Its name, which says family and number, not the fault.
    pub name: String,
    /// The study.
    pub draft: Draft,
    /// What was planted.
    pub planted: Planted,
}

impl Generated {
    /// Its files.
    #[must_use]
    pub fn files(&self) -> Vec<File> {
        files(&self.draft)
    }
}

/// What is generated.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// From which all is drawn.
    pub seed: u64,
    /// Studies of each fault in each family.
    pub each: usize,
    /// Studies without a fault for each of these.
    pub sound: usize,
    /// Whether families that are held out are among them.
    pub held_out: bool,
    /// This family alone.
    pub only: Option<Kind>,
    /// This fault alone.
    pub fault: Option<Plant>,
    /// Each second fault in one family of those there are, in turn; nothing in each second family.
    pub is_thin: bool,
}

/// Whether a thin catalogue has this fault in this family.
fn is_in_thin(family: Kind, fault: Plant) -> bool {
    let (family, fault_place) = (family as usize, fault as usize);
    match fault {
        Plant::Nothing => family.is_multiple_of(2),
        _ => {
            let turn = fault_place / 2 + family;
            fault_place.is_multiple_of(2) && turn.is_multiple_of(Kind::ALL.len())
        }
    }
}

/// A study that had no place for its fault is drawn anew under another number, so many times.
const DRAWS: u64 = 20;

impl Catalogue {
    /// All studies in their order; what one is does not depend on which others there are.
    #[must_use]
    pub fn studies(&self) -> Vec<Generated> {
        let families = Kind::ALL
            .into_iter()
            .filter(|family| self.held_out || !family.is_held_out());
        let families = families.filter(|family| self.only.is_none_or(|only| only == *family));
        let mut all = Vec::new();
        for family in families {
            for fault in Plant::ALL
                .into_iter()
                .filter(|it| self.fault.is_none_or(|only| only == *it))
            {
                if self.is_thin && !is_in_thin(family, fault) {
                    continue;
                }
                let count = if fault == Plant::Nothing {
                    self.each * self.sound
                } else {
                    self.each
                };
                all.extend((0..count).filter_map(|place| self.study(family, fault, place)));
            }
        }
        all
    }

    fn study(&self, family: Kind, fault: Plant, place: usize) -> Option<Generated> {
        let first = ((family as u64) << 32) + ((fault as u64) << 24) + ((place as u64) << 8);
        let study = |number: u64| {
            let mut draft = Draft::draw(family, self.seed, number);
            let planted = plant(fault, &mut draft)?;
            Some(Generated {
                name: format!("{}-{:02}{place:03}", family.name(), shuffled(fault)),
                draft,
                planted,
            })
        };
        (first..first + DRAWS).find_map(study)
    }
}

/// Folders do not tell the fault to who reads their names in passing.
fn shuffled(fault: Plant) -> usize {
    (fault as usize * 7 + 3) % Plant::ALL.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn catalogue(held_out: bool) -> Catalogue {
        Catalogue {
            seed: 1,
            each: 1,
            sound: 1,
            held_out,
            only: None,
            fault: None,
            is_thin: false,
        }
    }

    #[test]
    fn a_study_is_the_same_whichever_others_there_are() {
        let all = catalogue(true).studies();
        let some = catalogue(false).studies();
        for study in &some {
            let same = all
                .iter()
                .find(|other| other.name == study.name)
                .expect("it is among all");
            assert_eq!(same.files(), study.files());
            assert!(!study.draft.family.is_held_out());
        }
        assert!(all.iter().any(|study| study.draft.family.is_held_out()));
    }

    #[test]
    fn every_fault_is_planted_in_some_family_and_changes_a_file() {
        for fault in Plant::ALL
            .into_iter()
            .filter(|fault| *fault != Plant::Nothing)
        {
            let only = Catalogue {
                fault: Some(fault),
                ..catalogue(false)
            };
            let studies = only.studies();
            assert!(!studies.is_empty(), "{fault:?}");
            for study in studies {
                assert!(!study.planted.culprits.is_empty(), "{fault:?}");
                assert!(
                    (0.0..=1.0 + 1e-9).contains(&study.planted.power),
                    "{fault:?} {}",
                    study.planted.power
                );
            }
        }
    }
}
