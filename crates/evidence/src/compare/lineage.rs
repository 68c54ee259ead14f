//! Lineage: whose counts a number rests on.
//!
//! # Definition
//! The *sources* of evidence E on a subject S are the findings to which parameters of E's assets
//! were set and that bear on S, and their sources in turn. A calibration on subject C bears on S
//! when C is S; when S is a requirement and C a failure mode that makes runs fail it; or the other
//! way round; or when both are failure modes and a model shows that its constant for C moves S. Where counts of a simulation are
//! sources, what the simulation was set to is, too, unless a model shows that it plays no part: its runs rest on each of its numbers. Two pieces of evidence are independent on S when neither is among the other's
//! sources, they have no source in common, and no file of data either (`shared_data`), declared or not, and neither looks
//! copied from the other (`questions`), until the ledger says that it is not. A change of a text that was chosen because then evidence
//! agrees counts as a calibration on it ([`Calibration::chosen`]).
//!
//! Which failure modes make runs fail which requirement is learnt from formal models with
//! uncertain constants: a constant that was set to a failure mode's count and takes less than
//! [`SHARE`] of the variance of a requirement's probability does not bear on the requirement. What
//! neither a model nor a declaration tells counts as bearing, so that independence is never
//! claimed without a reason.
//!
//! # Assumes
//! What was set to counts is declared, and a model that shows what a constant moves shows it of the system, too. A constant
//! below [`SHARE`] carries nothing over.
//!
//! # Guarantee
//! Two pieces are called independent only where nothing that is declared, shared or questioned connects them. What no asset,
//! lineage or table shows is taken as independent: a copy that was changed by hand is not found.

use super::questions::{self, Questions};
use super::shared_data::SharedData;
use super::words::list;
use crate::{Calibration, Evidence, Interval, Measure, Spread, Subject};
use std::collections::{BTreeMap, BTreeSet};

/// The share of the variance from which a constant counts as an influence.
pub(crate) const SHARE: f64 = 0.005;

/// Which failure modes make runs fail which requirement, as far as is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Influences {
    known: BTreeMap<(Subject, String), bool>,
}

impl Influences {
    /// What the formal models of the ledger show.
    pub fn learn(evidence: &[Evidence]) -> Self {
        let mut influences = Self::default();
        for piece in evidence {
            let all = piece.findings.iter().map(|it| shares(&it.measure));
            let carried: BTreeSet<&str> = all.flat_map(BTreeMap::into_keys).collect();
            for finding in &piece.findings {
                let mut shares = shares(&finding.measure);
                if !varies(&finding.measure) {
                    shares.extend(carried.iter().map(|constant| (*constant, 0.0)));
                }
                // A change of a text has no share of a variance, which tells nothing.
                for calibration in piece.calibrated.iter().filter(|it| !it.chosen) {
                    let Subject::FailureMode(mode) = &calibration.subject else {
                        continue;
                    };
                    let share = shares.get(calibration.parameter.as_str());
                    // A rate of a way to fail that others move is told apart from those that do not.
                    let is_told =
                        matches!(finding.subject, Subject::FailureMode(_)) && !shares.is_empty();
                    if let Some(share) = share.copied().or_else(|| is_told.then_some(0.0)) {
                        influences.add(finding.subject.clone(), mode, share >= SHARE);
                    }
                }
            }
        }
        influences
    }

    /// Declares whether a failure mode makes runs fail a requirement; a declaration is never
    /// unlearnt.
    #[must_use]
    pub fn declare(mut self, requirement: &str, failure_mode: &str, bears: bool) -> Self {
        let requirement = Subject::Requirement(requirement.to_owned());
        self.known
            .insert((requirement, failure_mode.to_owned()), bears);
        self
    }

    /// Adds what a model with held constants shows. One model in which a failure mode bears is enough: another in which the
    /// constant moves nothing, or nothing that a range shows, takes nothing back.
    #[must_use]
    pub fn shown(mut self, requirement: &str, failure_mode: &str, bears: bool) -> Self {
        self.add(
            Subject::Requirement(requirement.to_owned()),
            failure_mode,
            bears,
        );
        self
    }

