//! Comparison: every pair of evidence on every subject, with one of four outcomes.
//!
//! # Definition
//! For two rates `p1`, `p2`, the declared margin `m`, the level of agreement `g` and the level of
//! confidence `c`, in this order:
//!
//! * *not comparable*: conditions differ, a side cannot express the subject, never covered it, or
//!   has an error that is unknown;
//! * *corroborates*: `|p1 - p2| < m` is shown, and the estimates are less than `m` apart. Between counts, and between counts and a known
//!   probability, by two one-sided tests at level `1 - g`; where a side is a distribution, by a
//!   posterior probability of at least `g`;
//! * *conflicts*: "no difference" is rejected at level `1 - c`, corrected for all comparable pairs of
//!   the study by closed testing (`compare/closed.rs`; Holm's correction where a subject has many pieces), and the
//!   estimates are `m` or more apart;
//! * *inconclusive*: neither; [`undecided`] gives the further trials that would decide.
//!
//! A difference below the margin was declared not to matter: it is never a conflict, and agreement where it is shown to
//! be below. [`Relation`] has the table of all cells, with what each promises. Where all trials of a side are of one person, session or
//! other cluster that is not declared to stand for all, the tests speak of this one alone: the pair is *inconclusive* whatever they
//! show, unless the other side is known to be 0 or 1, which one violation refutes. A pair is *independent* unless one side was calibrated on the other, or
//! both on the same counts, on this quantity (see [`Influences`]).
//!
//! | sides | "no difference" | agreement |
//! |---|---|---|
//! | counts, counts | Boschloo's exact test | two one-sided exact unconditional tests (`stats::exact_equivalence`) |
//! | counts, known | exact binomial test | two one-sided exact binomial tests |
//! | counts or distribution, distribution | posterior tails | posterior probability |
//! | known, known | their bounds are apart | their bounds are within the margin |
//!
//! Clustered counts enter at their effective size; exact tests, which need whole numbers, take
//! the neighbouring whole numbers with the largest p-value.
//!
//! # Source
//! Outcomes and the order of tests: this project. Tests: see `stats`. Distributions of computed
//! probabilities are beta distributions with the mean and variance of the draws (D.-Y. Fan, "The
//! distribution of the product of independent beta variables", 1991).
//!
//! # Assumes
//! Trials are independent, or alike only within the people and sessions that are declared, whose rates have a beta
//! distribution (`ERROR_RATES.md` has other laws). Sizes were fixed in advance, or all looks are recorded. Runs without a
//! verdict may be either. The two sides of a pair are independent of each other; constants that were set to counts have
//! Jeffreys' priors. All pairs that can be compared are in the correction.
//!
//! # Guarantee
//! With probability at least `c` none of the conflicts reported between independent counts is
//! due to chance; a pair that truly differs by the margin is reported to agree with probability
//! at most `1 - g`, whatever the rates are, where both sides are independent counts or one is a known probability. Where a
//! side is a distribution, that holds on the average over its prior and not at each rate.

mod belief;
mod by_cluster;
mod by_likelihood;
mod closed;
mod decide;
mod ends;
mod further;
mod lineage;
mod pair;
mod past;
mod programme;
mod quantiles;
mod questions;
mod relation;
mod runs;
mod shared_data;
mod statistical;
mod together;
mod uncertain;
pub(crate) mod words;

pub(crate) use belief::{Belief, Computed, CountsAtLook};
pub(crate) use by_cluster::ByCluster;
pub(crate) use ends::End;
pub use further::{DecisionPlan, FurtherSubjects, PlannedTrials, TrialCosts, Undecided, undecided};
pub use lineage::Influences;
pub(crate) use lineage::Lineage;
pub use programme::{Programme, programme};
pub use relation::Relation;
pub use together::{Spreading, Together, compare_together};

use crate::looks::is_open;
use crate::{
    Comparison, ErrorFamily, Evidence, FailureMode, Finding, Interval, Looking, Looks, Measure,
    Outcome, Requirement, Subject,
};
use pair::Pair;
use stats::{Confidence, StatsError};
use words::{p_value, points, probability, sentence};

