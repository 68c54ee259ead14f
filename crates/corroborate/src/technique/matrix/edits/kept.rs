//! What recordings and results that are kept say beside their rates: which fields there are, and how often a subject is triggered.

use super::Diagnosing;
use evidence::{Evidence, Finding, Measure, Rate, Subject, signed_strength};
use recording::{InspectOptions, inspect};

impl Diagnosing<'_> {
    /// The fields of the first recording of each piece, by the names by which topics.toml reads them.
    pub(super) fn fields(&self) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        for entry in &self.study.ledger {
            let first = self.runs_of(entry).and_then(|folder| {
                let trials = recording::trials(&folder).ok()?.trials;
                trials.into_iter().next()
            });
            let options = (recording::OpenOptions::default(), InspectOptions::default());
            let inspected =
                first.and_then(|trial| inspect(&trial.path, &options.0, &options.1).ok());
            let map = inspected.map_or(String::new(), |it| it.draft_map());
            let fields = map.lines().filter_map(|line| {
                let field = line.strip_prefix("from = \"")?;
                Some(field.split('"').next()?.to_owned())
            });
            for field in fields {
                if !found.contains(&field) {
                    found.push(field);
                }
            }
        }
        found
    }

    /// How strongly two pieces disagree on how often a subject is triggered, where one has it triggered in none of its runs and so
    /// no rate; only where the two are of the same population of runs, which what they now differ in says, or one says that it is
    /// impossible.
    pub(super) fn never_triggered(&self, two: [&Evidence; 2], subject: &Subject) -> Option<f64> {
        let is_pair = |it: &&evidence::Comparison| {
            let sides = [&it.left, &it.right];
            &it.subject == subject && two.iter().all(|piece| sides.contains(&&piece.id))
        };
        let compared = self.result.comparisons.iter().find(is_pair)?;
        if compared.trigger.is_none() && !compared.is_with_the_impossible() {
            return None;
        }
        let rates = two.map(|piece| {
            let finding = piece.finding(subject)?;
            // Of trials of which it is not known in how many runs they were.
            if let (None, Measure::Counts { trials, .. }) = (&finding.trigger, &finding.measure) {
                return Some(Rate::counted(*trials, *trials));
            }
            let share = Finding {
                measure: *finding.trigger.clone()?,
                completions: None,
                ..finding.clone()
            };
            Rate::of(&share)
        });
        let [Some(one), Some(other)] = rates else {
            return None;
        };
        Some(signed_strength(one, other, self.margin(subject)))
    }
}