    /// Adds what one model shows; one model in which it bears is enough.
    fn add(&mut self, subject: Subject, mode: &str, bears: bool) {
        let known = self
            .known
            .entry((subject, mode.to_owned()))
            .or_insert(bears);
        *known |= bears;
    }

    /// Whether a calibration on `source` bears on `subject`; yes when nothing is known. Two failure modes are told apart unless a
    /// model shows that what was set to the one moves the other.
    pub(super) fn bears(&self, source: &Subject, subject: &Subject) -> bool {
        self.bears_or(source, subject, false)
    }

    /// The same of what a simulation was set to: two failure modes bear on each other unless a model shows that they do not.
    fn may_bear(&self, source: &Subject, subject: &Subject) -> bool {
        self.bears_or(source, subject, true)
    }

    /// The same, with what is so of two failure modes of which nothing is known.
    fn bears_or(&self, source: &Subject, subject: &Subject, of_modes: bool) -> bool {
        let known = |subject: &Subject, mode: &String| {
            let key = (subject.clone(), mode.clone());
            self.known.get(&key).copied()
        };
        match (source, subject) {
            (Subject::FailureMode(mode), requirement @ Subject::Requirement(_))
            | (requirement @ Subject::Requirement(_), Subject::FailureMode(mode)) => {
                known(requirement, mode).unwrap_or(true)
            }
            (Subject::FailureMode(mode), other @ Subject::FailureMode(_)) => {
                source == subject || known(other, mode).unwrap_or(of_modes)
            }
            (source, subject) => source == subject,
        }
    }
}

/// Whether a probability has a distribution that is more than one number, or none at all: then nothing is known.
fn varies(measure: &Measure) -> bool {
    match measure {
        Measure::Probability {
            credible: Some(credible),
            ..
        } => credible.ends.is_some() || !credible.spread.is_empty(),
        _ => true,
    }
}

/// The shares of constants in the variance of a computed probability, by each name that a source has; all zero when it does
/// not vary.
fn shares(measure: &Measure) -> BTreeMap<&str, f64> {
    let Measure::Probability {
        credible: Some(credible),
        ..
    } = measure
    else {
        return BTreeMap::new();
    };
    let Some(ends) = &credible.ends else {
        return shares_of(&credible.spread, &credible.quantiles, credible.interval);
    };
    // What bears on either end of a range bears on it.
    let mut found = BTreeMap::new();
    for end in [&ends.least, &ends.greatest] {
        for (constant, share) in shares_of(&end.spread, &end.quantiles, end.interval) {
            let largest = found.entry(constant).or_insert(0.0_f64);
            *largest = largest.max(share);
        }
    }
    found
}

fn shares_of<'e>(
    spread: &'e [Spread],
    quantiles: &[f64],
    interval: Interval,
) -> BTreeMap<&'e str, f64> {
    let width = match (quantiles.first(), quantiles.last()) {
        (Some(low), Some(high)) => high - low,
        _ => interval.high - interval.low,
    };
    let varies = width > 1e-12;
    let share = |spread: &'e Spread| {
        let bears: f64 = match varies {
            // What the share's error leaves open counts as bearing, too.
            true => spread.total.unwrap_or(0.0).max(spread.share) + spread.error.unwrap_or(0.0),
            false => 0.0,
        };
        spread.constant.split(", ").map(move |name| (name, bears))
    };
    spread.iter().flat_map(share).collect()
}

/// A source: evidence and what was counted in it.
type Source = (String, Subject);

/// What was set to a source, or chosen for it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Taken {
    /// By which evidence.
    holder: String,
    /// The parameter, or the change in words.
    what: String,
    /// Whether it is a change of a text.
    chosen: bool,
}

/// Sources, each with what was set to it.
type Sources = BTreeMap<Source, BTreeSet<Taken>>;

/// The calibrations of a ledger, with what is known of their bearing.
pub(crate) struct Lineage<'a> {
    evidence: BTreeMap<&'a str, &'a Evidence>,
    influences: &'a Influences,
    data: SharedData,
    questions: Questions<'a>,
}

impl<'a> Lineage<'a> {
    pub fn new(evidence: &'a [Evidence], influences: &'a Influences) -> Self {
        Self {
            data: SharedData::of(evidence),
            questions: Questions::of(evidence),
            evidence: evidence
                .iter()
                .map(|piece| (piece.id.as_str(), piece))
                .collect(),
            influences,
        }
    }

