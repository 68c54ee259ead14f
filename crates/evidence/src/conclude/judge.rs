//! What is asked of one requirement, and how its pieces stand at the levels of the study.
//!
//! # Assumes
//! Each test holds its level. Nothing of how the tests that share a level depend on each other (Bonferroni).

use super::ladder::{Apart, Judged};
use super::levels::{Test, divisors};
use super::stand::{ClaimLevels, Named, can_err, doubts, stand};
use super::transfer::{Transfer, transfers};
use super::words::is_certainty;
use super::{
    Piece, among_current, current, elsewhere, independent, is_trial, looked_at, quantity,
    threshold_of,
};
use crate::compare::{Lineage, Study};
use crate::{
    Comparison, Direction, ErrorFamily, Outcome, Relation, Requirement, Step, Subject, Threshold,
};

/// A requirement with all that is judged on it.
pub(crate) struct Asked<'a> {
    pub requirement: &'a Requirement,
    pub quantity: Subject,
    pub threshold: Threshold,
    /// The current evidence.
    pub pieces: Vec<Piece<'a>>,
    /// Of each of these whether it may decide: all but trials that rest on other trials, and those of one subject alone.
    pub decides: Vec<bool>,
    /// Evidence under other conditions.
    pub elsewhere: Vec<Piece<'a>>,
    pub transfers: Vec<Transfer<'a>>,
    /// Comparisons of two current pieces on the quantity.
    pub among: Vec<&'a Comparison>,
}

/// The pieces that share a claim's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    /// Trials of the system, and models that carry over to it.
    System,
    /// Simulations and models that speak of themselves.
    Models,
}

/// The levels of one requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Level {
    system: ClaimLevels,
    models: ClaimLevels,
    /// How many quantities share the level of trials of the system.
    pub quantities: usize,
    /// How many would, if one more were counted.
    pub with_one_more: usize,
}

impl<'a> Asked<'a> {
    pub fn new(
        study: &Study<'a>,
        lineage: &Lineage<'_>,
        requirement: &'a Requirement,
        comparisons: &'a [Comparison],
    ) -> Self {
        let mut asked = Self::without_comparisons(study, lineage, requirement);
        asked.transfers = transfers(study, requirement, &asked.pieces, comparisons);
        asked.among = among_current(comparisons, &asked.quantity, &asked.pieces);
        asked
    }

    /// The same on other evidence, with the comparisons that were made.
    pub fn on_other_evidence(study: &Study<'a>, lineage: &Lineage<'_>, asked: &Asked<'a>) -> Self {
        Self {
            transfers: asked.transfers.clone(),
            among: asked.among.clone(),
            ..Self::without_comparisons(study, lineage, asked.requirement)
        }
    }

    fn without_comparisons(
        study: &Study<'a>,
        lineage: &Lineage<'_>,
        requirement: &'a Requirement,
    ) -> Self {
        let quantity = quantity(study.requirements, requirement);
        let pieces = current(study.evidence, requirement, &quantity);
        let pieces = looked_at(study, pieces, (requirement, &quantity));
        let threshold = threshold_of(requirement);
        let trials: Vec<Piece> = pieces
            .iter()
            .filter(|piece| is_trial(piece.evidence) && may_decide(piece, threshold))
            .cloned()
            .collect();
        let free: Vec<&str> = independent(&trials, lineage, &quantity)
            .into_iter()
            .map(|index| trials[index].evidence.id.as_str())
            .collect();
        let decides = pieces
            .iter()
            .map(|piece| match is_trial(piece.evidence) {
                true => free.contains(&piece.evidence.id.as_str()),
                false => may_decide(piece, threshold),
            })
            .collect();
        Self {
            requirement,
            threshold,
            elsewhere: looked_at(
                study,
                elsewhere::elsewhere(study.evidence, requirement, &quantity, &pieces),
                (requirement, &quantity),
            ),
            transfers: Vec::new(),
            among: Vec::new(),
            decides,
            pieces,
            quantity,
        }
    }

    /// Independent current pieces that are shown to differ.
    pub fn apart(&self) -> Apart {
        let is_of_one = |id: &str| {
            let mut pieces = self.pieces.iter();
            pieces.any(|it| it.evidence.id == id && it.is_of_one_subject())
        };
        let of = |wanted: &dyn Fn(&Comparison) -> bool| {
            let all = self.among.iter();
            // How one person, session or other cluster differs is said of this one.
            let all = all.filter(|it| {
                !is_of_one(&it.left) && !is_of_one(&it.right) || it.outcome == Outcome::Conflicts
            });
            // Runs with the same draws differ by what draws them not alike: the more a difference.
            all.filter(|it| wanted(it) && (it.independent || it.paired))
                .map(|it| (it.left.clone(), it.right.clone()))
                .collect()
        };
        Apart {
            conflicts: of(&|it| it.outcome == Outcome::Conflicts),
            within_margin: of(&|it| {
                matches!(
                    it.relation,
                    Some(Relation::TrivialDifference | Relation::DifferenceWithinMargin)
                )
            }),
        }
    }