/// Below this p-value of its own a difference that is not shown is told with its correction, too.
const NOTABLE: f64 = 0.1;

/// The levels that a study declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    pub(crate) confidence: Confidence,
    pub(crate) agreement: Confidence,
    pub(crate) power: f64,
    pub(crate) family: ErrorFamily,
}

impl Levels {
    /// `confidence` of every interval and against every false conflict, and the level at which
    /// `agreement` is claimed; both strictly between 0 and 1. Further trials are planned for a
    /// probability of success of 0.8.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`], naming the level.
    pub fn new(confidence: f64, agreement: f64) -> Result<Self, StatsError> {
        Ok(Self {
            confidence: Confidence::new(confidence)?,
            agreement: Confidence::new(agreement)?,
            power: 0.8,
            family: ErrorFamily::Study,
        })
    }

    /// The same where the error rates of verdicts hold for each requirement by itself, or for the study as a whole,
    /// which is the default.
    #[must_use]
    pub fn with_error_rates_of(self, family: ErrorFamily) -> Self {
        Self { family, ..self }
    }
}

/// What a study has to compare: plain references to its parts.
#[derive(Clone, Copy, Debug)]
pub struct Study<'a> {
    /// What is required, with margins.
    pub requirements: &'a [Requirement],
    /// What can go wrong, with margins.
    pub failure_modes: &'a [FailureMode],
    /// The ledger, oldest first.
    pub evidence: &'a [Evidence],
    /// Which failure modes make runs fail which requirement.
    pub influences: &'a Influences,
    /// The declared levels.
    pub levels: Levels,
    /// The looks before this one; `None` if all sample sizes were fixed in advance.
    pub looks: Option<&'a Looks>,
}

impl<'a> Study<'a> {
    /// The subjects that are quantities of their own, with their margins: requirements that are
    /// not "the same quantity as" another, then failure modes.
    pub(crate) fn subjects(&self) -> Vec<(Subject, f64)> {
        let requirements = self
            .requirements
            .iter()
            .filter(|requirement| requirement.same_quantity_as.is_none())
            .map(|requirement| {
                (
                    Subject::Requirement(requirement.id.clone()),
                    requirement.margin,
                )
            });
        let modes = self
            .failure_modes
            .iter()
            .map(|mode| (Subject::FailureMode(mode.id.clone()), mode.margin));
        requirements.chain(modes).collect()
    }

    pub(crate) fn lineage(&self) -> Lineage<'a> {
        Lineage::new(self.evidence, self.influences)
    }
}