    /// Why two pieces of evidence are not independent on a subject; `None` if they are.
    pub fn dependence(&self, first: &str, second: &str, subject: &Subject) -> Option<String> {
        self.dependence_with(first, second, subject, true)
    }

    fn dependence_with(
        &self,
        first: &str,
        second: &str,
        subject: &Subject,
        with_choices: bool,
    ) -> Option<String> {
        self.known_dependence(first, second, subject, with_choices)
            .or_else(|| self.data.paired(first, second).map(str::to_owned))
            .or_else(|| self.possible_copy(first, second, subject))
    }

    /// The same as far as it is declared or certain.
    fn known_dependence(
        &self,
        first: &str,
        second: &str,
        subject: &Subject,
        with_choices: bool,
    ) -> Option<String> {
        let ours = self.sources_with(first, subject, with_choices);
        let theirs = self.sources_with(second, subject, with_choices);
        // Two samples stay two, whatever both were read by.
        let are_counted = [first, second]
            .iter()
            .all(|id| self.is_counted(id, subject));
        taken_from(&theirs, first)
            .or_else(|| taken_from(&ours, second))
            .or_else(|| shared(&ours, &theirs, are_counted))
            .or_else(|| self.shared_data((first, &ours), (second, &theirs)))
    }

    /// The same of what decides: trials of the system stay trials, however a text was chosen by which they are read. That it was chosen
    /// is said with the verdict.
    pub fn dependence_of_counts(
        &self,
        first: &str,
        second: &str,
        subject: &Subject,
    ) -> Option<String> {
        self.dependence_with(first, second, subject, false)
    }

    /// Whether the evidence rests on no other on this subject but by texts that were chosen.
    pub fn is_root_of_counts(&self, id: &str, subject: &Subject) -> bool {
        self.sources_with(id, subject, false).is_empty()
    }

    fn is_counted(&self, id: &str, subject: &Subject) -> bool {
        let piece = self.evidence.get(id);
        let finding = piece.and_then(|piece| piece.finding(subject));
        finding.is_some_and(|it| matches!(it.measure, Measure::Counts { .. }))
    }

    /// Why two pieces have the same runs, so that there is nothing to compare; `None` if they do not.
    pub fn same_runs(&self, first: &str, second: &str) -> Option<String> {
        self.data.same_runs(first, second).map(str::to_owned)
    }

    /// Whether two pieces are dependent because their runs have the same seeds, and for no other reason that is known.
    pub fn is_paired(&self, first: &str, second: &str, subject: &Subject) -> bool {
        self.known_dependence(first, second, subject, true)
            .is_none()
            && self.data.paired(first, second).is_some()
    }

    /// Whether two pieces are dependent only because one looks copied from the other.
    pub fn is_possible_copy(&self, first: &str, second: &str, subject: &Subject) -> bool {
        self.known_dependence(first, second, subject, true)
            .is_none()
            && self.data.paired(first, second).is_none()
            && self.possible_copy(first, second, subject).is_some()
    }

    /// Which question is open between two pieces, or what they rest on.
    fn possible_copy(&self, first: &str, second: &str, subject: &Subject) -> Option<String> {
        let all = |id: &str| {
            let sources = self.sources(id, subject);
            let rests_on = sources.into_keys().map(|(source, _)| source);
            // Its own questions before those of what it rests on.
            let mut ids = vec![id.to_owned()];
            ids.extend(rests_on);
            ids.dedup();
            ids
        };
        let (ours, theirs) = (all(first), all(second));
        let mut pairs = ours
            .iter()
            .flat_map(|one| theirs.iter().map(move |other| (one, other)));
        pairs.find_map(|(one, other)| {
            let question = self
                .questions
                .open((one, other), subject, self.influences)?;
            let words = questions::in_words(question);
            let is_own = one == first && other == second;
            Some(match is_own {
                true => words,
                false => format!("they rest on {one} and {other}, and {words}"),
            })
        })
    }

