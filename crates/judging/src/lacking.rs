//! Recordings that lack some of the signals that are judged.
//!
//! What reads a signal that a recording does not have reaches no verdict there, and everything else is judged. Of a signal that
//! it has without any value, violations are seen all the same, and count. Whether a name
//! is one at all shows only in other recordings: whoever judges several says whether any of them has it.

use super::recording::{JudgedRecording, ReadingRules};
use super::{JudgedTrace, Judgement, Judges, SubjectJudge};
use diagnostic::Problem;
use std::collections::BTreeSet;
use std::path::Path;
use temporal::monitor::Verdict;

impl<'a> Judges<'a> {
    /// For each of them whether it reads none of these signals.
    fn hears(&self, lacking: &BTreeSet<String>) -> Vec<bool> {
        let is_deaf = |judge: &SubjectJudge<'_>| {
            let places = judge.propositions.iter();
            let read = places.map(|place| self.predicates[*place].signals());
            let clock = judge.clock.map(|clock| self.clocks[clock].signals());
            read.chain(clock)
                .any(|signals| !signals.is_disjoint(lacking))
        };
        self.judges.iter().map(|judge| !is_deaf(judge)).collect()
    }

    /// Those that read none of these signals, and for each of all whether it is among them.
    fn without(&self, lacking: &BTreeSet<String>) -> (Self, Vec<bool>) {
        let hears = self.hears(lacking);
        let judges = self.judges.iter().zip(&hears).filter(|(_, hears)| **hears);
        let mut judges: Vec<SubjectJudge<'a>> = judges.map(|(judge, _)| judge.clone()).collect();
        // Those that nobody reads any more are left out: they would be looked for all the same.
        let predicates = Kept::of(&judges, |it| &it.propositions);
        let clocks = Kept::of(&judges, |it| it.clock.as_slice());
        for judge in &mut judges {
            for place in &mut judge.propositions {
                *place = predicates.new_place(*place);
            }
            judge.clock = judge.clock.map(|clock| clocks.new_place(clock));
        }
        let rest = Judges {
            vocabulary: self.vocabulary,
            forms: self.forms,
            predicates: predicates.of_all(&self.predicates),
            texts: predicates.of_all(&self.texts),
            clocks: clocks.of_all(&self.clocks),
            judges,
        };
        (rest, hears)
    }
}

/// Which of a list are still used, in their order.
struct Kept(Vec<usize>);

impl Kept {
    fn of<'j>(
        judges: &'j [SubjectJudge<'_>],
        used: impl Fn(&'j SubjectJudge<'_>) -> &'j [usize],
    ) -> Self {
        let places: BTreeSet<usize> = judges.iter().flat_map(used).copied().collect();
        Self(places.into_iter().collect())
    }

    /// Where it is now; it is used.
    fn new_place(&self, place: usize) -> usize {
        self.0.partition_point(|kept| *kept < place)
    }

    fn of_all<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.0.iter().map(|place| all[*place].clone()).collect()
    }
}

/// A recording that was judged as far as it has the signals.
#[derive(Debug)]
pub struct JudgedWithLack<'a> {
    /// What was judged; without a verdict where a signal is lacking.
    pub judged: JudgedRecording<'a>,
    /// The signals that it lacks, `/topic.field`.
    pub lacking: BTreeSet<String>,
}

impl ReadingRules {
    /// As [`ReadingRules::judge`], without a verdict of what reads a signal that the recording does not have.
    ///
    /// # Errors
    /// What is wrong but for that; if no signal is there at all, the same as of [`ReadingRules::judge`].
    pub fn judge_what_is_there<'a>(
        &self,
        judges: &Judges<'a>,
        path: &Path,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<JudgedWithLack<'a>, Problem> {
        let whole = match self.judge(judges, path, go_on) {
            Ok(judged) => return Ok(without_passes(judges, judged)),
            Err(problem) if problem.is_interruption() => return Err(problem),
            Err(problem) => problem,
        };
        let lacking = self.lacking(judges, path)?;
        let (rest, hears) = judges.without(&lacking);
        if lacking.is_empty() || rest.judges.is_empty() {
            return Err(whole);
        }
        let JudgedWithLack {
            mut judged,
            lacking: valueless,
        } = without_passes(&rest, self.judge(&rest, path, go_on)?);
        let lacking = &lacking | &valueless;
        let mut said = std::mem::take(&mut judged.judgements).into_iter();
        let all = judges.judges.iter().zip(hears);
        let all = all.filter_map(|(judge, hears)| match hears {
            true => said.next(),
            false => Some(unheard(judge)),
        });
        judged.judgements = all.collect();
        Ok(JudgedWithLack { judged, lacking })
    }
}

/// A signal without any value is lacking, too. What reads it may pass by what else it reads, where it could not be seen to
/// fail: were such passes counted, and what is not known left out, recordings with a lack would count where they pass alone.
fn without_passes<'a>(judges: &Judges<'a>, mut judged: JudgedRecording<'a>) -> JudgedWithLack<'a> {
    let lacking = judged.valueless.clone();
    let hears = judges.hears(&lacking);
    for (judgement, hears) in judged.judgements.iter_mut().zip(hears) {
        let findings = &mut judgement.findings;
        if !hears && findings.verdict == Verdict::Satisfied {
            findings.verdict = Verdict::Inconclusive;
        }
    }
    JudgedWithLack { judged, lacking }
}

/// What is known of a monitor whose signals a recording does not have.
fn unheard<'a>(judge: &SubjectJudge<'a>) -> Judgement<'a> {
    Judgement {
        subject: judge.subject,
        reading: judge.reading,
        findings: JudgedTrace {
            verdict: Verdict::Inconclusive,
            triggered: 0,
            passed: 0,
            failed: 0,
            robustness: None,
            no_robustness: None,
            decided_at_secs: None,
            judged_from_secs: None,
            ends_before: None,
            left_out: None,
            violation: None,
        },
    }
}