/// Compares every pair of evidence that is not intermediate, on every subject about which both
/// have a finding, in the order of subjects and then of the ledger.
///
/// Requirements that are the same quantity as another are compared once, under the other's name. What would decide the
/// undecided is not planned here, which takes most of the time: see [`undecided`].
///
/// ```
/// use evidence::*;
///
/// let subject = Subject::FailureMode("slip".into());
/// let evidence = |id: &str, technique, count, trials| Evidence {
///     id: id.into(),
///     title: id.into(),
///     technique,
///     tool: Tool { name: "any".into(), version: "1".into(), settings: String::new() },
///     assets: vec![],
///     conditions: "typical".into(),
///     changed: String::new(),
///     calibrated: vec![],
///     intermediate: false,
///     published: false,
///     reproduced_by: None,
///     findings: vec![Finding {
///         subject: subject.clone(),
///         measure: Measure::Counts {
///             count,
///             trials,
///             effective_trials: None,
///             by_subject: None,
///             subjects: None,
///             interval: Interval { low: 0.0, high: 1.0 },
///         },
///         denominator: Denominator::default(),
///         trigger: None,
///         undecided: 0,
///         left_out: 0,
///         completions: None,
///         witnesses: vec![],
///         readings: vec![],
///     }],
///     form_differences: vec![],
///     description_gaps: vec![],
///     failures: vec![],
///     clusters: None,
///     shared_rows: Vec::new(),
///     common_texts: Vec::new(),
///     shared_seeds: Vec::new(),
///     undecided_at_random: None,
///     alike_trials: None,
///     lineage_questions: Vec::new(),
///     inputs: String::new(),
/// };
/// let ledger = [
///     evidence("sim", Technique::Simulation, 20, 100),
///     evidence("lab", Technique::Experiment, 2, 100),
/// ];
/// let slip = FailureMode {
///     id: "slip".into(),
///     name: "Slip".into(),
///     meaning: "The object slips; counted per grasp.".into(),
///     margin: 0.05,
/// };
/// let influences = Influences::learn(&ledger);
/// let study = Study {
///     requirements: &[],
///     failure_modes: &[slip],
///     evidence: &ledger,
///     influences: &influences,
///     levels: Levels::new(0.95, 0.95)?,
///     looks: None,
/// };
/// let comparisons = compare(&study);
/// assert_eq!(comparisons[0].outcome, Outcome::Conflicts);
/// assert!(comparisons[0].reason.starts_with("They differ by 18 points, beyond chance"));
/// # Ok::<(), stats::StatsError>(())
/// ```
pub fn compare(study: &Study<'_>) -> Vec<Comparison> {
    compare_knowing(study, &Computed::default())
}

/// The same for studies that differ in their counts alone.
pub(crate) fn compare_knowing(study: &Study<'_>, computed: &Computed) -> Vec<Comparison> {
    let lineage = study.lineage();
    let mut drafts = Vec::new();
    for (subject, margin) in study.subjects() {
        for (index, left) in study.evidence.iter().enumerate() {
            for right in &study.evidence[index + 1..] {
                let known = (&lineage, computed);
                drafts.extend(draft(study, known, &subject, margin, (left, right)));
            }
        }
    }
    correct(&mut drafts);
    let sharing = |alone: bool| {
        let tested = drafts.iter().filter(|draft| draft.is_tested());
        tested.filter(|draft| draft.is_alone() == alone).count()
    };
    let (family, of_one) = (sharing(false), sharing(true));
    drafts
        .into_iter()
        .map(|draft| {
            let family = if draft.is_alone() { of_one } else { family };
            draft.decide(&study.levels, family)
        })
        .collect()
}

/// A comparison before the correction for the number of comparisons.
struct Draft {
    comparison: Comparison,
    /// Why the pair is a fit, if it is.
    fit: Option<String>,
    /// Coincidences of their numbers that chance explains.
    noted: Vec<String>,
    /// Sides all of whose trials are of one person, session or other cluster, in words: what the tests show is of this one.
    of_one: Vec<String>,
    /// Whether a side is known to be 0 or 1, so that what one does refutes it.
    is_certain: bool,
    /// The statistics, where both sides have a number.
    pair: Option<Pair>,
    /// Why the pair cannot be compared, if it cannot.
    obstacle: Option<String>,
    /// Why one side is refuted by there being the other.
    impossible: Option<String>,
    /// The conditions of both sides, where they are comparable.
    conditions: String,
}