    /// Coincidences that chance explains, in words.
    pub fn noted(&self, first: &str, second: &str, subject: &Subject) -> Vec<String> {
        let noted = self.questions.noted(first, second, subject);
        noted.into_iter().map(questions::in_words).collect()
    }

    /// Which files two pieces, or what they rest on, both read.
    fn shared_data(&self, first: (&str, &Sources), second: (&str, &Sources)) -> Option<String> {
        let all = |(id, sources): (&str, &Sources)| {
            let sources = sources.keys().map(|(id, _)| id.clone());
            sources.chain([id.to_owned()]).collect::<BTreeSet<String>>()
        };
        let (ours, theirs) = (all(first), all(second));
        let mut pairs = ours
            .iter()
            .flat_map(|one| theirs.iter().map(move |other| (one, other)));
        pairs.find_map(|(one, other)| {
            let words = self.data.between(one, other)?;
            let is_own = one == first.0 && other == second.0;
            Some(match is_own {
                true => words.to_owned(),
                false => format!("they rest on {one} and {other}, and {words}"),
            })
        })
    }

    /// Whether the evidence rests on no other on this subject.
    pub fn is_root(&self, id: &str, subject: &Subject) -> bool {
        self.sources(id, subject).is_empty()
    }

    /// All sources, each with the calibrations that name it.
    fn sources(&self, id: &str, subject: &Subject) -> Sources {
        self.sources_with(id, subject, true)
    }

    /// The same with or without what texts were chosen for.
    fn sources_with(&self, id: &str, subject: &Subject, with_choices: bool) -> Sources {
        let mut found = Sources::new();
        let mut seen = BTreeSet::from([(id.to_owned(), subject.clone())]);
        let mut open = vec![(id.to_owned(), subject.clone())];
        while let Some((holder, about)) = open.pop() {
            let Some(piece) = self.evidence.get(holder.as_str()) else {
                continue;
            };
            let bearing: Vec<&Calibration> = match holder != id && piece.technique.is_of_simulator()
            {
                // Its runs rest on all that it was set to, but for what a model shows to play no part.
                true => piece
                    .calibrated
                    .iter()
                    .filter(|it| self.influences.may_bear(&it.subject, &about))
                    .collect(),
                false => self.bearing(piece, &about),
            };
            let bearing = bearing.into_iter().filter(|it| with_choices || !it.chosen);
            for calibration in bearing {
                let source = (calibration.from.clone(), calibration.subject.clone());
                let taken = Taken {
                    holder: holder.clone(),
                    what: calibration.parameter.clone(),
                    chosen: calibration.chosen,
                };
                found.entry(source.clone()).or_default().insert(taken);
                if seen.insert(source.clone()) {
                    open.push(source);
                }
            }
        }
        found
    }