    /// The current pieces that may decide in a group.
    fn of_group(&self, group: Group) -> impl Iterator<Item = &Piece<'a>> {
        let pieces = self.pieces.iter().zip(&self.decides);
        pieces
            .filter(move |(piece, decides)| **decides && group_of(piece) == group)
            .map(|(piece, _)| piece)
    }

    /// Whether trials of a piece can decide it.
    pub fn may_decide(&self, piece: &Piece<'_>) -> bool {
        may_decide(piece, self.threshold)
    }

    /// The pieces under other conditions that may decide in a group.
    fn elsewhere_of(&self, group: Group) -> impl Iterator<Item = &Piece<'a>> {
        let pieces = self.elsewhere.iter();
        pieces.filter(move |it| group_of(it) == group && self.may_decide(it))
    }

    /// How many tests share the level of "met" and of "missed" in a group.
    fn sharing(&self, group: Group) -> (usize, usize) {
        let can_err = |piece: &&Piece| can_err(&piece.belief, self.threshold);
        let here = self.of_group(group).filter(can_err).count();
        let elsewhere = self.elsewhere_of(group);
        let carried = match group {
            // Also those that show nothing: which of them do is not known before.
            Group::System => self.transfers.len(),
            Group::Models => 0,
        };
        let met = here + carried;
        (met.max(1), (met + elsewhere.filter(can_err).count()).max(1))
    }

    /// The p-values of "not met" and "met" in a group, corrected for the tests that share it; `None` if none can err.
    fn p_values(&self, group: Group) -> (Option<f64>, Option<f64>) {
        let (met, missed) = self.sharing(group);
        let least = |values: Vec<f64>, count: usize| {
            let least = values.into_iter().reduce(f64::min);
            least.map(|p| (p * count as f64).min(1.0))
        };
        let of = |piece: &Piece| doubts(&piece.belief, self.threshold);
        let can_err = |piece: &&Piece| can_err(&piece.belief, self.threshold);
        let mut here: Vec<(f64, f64)> = self.of_group(group).filter(can_err).map(of).collect();
        if group == Group::System {
            let margin = self.requirement.margin;
            // Also what shows no agreement, with p-values of 1: a family of those alone that do would be chosen by the data.
            let carried = self.transfers.iter();
            here.extend(carried.map(|it| it.doubts(self.threshold, margin)));
        }
        let there = self.elsewhere_of(group);
        let there: Vec<(f64, f64)> = there.filter(can_err).map(of).collect();
        let not_met = here.iter().map(|p| p.0).collect();
        let is_met = here.iter().chain(&there).map(|p| p.1).collect();
        (least(not_met, met), least(is_met, missed))
    }

    /// How every piece stands.
    pub fn judge(&self, level: &Level) -> Vec<Judged> {
        let judged = |piece: &Piece, decides: bool, elsewhere: bool| {
            let levels = level.of(group_of(piece));
            let named = self.named(piece);
            let mut standing = stand(named, &piece.belief, self.threshold, levels);
            standing.elsewhere = elsewhere;
            standing.words += &of_one_subject(piece);
            Judged {
                standing,
                decides,
                conditions: piece.evidence.conditions.clone(),
            }
        };
        let here = self.pieces.iter().zip(&self.decides);
        let mut all: Vec<Judged> = here
            .map(|(piece, decides)| judged(piece, *decides, false))
            .collect();
        all.extend(self.transfers.iter().map(|transfer| Judged {
            standing: transfer.stand(self, level.system),
            decides: true,
            conditions: transfer.piece.evidence.conditions.clone(),
        }));
        let there = self.elsewhere.iter();
        all.extend(there.map(|piece| judged(piece, self.may_decide(piece), true)));
        all
    }

    /// A piece as its figures name it.
    pub fn named<'n>(&'n self, piece: &'n Piece<'a>) -> Named<'n> {
        Named {
            id: &piece.evidence.id,
            step: Step::of(piece.evidence.technique),
            finding: piece.finding,
            trigger: self.requirement.trigger.as_deref(),
        }
    }

    /// What the levels are of: the quantity by its own name where any piece has a number of its own, and the side.
    fn unit(&self, units: &mut Vec<(Subject, Direction)>) -> usize {
        let own = Subject::Requirement(self.requirement.id.clone());
        let has_own = |piece: &Piece| piece.evidence.finding(&own).is_some();
        let subject = match self.pieces.iter().any(has_own) {
            true => own,
            false => self.quantity.clone(),
        };
        let unit = (subject, self.threshold.direction);
        let known = units.iter().position(|other| *other == unit);
        known.unwrap_or_else(|| {
            units.push(unit);
            units.len() - 1
        })
    }
}