fn draft(
    study: &Study<'_>,
    (lineage, computed): (&Lineage<'_>, &Computed),
    subject: &Subject,
    margin: f64,
    (left, right): (&Evidence, &Evidence),
) -> Option<Draft> {
    if left.intermediate || right.intermediate {
        return None;
    }
    let findings = (left.finding(subject)?, right.finding(subject)?);
    let beliefs = (
        computed.belief(left, findings.0),
        computed.belief(right, findings.1),
    );
    let sides = ((left, findings.0), (right, findings.1));
    let fit = lineage.dependence(&left.id, &right.id, subject);
    let mut comparison = blank(subject, left, right, margin);
    comparison.independent = fit.is_none();
    comparison.possibly_copied = lineage.is_possible_copy(&left.id, &right.id, subject);
    comparison.paired = lineage.is_paired(&left.id, &right.id, subject);
    let mut noted = lineage.noted(&left.id, &right.id, subject);
    noted.extend(runs::total_unknown(sides.0, sides.1));
    let of_one = of_one_subject(subject, [left, right]);
    let is_certain = is_certain(findings.0) || is_certain(findings.1);
    match runs::triggers(sides.0, sides.1, margin, &study.levels) {
        Some(Ok(shares)) => comparison.trigger = Some(shares),
        Some(Err(reason)) => comparison.trigger_not_compared = Some(reason),
        None => {}
    }
    let (pair, obstacle) = match beliefs {
        (Ok(first), Ok(second)) => {
            let pair = paired(study, subject, margin, ((left, first), (right, second)));
            let obstacle =
                other_conditions(left, right).or_else(|| runs::other_runs(sides.0, sides.1));
            // Figures over different runs have no difference.
            if findings.0.is_over_the_same_runs(findings.1) {
                describe(&mut comparison, &pair, study.levels.confidence);
                comparison.looking = looking(&pair, left, right);
            }
            (Some(pair), obstacle)
        }
        (first, second) => {
            let reasons = (first.err(), second.err());
            (None, Some(missing(left, right, reasons)))
        }
    };
    let same_runs = lineage.same_runs(&left.id, &right.id);
    let same_runs = same_runs.map(|why| format!("{why}. They count once"));
    let obstacle = same_runs.or(obstacle);
    Some(Draft {
        comparison,
        fit,
        noted,
        of_one,
        is_certain,
        pair,
        obstacle,
        impossible: runs::impossible(sides.0, sides.1),
        conditions: left.conditions.clone(),
    })
}

/// The pair of two beliefs, looked at again where trials can be added to one of them.
fn paired(
    study: &Study<'_>,
    subject: &Subject,
    margin: f64,
    ((left, first), (right, second)): ((&Evidence, Belief), (&Evidence, Belief)),
) -> Pair {
    let may_grow = |piece: &Evidence, belief: &Belief| {
        is_open(piece) && matches!(belief, Belief::Counts { .. })
    };
    let looks = study
        .looks
        .filter(|_| may_grow(left, &first) || may_grow(right, &second));
    let before = looks.map(|looks| {
        let mut before = [
            looks.before(&left.id, subject, &first),
            looks.before(&right.id, subject, &second),
        ];
        // The last look is this one where it is recorded already.
        let is_now = |last: Option<&Option<Belief>>, now: &Belief| match (last, now) {
            (Some(Some(Belief::Counts { sample, .. })), Belief::Counts { sample: now, .. }) => {
                sample == now
            }
            (last, _) => matches!(last, Some(Some(_))),
        };
        if is_now(before[0].last(), &first) && is_now(before[1].last(), &second) {
            before.iter_mut().for_each(|side| drop(side.pop()));
        }
        before
    });
    let pair = Pair::new(first, second, margin);
    match before {
        Some(before) => pair.looked_at(before),
        None => pair,
    }
}

/// What it costs that a pair is looked at again.
fn looking(pair: &Pair, left: &Evidence, right: &Evidence) -> Option<Looking> {
    let look = pair.look()?;
    let of = |p: f64, once: f64| {
        format!(
            "{}, if this was the only look {}",
            p_value(p),
            p_value(once)
        )
    };
    let agreement = match pair.p_equivalence() {
        Some(p) => of(p, pair.doubt_of_equivalence_once()),
        None => "by its posterior probability".to_owned(),
    };
    Some(Looking {
        evidence: vec![left.id.clone(), right.id.clone()],
        look,
        interval: None,
        single_look_interval: None,
        statement: format!(
            "Look {look} at this pair; p-values allow for looks before and after it. Difference: p {}. Agreement: p \
             {agreement}.",
            of(pair.p_difference(), pair.p_difference_once())
        ),
    })
}

/// Fills in the figures that do not depend on the other comparisons.
fn describe(comparison: &mut Comparison, pair: &Pair, confidence: Confidence) {
    let interval = pair.difference_interval(confidence);
    comparison.difference = Some(pair.difference());
    comparison.difference_interval = Some(Interval {
        low: interval.low,
        high: interval.high,
    });
    comparison.p_difference = Some(pair.p_difference());
    comparison.p_equivalence = pair.p_equivalence();
    comparison.probability_within_margin = Some(pair.probability_within());
}

fn blank(subject: &Subject, left: &Evidence, right: &Evidence, margin: f64) -> Comparison {
    Comparison {
        subject: subject.clone(),
        left: left.id.clone(),
        right: right.id.clone(),
        outcome: Outcome::NotComparable,
        relation: None,
        independent: true,
        difference: None,
        difference_interval: None,
        margin,
        p_difference: None,
        p_difference_corrected: None,
        p_equivalence: None,
        probability_within_margin: None,
        possibly_copied: false,
        paired: false,
        clustering: None,
        trigger: None,
        trigger_not_compared: None,
        looking: None,
        further_trials: Vec::new(),
        reason: String::new(),
    }
}

/// Of which sides all trials are of one person, session or other cluster that does not stand for all.
fn of_one_subject(subject: &Subject, sides: [&Evidence; 2]) -> Vec<String> {
    let of_one = sides
        .into_iter()
        .filter(|it| it.is_of_one_subject_on(subject));
    of_one
        .map(|it| format!("all trials of {} are of {} alone", it.id, it.one_subject()))
        .collect()
}

/// Whether a rate is known to be 0 or 1, whatever the values of its constants: what one does that it excludes refutes it, whoever this
/// one is.
fn is_certain(finding: &Finding) -> bool {
    let Measure::Probability {
        answer, credible, ..
    } = &finding.measure
    else {
        return false;
    };
    let varies = credible
        .as_ref()
        .is_some_and(|it| it.interval.low < it.interval.high || it.ends.is_some());
    answer.guarantee.is_certain() && !varies && (answer.value == 0.0 || answer.value == 1.0)
}

fn other_conditions(left: &Evidence, right: &Evidence) -> Option<String> {
    (left.conditions != right.conditions).then(|| {
        format!(
            "Conditions differ: {} holds for \"{}\", {} for \"{}\".",
            left.id, left.conditions, right.id, right.conditions
        )
    })
}

fn missing(left: &Evidence, right: &Evidence, why: (Option<String>, Option<String>)) -> String {
    [(&left.id, why.0), (&right.id, why.1)]
        .into_iter()
        .filter_map(|(id, why)| Some(sentence(&format!("{id} {}", why?))))
        .collect::<Vec<_>>()
        .join(" ")
}

/// The correction over the pairs that are comparable, by closed testing. Those that are of one person alone cannot conflict, and take
/// nothing from the level of those that can: they are corrected by themselves, by Holm's procedure.
fn correct(drafts: &mut [Draft]) {
    let alone: Vec<(usize, f64)> = drafts
        .iter()
        .enumerate()
        .filter(|(_, draft)| draft.is_tested() && draft.is_alone())
        .filter_map(|(place, draft)| Some((place, draft.comparison.p_difference?)))
        .collect();
    let raw: Vec<f64> = alone.iter().map(|(_, p)| *p).collect();
    for ((place, _), corrected) in alone.iter().zip(stats::holm(&raw)) {
        drafts[*place].comparison.p_difference_corrected = Some(corrected);
    }
    let mut places = Vec::new();
    let mut tested = Vec::new();
    for (place, draft) in drafts.iter().enumerate() {
        if draft.is_alone() {
            continue;
        }
        if let (Some(pair), Some(p), true) = (
            &draft.pair,
            draft.comparison.p_difference,
            draft.is_tested(),
        ) {
            places.push(place);
            tested.push(closed::Tested {
                group: (&draft.comparison.subject, &draft.conditions),
                pieces: [&draft.comparison.left, &draft.comparison.right],
                pair,
                p,
            });
        }
    }
    let corrected = closed::corrected(&tested);
    for (place, corrected) in places.into_iter().zip(corrected) {
        drafts[place].comparison.p_difference_corrected = Some(corrected);
    }
}

impl Draft {
    /// Whether it is of one person, session or other cluster, so that it can be no conflict.
    fn is_alone(&self) -> bool {
        !self.of_one.is_empty() && !self.is_certain
    }

    fn is_tested(&self) -> bool {
        self.pair.is_some() && self.obstacle.is_none()
    }

    fn decide(mut self, levels: &Levels, family: usize) -> Comparison {
        match (self.pair.take(), self.obstacle.take()) {
            (Some(pair), None) => self.decide_tested(&pair, levels, family),
            (None, Some(obstacle)) if self.impossible.is_some() => {
                self.comparison.outcome = Outcome::Conflicts;
                self.comparison.reason = self.impossible.take().unwrap_or(obstacle);
            }
            (_, obstacle) => self.comparison.reason = obstacle.unwrap_or_default(),
        }
        if let Some(trigger) = &self.comparison.trigger
            && trigger.outcome != Outcome::Corroborates
        {
            self.comparison.reason = format!("{} {}", self.comparison.reason, trigger.reason);
        }
        self.comparison
    }

    fn decide_tested(&mut self, pair: &Pair, levels: &Levels, family: usize) {
        let corrected = self.comparison.p_difference_corrected.unwrap_or(1.0);
        let differ = corrected <= levels.confidence.alpha();
        let inside = pair.is_inside_margin();
        let agree = inside && pair.is_shown(self.comparison.p_equivalence, levels.agreement);
        let relation = Relation::of(differ, agree, inside);
        self.comparison.relation = Some(relation);
        self.comparison.outcome = match relation.outcome() {
            outcome if self.of_one.is_empty() => outcome,
            Outcome::Conflicts if self.is_certain => Outcome::Conflicts,
            _ => Outcome::Inconclusive,
        };
        let reason = match relation {
            Relation::Equivalent | Relation::TrivialDifference => {
                self.agreement_in_words(pair, differ)
            }
            Relation::Different | Relation::DifferenceWithinMargin => {
                self.difference_stated(pair, corrected, family)
            }
            Relation::Indeterminate | Relation::IndeterminateOutside => {
                self.doubt_in_words(pair, corrected, family)
            }
        };
        self.comparison.reason =
            reason + &pair.range_in_words() + &self.one_in_words(relation) + &self.fit_in_words();
    }

    /// What it means for the outcome that a side tells of one person, session or other cluster alone.
    fn one_in_words(&self, relation: Relation) -> String {
        if self.of_one.is_empty() || self.comparison.outcome == Outcome::Conflicts {
            return String::new();
        }
        let meaning = match relation.outcome() {
            Outcome::Corroborates => "This is not corroboration",
            Outcome::Conflicts => "This is not a conflict",
            Outcome::Inconclusive | Outcome::NotComparable => "It would decide nothing",
        };
        format!(
            " {meaning}: {}, and how others go is not known.",
            self.of_one.join(", ")
        )
    }

    /// What it means for the outcome that the pair is not independent.
    fn fit_in_words(&self) -> String {
        let Some(fit) = &self.fit else {
            let noted = self.noted.iter();
            return noted.map(|words| format!(" Note: {words}.")).collect();
        };
        let meaning = match (self.comparison.possibly_copied, self.comparison.outcome) {
            _ if self.comparison.paired => self.paired_in_words(),
            (true, Outcome::Corroborates) => "This agreement is possibly copied, not corroboration",
            (true, Outcome::Conflicts) => "They differ although one looks copied from the other",
            (true, _) => "One looks copied from the other, so that agreement would show nothing",
            (false, Outcome::Corroborates) => "This is a fit, not corroboration",
            (false, Outcome::Conflicts) => "They differ although they are not independent",
            (false, _) => "They are not independent, so that agreement would be a fit",
        };
        format!(" {meaning}: {fit}.")
    }

    /// What the outcome means of runs with the same seeds.
    fn paired_in_words(&self) -> &'static str {
        match self.comparison.outcome {
            Outcome::Corroborates => {
                "They agree on the same draws, which says less of all runs than two samples would"
            }
            Outcome::Conflicts => {
                "The draws are the same, so that the difference is not by the draw"
            }
            Outcome::Inconclusive | Outcome::NotComparable => {
                "They are tested as two samples, which is cautious where the same draws act alike in both"
            }
        }
    }

    fn agreement_in_words(&self, pair: &Pair, differ: bool) -> String {
        let mut words = format!(
            "They agree within {}: {}.",
            points(self.comparison.margin),
            self.test_in_words(pair)
        );
        if differ {
            words.push_str(" A difference is shown, too, but it is smaller than the margin (trivial difference).");
        }
        words
    }

    /// A difference that is shown, and on which side of the margin its estimate lies.
    fn difference_stated(&self, pair: &Pair, corrected: f64, family: usize) -> String {
        let size = points(self.comparison.difference.unwrap_or(0.0).abs());
        let margin = points(self.comparison.margin);
        let tests = self.corrected_in_words(pair, corrected, family);
        match pair.is_inside_margin() {
            false => {
                format!("They differ by {size}, beyond chance ({tests}); the margin is {margin}.")
            }
            true => format!(
                "They differ by {size}, beyond chance ({tests}), within the margin of {margin}: no conflict, but \
                 agreement is not yet shown ({}).",
                self.test_in_words(pair)
            ),
        }
    }

    /// The p-value of "no difference" by itself and, where others are compared, too, corrected for them.
    fn corrected_in_words(&self, pair: &Pair, corrected: f64, family: usize) -> String {
        let own = self.difference_in_words(pair);
        match family {
            0 | 1 => own,
            _ => format!(
                "{own}; corrected for {family} comparisons p {}",
                p_value(corrected)
            ),
        }
    }

    fn doubt_in_words(&self, pair: &Pair, corrected: f64, family: usize) -> String {
        // The correction is said where it may be what leaves it open.
        let shown = match self.comparison.p_difference.is_some_and(|p| p < NOTABLE) {
            true => self.corrected_in_words(pair, corrected, family),
            false => self.difference_in_words(pair),
        };
        format!(
            "Neither a difference ({shown}) nor agreement within {} ({}) is shown.{}",
            points(self.comparison.margin),
            self.test_in_words(pair),
            match pair.is_inside_margin() {
                true => String::new(),
                false => format!(
                    " The estimated difference of {} is outside the margin.",
                    points(self.comparison.difference.unwrap_or(0.0).abs())
                ),
            }
        )
    }

    /// The p-value of "no difference", with Fisher's where that is another one; where the pair is looked at again they are those over all
    /// looks, not of the tests at this one.
    fn difference_in_words(&self, pair: &Pair) -> String {
        let p = p_value(self.comparison.p_difference.unwrap_or(1.0));
        let fishers = pair
            .p_by_fisher()
            .map(p_value)
            .filter(|fishers| *fishers != p);
        let over = match pair.look() {
            Some(_) => " over all looks",
            None => "",
        };
        match fishers {
            Some(fishers) => format!("p {p}, by Fisher's test {fishers}{over}"),
            None => format!("p {p}{over}"),
        }
    }

    /// How agreement was tested; two computed values need no test.
    fn test_in_words(&self, pair: &Pair) -> String {
        if matches!(
            (pair.first(), pair.second()),
            (Belief::Known { .. }, Belief::Known { .. })
        ) {
            return "both are computed".to_owned();
        }
        let within = probability(self.comparison.probability_within_margin.unwrap_or(0.0));
        match self.comparison.p_equivalence {
            Some(p) => format!(
                "two one-sided tests p {}, probability of a smaller difference {within}",
                p_value(p)
            ),
            None => format!("probability of a smaller difference {within}"),
        }
    }
}