    /// The calibrations of `piece` that bear on `subject`: by its own model where that tells, else
    /// by what is known in general.
    fn bearing(&self, piece: &'a Evidence, subject: &Subject) -> Vec<&'a Calibration> {
        let own = piece
            .finding(subject)
            .map(|finding| shares(&finding.measure));
        let bears = |calibration: &&Calibration| {
            if &calibration.subject == subject {
                return true;
            }
            // What a number moves says nothing of what a text does.
            if calibration.chosen {
                return Influences::default().bears(&calibration.subject, subject);
            }
            let share = own
                .as_ref()
                .and_then(|own| own.get(calibration.parameter.as_str()));
            match share {
                Some(share) => *share >= SHARE,
                None => self.influences.bears(&calibration.subject, subject),
            }
        };
        piece.calibrated.iter().filter(bears).collect()
    }
}

/// Which parameters of whom were set to counts of `from`, in words.
fn taken_from(sources: &Sources, from: &str) -> Option<String> {
    let mut by_holder: BTreeMap<(&str, bool), BTreeSet<&str>> = BTreeMap::new();
    for ((_, _), takers) in sources.iter().filter(|((id, _), _)| id == from) {
        for taken in takers {
            let of_holder = by_holder.entry((&taken.holder, taken.chosen));
            of_holder.or_default().insert(&taken.what);
        }
    }
    let sentences: Vec<String> = by_holder
        .into_iter()
        .map(|((holder, chosen), all)| {
            let all = |mark: &str| -> String {
                let all = all.iter().map(|it| format!("{mark}{it}{mark}"));
                list(&all.collect::<Vec<_>>())
            };
            match chosen {
                false => format!("{holder} takes {} from {from}", all("`")),
                true => format!(
                    "{} was chosen in {holder} because then {from} agrees",
                    all("\"")
                ),
            }
        })
        .collect();
    (!sentences.is_empty()).then(|| list(&sentences))
}

/// The counts on which both rest, in words.
///
/// Of two counted pieces a source does not count for which only texts were chosen.
fn shared(first: &Sources, second: &Sources, are_counted: bool) -> Option<String> {
    let mut by_evidence: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let is_common = |source: &&Source| {
        let takers = [first, second].map(|it| it.get(*source));
        let are_taken = |it: &Option<&BTreeSet<Taken>>| {
            it.is_some_and(|all| !are_counted || all.iter().any(|taken| !taken.chosen))
        };
        takers.iter().all(are_taken)
    };
    for (id, subject) in first.keys().filter(is_common) {
        by_evidence.entry(id).or_default().insert(subject.id());
    }
    let counts: Vec<String> = by_evidence
        .into_iter()
        .map(|(id, subjects)| {
            let subjects: Vec<String> = subjects.into_iter().map(|s| s.replace('_', " ")).collect();
            format!("{id}'s {}", list(&subjects))
        })
        .collect();
    (!counts.is_empty()).then(|| format!("both rest on {}", list(&counts)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Technique, Tool};

    fn piece(id: &str, calibrated: &[(&str, Subject)]) -> Evidence {
        let calibrations = calibrated.iter().map(|(from, subject)| Calibration {
            parameter: "constant".to_owned(),
            from: (*from).to_owned(),
            subject: subject.clone(),
            chosen: false,
        });
        Evidence {
            id: id.to_owned(),
            title: String::new(),
            technique: Technique::Simulation,
            tool: Tool {
                name: String::new(),
                version: String::new(),
                settings: String::new(),
            },
            assets: Vec::new(),
            conditions: String::new(),
            changed: String::new(),
            calibrated: calibrations.collect(),
            intermediate: false,
            published: false,
            reproduced_by: None,
            findings: Vec::new(),
            form_differences: vec![],
            description_gaps: vec![],
            failures: vec![],
            clusters: None,
            shared_rows: Vec::new(),
            common_texts: Vec::new(),
            shared_seeds: Vec::new(),
            undecided_at_random: None,
            alike_trials: None,
            lineage_questions: Vec::new(),
            inputs: String::new(),
        }
    }

    fn mode(id: &str) -> Subject {
        Subject::FailureMode(id.to_owned())
    }

    fn requirement(id: &str) -> Subject {
        Subject::Requirement(id.to_owned())
    }

    #[test]
    fn calibration_is_inherited_and_per_mode() {
        let ledger = [
            piece("A", &[]),
            piece("B", &[("A", mode("slip"))]),
            piece("C", &[("B", mode("slip"))]),
            piece("D", &[("A", mode("gaze"))]),
        ];
        let influences = Influences::default();
        let lineage = Lineage::new(&ledger, &influences);
        let words = lineage.dependence("A", "C", &mode("slip")).unwrap();
        assert_eq!(words, "B takes `constant` from A");
        assert_eq!(lineage.dependence("A", "C", &mode("gaze")), None);
        assert_eq!(lineage.dependence("C", "D", &mode("slip")), None);
        assert!(lineage.is_root("A", &mode("slip")) && !lineage.is_root("C", &mode("slip")));
        // Nothing tells whether slips bear on the requirement, so they count as bearing.
        assert!(lineage.dependence("A", "B", &requirement("1")).is_some());
    }

    /// What a model's answer for one failure mode owes to counts of another it owes to what these counts rest on, too.
    #[test]
    fn failure_modes_that_share_constants_share_sources() {
        let mut influences = Influences::default();
        influences.add(mode("late"), "grab", true);
        influences.add(mode("lost"), "grab", false);
        let ledger = [
            piece("R", &[]),
            piece("L", &[("R", mode("late"))]),
            piece("T", &[("L", mode("late"))]),
            piece("M", &[("T", mode("grab"))]),
        ];
        let lineage = Lineage::new(&ledger, &influences);
        assert!(lineage.dependence("T", "M", &mode("late")).is_some());
        assert!(lineage.dependence("R", "M", &mode("late")).is_some());
        assert!(lineage.dependence("R", "M", &mode("lost")).is_none());
    }

    #[test]
    fn one_model_in_which_it_bears_is_enough() {
        let slip = || mode("slip");
        let speed = || requirement("speed");
        let none = Influences::default().shown("speed", "slip", false);
        assert!(!none.bears(&slip(), &speed()));
        assert!(none.shown("speed", "slip", true).bears(&slip(), &speed()));
        let some = Influences::default().shown("speed", "slip", true);
        assert!(some.shown("speed", "slip", false).bears(&slip(), &speed()));
    }

    /// The same table under two names, and nothing declared.
    #[test]
    fn data_that_is_shared_undeclared_is_found() {
        let with = |id: &str, calibrated: &[(&str, Subject)], files: &[(&str, &str)]| {
            let mut piece = piece(id, calibrated);
            let asset = |&(path, hash): &(&str, &str)| crate::Asset {
                role: crate::AssetRole::Data,
                path: path.to_owned(),
                hash: hash.to_owned(),
            };
            piece.assets = files.iter().map(asset).collect();
            piece
        };
        let ledger = [
            with("A", &[], &[("a.csv", "1"), ("more.csv", "2")]),
            with("B", &[], &[("copy.csv", "1")]),
            with("C", &[("B", mode("slip"))], &[]),
            with("D", &[], &[("a.csv", "3"), ("none", "")]),
            with("E", &[], &[("none", "")]),
            with("F", &[], &[("a.csv", "1"), ("more.csv", "2")]),
        ];
        let influences = Influences::default();
        let lineage = Lineage::new(&ledger, &influences);
        let words = |first, second| lineage.dependence(first, second, &mode("slip"));
        let copy = "both read `a.csv`, which is `copy.csv`";
        assert_eq!(words("A", "B").as_deref(), Some(copy));
        assert!(words("B", "A").is_some());
        let through = words("A", "C").unwrap();
        assert_eq!(through, format!("they rest on A and B, and {copy}"));
        let several = words("A", "F").unwrap();
        assert_eq!(several, "both read `a.csv`, and 1 more file");
        // Another content of the same name, and contents that are not known.
        assert_eq!(words("A", "D"), None);
        assert_eq!(words("D", "E"), None);
    }

    /// Two tables with the same people's rows, and nothing declared.
    #[test]
    fn rows_that_are_shared_undeclared_are_found() {
        let mut second = piece("B", &[]);
        second.shared_rows = vec![crate::RepeatedRows {
            with: "A".to_owned(),
            tables: ["a.csv".to_owned(), "b.csv".to_owned()],
            same: 11,
            common: 12,
            chance: 2e-8,
        }];
        let ledger = [
            piece("A", &[]),
            second,
            piece("C", &[("B", mode("slip"))]),
            piece("D", &[]),
        ];
        let influences = Influences::default();
        let lineage = Lineage::new(&ledger, &influences);
        let words = |first, second| lineage.dependence(first, second, &mode("slip"));
        let said = words("B", "A").unwrap();
        assert!(
            said.starts_with("11 of the 12 rows that `a.csv` and `b.csv` both have are the same"),
            "{said}"
        );
        assert_eq!(words("A", "B").as_deref(), Some(said.as_str()));
        assert!(
            words("A", "C")
                .unwrap()
                .starts_with("they rest on A and B, and 11 of")
        );
        assert_eq!(words("A", "D"), None);
    }

    /// The same runs are one piece told twice; runs of another simulator with the same seeds are paired.
    #[test]
    fn runs_with_the_same_seeds_are_no_two_samples() {
        let ledger = |same_runs: bool| {
            let mut second = piece("B", &[]);
            second.shared_seeds = vec![crate::SharedSeeds {
                with: "A".to_owned(),
                of: "A".to_owned(),
                same_runs,
            }];
            [piece("A", &[]), second, piece("C", &[])]
        };
        let influences = Influences::default();
        let subject = mode("slip");
        for same_runs in [true, false] {
            let ledger = ledger(same_runs);
            let lineage = Lineage::new(&ledger, &influences);
            let words = lineage.dependence("B", "A", &subject).unwrap();
            assert!(words.contains("the seeds of A"), "{words}");
            assert_eq!(words.contains("are the same runs"), same_runs, "{words}");
            assert_eq!(lineage.same_runs("A", "B").is_some(), same_runs);
            assert_eq!(lineage.is_paired("A", "B", &subject), !same_runs);
            assert!(!lineage.is_possible_copy("A", "B", &subject));
            assert_eq!(lineage.dependence("A", "C", &subject), None);
        }
    }

    /// A number that looks copied, undeclared: open, settled, and only noted.
    #[test]
    fn what_looks_copied_is_dependent_until_it_is_settled() {
        let question = |blocks: bool, settled: Option<&str>| crate::LineageQuestion {
            with: "A".to_owned(),
            kind: crate::CopyKind::Constant,
            subjects: vec![mode("slip")],
            finding: "`p` = 0.0714 of B is A's 7/98.".to_owned(),
            places: vec!["b.prism:3".to_owned()],
            chance: 2e-3,
            blocks,
            settled: settled.map(str::to_owned),
            remedy: "settle it".to_owned(),
        };
        let ledger = |question| {
            let mut second = piece("B", &[]);
            second.lineage_questions = vec![question];
            [piece("A", &[]), second, piece("C", &[("B", mode("slip"))])]
        };
        let open = ledger(question(true, None));
        let influences = Influences::default().declare("speed", "slip", false);
        let lineage = Lineage::new(&open, &influences);
        let words = lineage.dependence("A", "B", &mode("slip")).unwrap();
        assert_eq!(
            words,
            "`p` = 0.0714 of B is A's 7/98 (b.prism:3); settle it"
        );
        assert!(lineage.is_possible_copy("B", "A", &mode("slip")));
        // Where slips bear, and where they do not.
        assert!(
            lineage
                .dependence("A", "B", &requirement("success"))
                .is_some()
        );
        assert_eq!(lineage.dependence("A", "B", &requirement("speed")), None);
        assert_eq!(lineage.dependence("A", "B", &mode("gaze")), None);
        let through = lineage.dependence("A", "C", &mode("slip")).unwrap();
        assert!(
            through.starts_with("they rest on A and B, and `p`"),
            "{through}"
        );
        for no_question in [question(true, Some("another lab")), question(false, None)] {
            let is_noted = !no_question.blocks;
            let settled = ledger(no_question);
            let lineage = Lineage::new(&settled, &influences);
            assert_eq!(lineage.dependence("A", "B", &mode("slip")), None);
            assert_eq!(
                lineage.noted("A", "B", &mode("slip")).len(),
                usize::from(is_noted)
            );
        }
    }

    #[test]
    fn siblings_share_their_source() {
        let ledger = [
            piece("A", &[]),
            piece("B", &[("A", mode("slip"))]),
            piece("C", &[("A", mode("slip"))]),
        ];
        let influences = Influences::default();
        let lineage = Lineage::new(&ledger, &influences);
        let words = lineage.dependence("B", "C", &mode("slip")).unwrap();
        assert_eq!(words, "both rest on A's slip");
    }

    #[test]
    fn a_declaration_tells_what_does_not_bear() {
        let ledger = [piece("A", &[]), piece("B", &[("A", mode("slip"))])];
        let influences = Influences::default().declare("speed", "slip", false);
        let lineage = Lineage::new(&ledger, &influences);
        assert_eq!(lineage.dependence("A", "B", &requirement("speed")), None);
        assert!(
            lineage
                .dependence("A", "B", &requirement("success"))
                .is_some()
        );
    }

    #[test]
    fn a_circle_of_calibrations_ends() {
        let ledger = [
            piece("A", &[("B", mode("slip"))]),
            piece("B", &[("A", mode("slip"))]),
        ];
        let influences = Influences::default();
        let lineage = Lineage::new(&ledger, &influences);
        assert!(lineage.dependence("A", "B", &mode("slip")).is_some());
        assert!(lineage.dependence("A", "missing", &mode("slip")).is_none());
    }
}
