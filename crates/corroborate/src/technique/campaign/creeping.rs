//! Held things that moved in the fingers that held them, over all episodes: a gap between what is described and what is
//! simulated.

use super::record::EpisodeRecord;
use evidence::DescriptionGap;
use std::collections::BTreeMap;
use testbench::Creep;

/// How often each held thing moved in whose fingers, and the worst of it.
#[derive(Clone, Debug, Default)]
pub struct CreepTally {
    episodes: u64,
    /// By object, holder and whether it slid: how many episodes, the number of the worst, and what it was.
    found: BTreeMap<(String, String, bool), (u64, u64, Creep)>,
}

impl CreepTally {
    pub(super) fn add(&mut self, record: &EpisodeRecord) {
        self.episodes += 1;
        for creep in &record.crept {
            let key = (creep.object.clone(), creep.holder.clone(), creep.slid);
            let first = || (0, record.number, creep.clone());
            let (count, worst, known) = self.found.entry(key).or_insert_with(first);
            *count += 1;
            if creep.moved_m > known.moved_m {
                (*worst, *known) = (record.number, creep.clone());
            }
        }
    }

    /// As gaps of the scene in `file`.
    #[must_use]
    pub fn gaps(&self, file: &str) -> Vec<DescriptionGap> {
        let gap = |(count, worst, creep): &(u64, u64, Creep)| DescriptionGap {
            file: file.to_owned(),
            line: None,
            column: None,
            element: "grip".to_owned(),
            what: format!(
                "in {count} of {} episodes a held thing moved in the fingers; in episode {worst} {creep}",
                self.episodes
            ),
            effect: "contact".to_owned(),
            consequence: creep.remedy.clone(),
        };
        self.found.values().map(gap).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_of_all_episodes_is_told_with_its_number_and_its_remedy() {
        let creep = |moved_m: f64| Creep {
            object: "part".to_owned(),
            holder: "arm".to_owned(),
            moved_m,
            over_secs: 2.0,
            load_over_grip: 0.2,
            friction_used: 0.4,
            slid: false,
            remedy: "set simulation.mujoco.no_slip_iterations = 10".to_owned(),
        };
        let record = |number: u64, crept: Vec<Creep>| EpisodeRecord {
            number,
            seed: 1,
            end: "complete".to_owned(),
            simulated_secs: None,
            recording: None,
            judged: Vec::new(),
            forms: Vec::new(),
            crept,
        };
        let mut tally = CreepTally::default();
        tally.add(&record(1, vec![creep(0.002)]));
        tally.add(&record(2, vec![creep(0.004)]));
        tally.add(&record(3, Vec::new()));
        let gaps = tally.gaps("scene.toml");
        assert_eq!(gaps.len(), 1);
        let shown = gaps[0].to_string();
        for words in [
            "scene.toml",
            "2 of 3 episodes",
            "in episode 2",
            "4.0 mm",
            "no_slip_iterations",
        ] {
            assert!(shown.contains(words), "{words}: {shown}");
        }
    }
}