/// Whether evidence may decide a requirement: what is of one person, session or other cluster tells of this one alone, whether
/// the system was tried or simulated, but for certainty, which one violation refutes, whoever's it is.
fn may_decide(piece: &Piece<'_>, threshold: Threshold) -> bool {
    !piece.is_of_one_subject() || is_certainty(threshold)
}

/// Whose figure it is, where all trials are of one person, session or other cluster.
fn of_one_subject(piece: &Piece<'_>) -> String {
    let declared = piece
        .evidence
        .clusters
        .as_ref()
        .and_then(|it| it.one_for_all.as_ref());
    let one = piece.evidence.one_subject();
    match declared {
        Some(because) => {
            format!(", of {one}, declared to stand for all (\"{because}\")")
        }
        None if piece.is_of_one_subject() => format!(", of {one} alone"),
        None => String::new(),
    }
}

fn group_of(piece: &Piece<'_>) -> Group {
    match is_trial(piece.evidence) {
        true => Group::System,
        false => Group::Models,
    }
}

impl Level {
    fn of(&self, group: Group) -> ClaimLevels {
        match group {
            Group::System => self.system,
            Group::Models => self.models,
        }
    }

    /// The same share of the study's level, divided among the pieces of another requirement.
    pub fn shared_as(&self, before: &Asked<'_>, after: &Asked<'_>) -> Self {
        let of = |group: Group| {
            let (old, new) = (before.sharing(group), after.sharing(group));
            let ratio = |old: usize, new: usize| old as f64 / new as f64;
            ClaimLevels {
                met: self.of(group).met * ratio(old.0, new.0),
                missed: self.of(group).missed * ratio(old.1, new.1),
            }
        };
        Self {
            system: of(Group::System),
            models: of(Group::Models),
            ..*self
        }
    }

    /// The level of a claim of trials of the system.
    pub fn of_trials(&self) -> ClaimLevels {
        self.system
    }
}

/// p-values against "met" and against "missed", where there are any.
type PValues = (Option<f64>, Option<f64>);

/// The levels of all requirements.
pub(super) fn levels(study: &Study<'_>, asked: &[Asked<'_>]) -> Vec<Level> {
    let (alpha, family) = (study.levels.confidence.alpha(), study.levels.family);
    let mut known = Vec::new();
    let units: Vec<usize> = asked.iter().map(|it| it.unit(&mut known)).collect();
    let of = |group: Group| -> (Vec<ClaimLevels>, Vec<usize>) {
        let p: Vec<PValues> = asked.iter().map(|it| it.p_values(group)).collect();
        let tests = |of: fn(&PValues) -> Option<f64>| {
            let pairs = units.iter().zip(&p);
            pairs
                .map(|(unit, p)| Test {
                    unit: *unit,
                    p: of(p),
                })
                .collect::<Vec<Test>>()
        };
        let met = divisors(&tests(|p| p.0), alpha, family);
        let missed = divisors(&tests(|p| p.1), alpha, family);
        let levels = asked.iter().enumerate().map(|(index, it)| {
            let sharing = it.sharing(group);
            ClaimLevels {
                met: alpha / (met[index] * sharing.0) as f64,
                missed: alpha / (missed[index] * sharing.1) as f64,
            }
        });
        (levels.collect(), shared(&tests(|p| p.1), family))
    };
    let (system, quantities) = of(Group::System);
    let (models, _) = of(Group::Models);
    let all = system.into_iter().zip(models).zip(quantities);
    all.map(|((system, models), quantities)| Level {
        system,
        models,
        quantities,
        with_one_more: match family {
            ErrorFamily::Study => quantities + 1,
            ErrorFamily::Requirement => 1,
        },
    })
    .collect()
}

/// How many units share the level of each test.
fn shared(tests: &[Test], family: ErrorFamily) -> Vec<usize> {
    let mut units: Vec<usize> = tests
        .iter()
        .filter(|t| t.p.is_some())
        .map(|t| t.unit)
        .collect();
    units.sort_unstable();
    units.dedup();
    let count = match family {
        ErrorFamily::Study => units.len(),
        ErrorFamily::Requirement => units.len().min(1),
    };
    vec![count; tests.len()]
}
