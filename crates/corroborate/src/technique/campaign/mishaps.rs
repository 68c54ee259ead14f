//! What went otherwise than a scene means it to, over all episodes: held things that moved in the fingers that held them, and
//! trajectories that were out of reach where they were begun.

use super::record::EpisodeRecord;
use evidence::DescriptionGap;
use std::collections::BTreeMap;
use testbench::{Creep, OutOfReach};

/// How often each held thing moved in whose fingers, and the worst of it; how often each trajectory was out of reach, and the first time.
#[derive(Clone, Debug, Default)]
pub struct Mishaps {
    episodes: u64,
    /// By trajectory and waypoint: how many episodes, the number of the first, and what it was.
    missed: BTreeMap<(String, usize), (u64, u64, OutOfReach)>,
    /// By object, holder and whether it slid: how many episodes, the number of the worst, and what it was.
    found: BTreeMap<(String, String, bool), (u64, u64, Creep)>,
}

impl Mishaps {
    pub(super) fn add(&mut self, record: &EpisodeRecord) {
        self.episodes += 1;
        let mut counted: Vec<(String, usize)> = Vec::new();
        for missed in &record.out_of_reach {
            let key = (missed.trajectory.clone(), missed.waypoint);
            if counted.contains(&key) {
                continue;
            }
            counted.push(key.clone());
            let first = || (0, record.number, missed.clone());
            self.missed.entry(key).or_insert_with(first).0 += 1;
        }
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
        let missed = |(count, first, missed): &(u64, u64, OutOfReach)| DescriptionGap {
            file: file.to_owned(),
            line: None,
            column: None,
            element: format!("trajectory {}", missed.trajectory),
            what: format!(
                "in {count} of {} episodes it could not be gone along; in episode {first} {missed}",
                self.episodes
            ),
            effect: "motion".to_owned(),
            consequence: format!(
                "the group stayed where it was, `{0}.failed` was sent, and what waits for `{0}.done` waits for ever: begin it where it is in reach",
                missed.trajectory
            ),
        };
        let crept = self.found.values().map(gap);
        crept.chain(self.missed.values().map(missed)).collect()
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
            out_of_reach: Vec::new(),
        };
        let mut tally = Mishaps::default();
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

    #[test]
    fn a_trajectory_that_was_out_of_reach_is_told_with_its_first_episode() {
        let missed = |secs: f64| OutOfReach {
            trajectory: "fetch".to_owned(),
            waypoint: 0,
            secs,
            distance_left_m: 0.012,
            angle_left_rad: 0.0,
        };
        let record = |number: u64, out_of_reach: Vec<OutOfReach>| EpisodeRecord {
            number,
            seed: 1,
            end: "complete".to_owned(),
            simulated_secs: None,
            recording: None,
            judged: Vec::new(),
            forms: Vec::new(),
            crept: Vec::new(),
            out_of_reach,
        };
        let mut tally = Mishaps::default();
        tally.add(&record(1, Vec::new()));
        // Twice in one episode counts once.
        tally.add(&record(2, vec![missed(1.0), missed(2.0)]));
        tally.add(&record(3, vec![missed(0.5)]));
        let gaps = tally.gaps("scene.toml");
        assert_eq!(gaps.len(), 1);
        let shown = gaps[0].to_string();
        for words in [
            "trajectory fetch",
            "2 of 3 episodes",
            "in episode 2 at 1.00 s",
            "12.0 mm",
            "fetch.failed",
        ] {
            assert!(shown.contains(words), "{words}: {shown}");
        }
    }
}
