//! Findings, run again in the full physics before they count, and written.

use super::names;
use crate::technique::exploration::{
    Explored, FindingReport, Met, OpenBench, ShowsJudge, shown_again,
};
use diagnostic::Problem;
use evidence::Confirmation;
use host::Cancel;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::{Finding, Shows, Study};

/// Episodes of a finding that are run again in the full physics before it counts as not confirmed, at most.
const CONFIRMATIONS: usize = 8;

/// A finding, as it is told, with all episodes that showed it.
struct Found {
    finding: Finding,
    report: FindingReport,
    met: Vec<Met>,
}

/// Findings that are run again, and kept.
pub struct Keeping<'a> {
    pub study: &'a Study,
    /// That of the full physics.
    pub bench: &'a OpenBench,
    /// Whether the search ran in the fast one.
    pub is_fast: bool,
    pub folder: &'a Path,
}

impl Keeping<'_> {
    /// Keeps the findings of an exploration, and tells those apart that the full physics does not show.
    pub fn keep(&self, explored: &mut Explored) -> Result<(), Problem> {
        let found = &mut explored.report.found;
        let findings = std::mem::take(&mut explored.findings).into_iter();
        let reports = std::mem::take(&mut found.findings).into_iter();
        let met = std::mem::take(&mut explored.met).into_iter();
        let all = findings.zip(reports).zip(met);
        let all = all.map(|((finding, report), met)| Found {
            finding,
            report,
            met,
        });
        let (kept, others) = self.sorted(all.collect())?;
        for one in kept {
            explored.findings.push(one.finding);
            explored.met.push(one.met);
            found.findings.push(one.report);
        }
        found.confirmation = self.is_fast.then(|| Confirmation {
            engine: self.bench.engine.clone(),
            not_confirmed: others.into_iter().map(|one| one.report).collect(),
        });
        Ok(())
    }

    /// Runs an episode of each finding again in the full physics, and writes the files: the findings, and what the fast
    /// physics showed and the full one does not.
    fn sorted(&self, all: Vec<Found>) -> Result<(Vec<Found>, Vec<Found>), Problem> {
        let (mut names, mut judges) = (BTreeMap::new(), BTreeMap::new());
        let (mut kept, mut others) = (Vec::new(), Vec::new());
        for mut one in all {
            let is_shown = self.run_again(&mut one, &mut judges)?;
            let is_kept = is_shown || !self.is_fast;
            let place = if is_kept { "findings" } else { "not-confirmed" };
            let file = PathBuf::from(place).join(names::of_finding(&one.finding.shows, &mut names));
            one.report.found.file = file.display().to_string();
            self.write(&one.finding, &one.report, is_kept)?;
            match is_kept {
                true => kept.push(one),
                false => others.push(one),
            }
        }
        Ok((kept, others))
    }

    /// Runs episodes of a finding again until one shows it, which then stands for it: the first alone if it was found in
    /// the full physics, where nothing else but the same can come out.
    fn run_again<'s>(
        &'s self,
        of: &mut Found,
        judges: &mut BTreeMap<Shows, ShowsJudge<'s>>,
    ) -> Result<bool, Problem> {
        let Found {
            finding,
            report,
            met,
        } = of;
        // Findings are few: an interruption leaves them to be written all the same.
        let undisturbed = Cancel::default();
        let most = if self.is_fast { CONFIRMATIONS } else { 1 };
        for episode in met.iter().take(most) {
            let again = Finding {
                seed: episode.seed,
                stimulus: episode.stimulus.clone(),
                found_by: episode.found_by.clone(),
                ..finding.clone()
            };
            let shown = shown_again(self.study, self.bench, &again, judges, &undisturbed)?;
            if shown.is_some() {
                *finding = again;
                finding.recording = shown;
                report.found.first_episode = episode.episode;
                report.found.seed = episode.seed.to_string();
                report.found.found_by = episode.found_by.clone();
                report.found.replayed = true;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn write(
        &self,
        finding: &Finding,
        report: &FindingReport,
        is_kept: bool,
    ) -> Result<(), Problem> {
        let report = &report.found;
        let is_shown = match is_kept {
            true => "A witness: how often it was found does\nnot estimate how often it happens.",
            false => "Not confirmed: the fast\nphysics shows it, and the full physics does not.",
        };
        let comment = format!(
            "{}\nFound in episode {} of an exploration. {is_shown}",
            report.in_words, report.first_episode
        );
        let path = self.folder.join(&report.file);
        finding.write(&path, &comment)?;
        if Finding::read(&path)? != *finding {
            let message = format!("{} does not hold what was written", path.display());
            return Err(Problem::data_lost("cannot-write", message));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::Host;

    /// What an exploration of the handover found in one physics: a grip that fails, in episodes with these frictions.
    fn found(study: &Study, frictions: &[f64]) -> Found {
        let file = study.folder.join("regressions/grip-failure.toml");
        let finding = Finding::read(&file).expect("a regression");
        let met = (1..).zip(frictions).map(|(episode, friction)| {
            let mut stimulus = finding.stimulus.clone();
            let key = "parameters.hand.friction".to_owned();
            stimulus.settings.insert(key, (*friction).into());
            Met {
                episode,
                seed: finding.seed,
                stimulus,
                found_by: format!("friction {friction}"),
                secs: 0.0,
                is_after: false,
            }
        });
        let met: Vec<Met> = met.collect();
        let found = serde_json::from_value(serde_json::json!({
            "in_words": finding.shows.to_string(),
            "subject": null,
            "file": "",
            "first_episode": 1,
            "seed": finding.seed.to_string(),
            "found_by": "friction",
            "episodes": frictions.len(),
            "replayed": false,
            "causes": [],
            "without_cause": null,
        }));
        Found {
            report: FindingReport {
                shows: finding.shows.clone(),
                found: found.expect("a discovery"),
            },
            finding,
            met,
        }
    }

    #[test]
    fn what_the_full_physics_does_not_show_is_told_apart() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let library = root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
        if !library.exists() && std::env::var_os("CI").is_none() {
            return;
        }
        let study = Study::load(&root.join("case-studies/handover")).expect("a study");
        let entry = study.entry("E2").expect("an entry");
        let host = Host {
            physics_library: Some(library),
            ..Host::silent(crate::build())
        };
        let bench = OpenBench::of_entry(&study, entry, &host).expect("a bench");
        let folder = std::env::temp_dir().join(format!("confirmed-{}", std::process::id()));
        let keeping = |is_fast| Keeping {
            study: &study,
            bench: &bench,
            is_fast,
            folder: &folder,
        };
        // With the nominal friction the object does not slip: the first finding is shown by its second episode.
        let all = vec![found(&study, &[0.6, 0.3, 0.31]), found(&study, &[0.6, 0.6])];
        let (kept, others) = keeping(true).sorted(all).expect("they run");
        let [kept] = &kept[..] else {
            panic!("one is shown")
        };
        let told = &kept.report.found;
        assert_eq!(
            (told.first_episode, told.replayed, told.episodes),
            (2, true, 3)
        );
        assert_eq!(told.found_by, "friction 0.3");
        assert!(kept.finding.recording.is_some() && told.file.starts_with("findings/"));
        let [other] = &others[..] else {
            panic!("one is not")
        };
        assert!(!other.report.found.replayed && other.report.found.episodes == 2);
        assert!(other.report.found.file.starts_with("not-confirmed/"));
        let text = std::fs::read_to_string(folder.join(&other.report.found.file)).expect("kept");
        assert!(text.contains("the full physics does not"), "{text}");
        // A search in the full physics has nothing to confirm: an episode that does not repeat is lost data.
        let (kept, others) = keeping(false)
            .sorted(vec![found(&study, &[0.6, 0.3])])
            .expect("it runs");
        assert!(others.is_empty() && !kept[0].report.found.replayed);
        std::fs::remove_dir_all(&folder).expect("it was made");
    }
}
