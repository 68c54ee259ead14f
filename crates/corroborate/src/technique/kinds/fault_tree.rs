//! Fault trees as a technique: how probable events of a tree are is found exactly, and found again.
//!
//! # Definition
//! An event of the tree is the violation of a requirement, whose rate is then `1 - P(event)`, or the occurrence of a failure
//! mode, whose rate is `P(event)`. Nothing is said of what has no event.
//!
//! A basic event that the ledger says to be set to counts has the Jeffreys posterior of these, independent of the others; so
//! has one that the tree itself gives counts (the Open-PSA format's `occurrences` and `trials`). Basic events that were set
//! to the same counts, as identical parts are, have one unknown rate between them. The posterior of the rate is
//! found at the points of a low-discrepancy design, with each basic event's share in its variance (`stats::SharesDesign`), as
//! of a formal model (`super::super::model_checking`).
//!
//! # Assumes
//! Basic events are independent of each other, but those that were set to the same counts, which have one rate. Counts are
//! of independent trials, or at their effective size.
//!
//! # Guarantee
//! Of the value that of `fault_tree`: exact, or between bounds; of the distribution none but convergence, and that basic
//! events are independent, which the tree assumes. Ranges of basic events and counts are not carried on together: no
//! distribution belongs to the former.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::run::{check_constants, counted_constants};
use crate::technique::counted::{CountedConstant, Sources, counts_as_inputs};
use crate::technique::files::Files;
use crate::technique::{Influence, Produced};
use crate::verify::Audit;
use diagnostic::{Cancel, Problem, Source};
use evidence::{
    AssetRole, Cost, CredibleInterval, Denominator, Finding, Guarantee, Measure, MethodAnswer,
    Subject, Tool,
};
use fault_tree::{Analysis, EventData, FaultTree, NodeId, NodeKind, Options, Settings};
use host::store::Inputs;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use study::{TreeEvent, Work};

/// Points of the design for each counted basic event and two more, and how many nodes of diagrams are visited at most for
/// all of them; then there are fewer, and no fewer than [`FEWEST_POINTS`].
const POINTS: usize = 8192;
const MOST_VISITS: usize = 400_000_000;
const FEWEST_POINTS: usize = 250;

/// A longer rational number is not shown.
const LONGEST_RATIONAL: usize = 60;

/// Minimal cut sets and basic events that are named.
const NAMED: usize = 3;

/// A fault tree, and what of it is asked.
pub(super) struct FaultTrees<'t> {
    pub(super) tree: &'t Path,
    pub(super) mission_time: Option<f64>,
    pub(super) events: &'t [TreeEvent],
    pub(super) is_triggered: bool,
}

/// A tree that was read.
struct Ready<'a> {
    asked: Asked<'a>,
    /// With counts replaced by their rates.
    tree: FaultTree,
    /// What the tree itself counts, by basic event.
    own_counts: Vec<CountedConstant>,
    /// By subject.
    events: Vec<(Subject, NodeId)>,
    is_triggered: bool,
}

impl Technique for FaultTrees<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        Ok(Box::new(self.read(asked, files)?))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        true
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let ready = self.read(asked, &Files::of_study(asked.study))?;
        let value_of = |name: &str| ready.constant(name);
        let counted = counted_constants(asked.study, asked.entry, kept.before, &value_of)?;
        let again = ready.analysed(&counted)?;
        let what = "values of evidence follow from analysing its fault tree again";
        kept.is(again, what, audit)
    }
}

/// What of a fault tree is otherwise than its entry has it.
pub(crate) enum TreeChange<'t> {
    /// The time under way.
    MissionTime(f64),
    /// The text of the tree.
    Text(&'t str),
}

/// What an entry's fault tree answers by its plain values with a change, by subject.
///
/// # Errors
/// What cannot be read or analysed; an entry of another technique answers nothing.
pub(crate) fn tree_values(
    asked: Asked<'_>,
    change: &TreeChange<'_>,
) -> Result<BTreeMap<Subject, Option<f64>>, Problem> {
    let Work::FaultTree {
        tree,
        mission_time,
        events,
        is_triggered,
    } = &asked.entry.work
    else {
        return Ok(BTreeMap::new());
    };
    let trees = FaultTrees {
        tree,
        mission_time: match change {
            TreeChange::MissionTime(time) => Some(*time),
            TreeChange::Text(_) => *mission_time,
        },
        events,
        is_triggered: *is_triggered,
    };
    let source = match change {
        TreeChange::MissionTime(_) => {
            Files::of_study(asked.study).text(AssetRole::SystemModel, tree)?
        }
        TreeChange::Text(text) => Source {
            name: tree.display().to_string(),
            text: (*text).to_owned(),
        },
    };
    let ready = trees.read_source(asked, &source)?;
    let mut found = BTreeMap::new();
    for (subject, event) in &ready.events {
        let analysis = Analysis::new(&ready.tree, *event, Options::default(), &asked.host.cancel)?;
        let answer = ready.answer(subject, &analysis)?;
        found.insert(subject.clone(), Some(answer.value));
    }
    Ok(found)
}

impl FaultTrees<'_> {
    fn read<'a>(&self, asked: Asked<'a>, files: &Files<'_>) -> Result<Ready<'a>, Problem> {
        let source = files.text(AssetRole::SystemModel, self.tree)?;
        self.read_source(asked, &source)
    }

    fn read_source<'a>(&self, asked: Asked<'a>, source: &Source) -> Result<Ready<'a>, Problem> {
        let settings = Settings {
            mission_time: self
                .mission_time
                .and_then(|time| fault_tree::decimal(&time.to_string())),
        };
        let is_xml = self.tree.extension().is_some_and(|it| it == "xml");
        let reading = match is_xml {
            true => fault_tree::read_open_psa(source, &settings)?,
            false => fault_tree::read_galileo(source, &settings)?,
        };
        for warning in &reading.warnings {
            asked.host.events.say(&warning.warning_line());
        }
        let events = self.events.iter().map(|event| {
            let found = reading.tree.event(&event.event);
            let place = |it: Problem| it.at(&asked.study.ledger_source, event.span.clone());
            Ok((event.subject.clone(), found.map_err(place)?))
        });
        let events = events.collect::<Result<_, Problem>>()?;
        let own_counts = counts_of(&reading.tree);
        let rates = own_counts.iter().map(own_rate).collect();
        let ready = Ready {
            asked,
            tree: reading.tree.with_data(&rates)?,
            own_counts: own_counts.iter().map(own_constant).collect(),
            events,
            is_triggered: self.is_triggered,
        };
        let names: Vec<&str> = ready.basic_events().map(|id| ready.tree.name(id)).collect();
        let value_of = |name: &str| ready.constant(name);
        let all = ("basic events with a probability", names.as_slice());
        check_constants(asked.study, asked.entry, all, &value_of)?;
        Ok(ready)
    }
}

/// What a tree counts itself, by basic event.
fn counts_of(tree: &FaultTree) -> Vec<(String, stats::Sample)> {
    let of = |(id, node): (NodeId, &fault_tree::Node)| match &node.kind {
        NodeKind::Basic(Some(EventData::Counts {
            occurrences: successes,
            trials,
        })) => {
            let sample = stats::Sample::new(*successes, *trials).ok()?;
            Some((tree.name(id).to_owned(), sample))
        }
        NodeKind::Basic(_) | NodeKind::House(_) | NodeKind::Gate(..) => None,
    };
    tree.nodes().filter_map(of).collect()
}

/// A basic event that the tree counts itself.
fn own_constant((name, sample): &(String, stats::Sample)) -> CountedConstant {
    CountedConstant {
        name: name.clone(),
        posterior: stats::BetaPosterior::jeffreys(*sample),
        from: String::new(),
        subject: Subject::FailureMode(name.clone()),
        is_complement: false,
        held: false,
        solved_for: None,
    }
}

/// The rate that stands for counts where one number is asked.
fn own_rate((name, sample): &(String, stats::Sample)) -> (String, EventData) {
    let rate = fault_tree::BigRational::new(sample.successes.into(), sample.trials.into());
    (name.clone(), EventData::Probability(rate))
}

impl Ready<'_> {
    fn basic_events(&self) -> impl Iterator<Item = NodeId> {
        self.tree.basic_events().into_iter()
    }

    fn data(&self, name: &str) -> Option<&EventData> {
        match &self.tree.node(self.tree.find(name)?).kind {
            NodeKind::Basic(data) => data.as_ref(),
            NodeKind::House(_) | NodeKind::Gate(..) => None,
        }
    }

    /// All findings. Of basic events that are both set to counts and counted by the tree, the ledger's counts are taken.
    fn analysed(&self, counted: &[CountedConstant]) -> Result<Produced, Problem> {
        let began = Instant::now();
        let cancel = &self.asked.host.cancel;
        let own = self.own_counts.iter();
        let own = own.filter(|it| counted.iter().all(|other| other.name != it.name));
        let all: Vec<CountedConstant> = counted.iter().chain(own).cloned().collect();
        let (held, varied): (Vec<_>, Vec<_>) = all.into_iter().partition(|it| it.held);
        let mut findings = Vec::new();
        let mut told = Vec::new();
        let mut influences = Vec::new();
        for (subject, event) in &self.events {
            let analysis = Analysis::new(&self.tree, *event, Options::default(), cancel)?;
            let answer = self.answer(subject, &analysis)?;
            let credible = self.credible(subject, &analysis, &varied)?;
            findings.push(Finding {
                subject: subject.clone(),
                measure: Measure::Probability {
                    credible: credible.map(|it| it.beside(answer.value)),
                    answer,
                    others: Vec::new(),
                },
                denominator: match self.is_triggered {
                    true => Denominator::Triggered,
                    false => Denominator::NoTrigger,
                },
                trigger: None,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            });
            told.push(self.in_words(*event, &analysis)?);
            influences.extend(self.influences(subject, &analysis, &held));
        }
        Ok(Produced {
            tool: Tool {
                name: "corroborate fault trees".into(),
                version: env!("CARGO_PKG_VERSION").into(),
                settings: format!("decision diagrams, exact; {}", told.join("; ")),
            },
            findings,
            form_differences: Vec::new(),
            description_gaps: Vec::new(),
            failures: Vec::new(),
            clusters: None,
            alike_trials: None,
            repeated_recordings: Vec::new(),
            findings_once: Vec::new(),
            influences,
            cost: Cost {
                evidence: self.asked.entry.id.clone(),
                wall_secs: began.elapsed().as_secs_f64(),
                ..Cost::default()
            },
        })
    }

    /// The rate of a subject, with the basic events as they are written.
    fn answer(&self, subject: &Subject, analysis: &Analysis<'_>) -> Result<MethodAnswer, Problem> {
        let found = analysis.probability(&self.asked.host.cancel)?;
        let bounds = found.bounds;
        let (low, high) = match subject {
            Subject::FailureMode(_) => (bounds.lower, bounds.upper),
            Subject::Requirement(_) => (1.0 - bounds.upper, 1.0 - bounds.lower),
        };
        // Of one number any within the bounds is as good; of a range its middle stands for it.
        let (value, contrary) = (
            f64::midpoint(low, high),
            f64::midpoint(bounds.lower, bounds.upper),
        );
        let one = fault_tree::BigRational::from_integer(1.into());
        let rational = found.exact.as_ref().map(|exact| match subject {
            Subject::FailureMode(_) => exact.to_string(),
            Subject::Requirement(_) => (one - exact).to_string(),
        });
        // One step outwards: the subtraction rounds.
        let (below, above) = (low.next_down().max(0.0), high.next_up().min(1.0));
        let known = found.guarantee.between(below, above);
        let rational = rational.filter(|text| text.len() <= LONGEST_RATIONAL);
        let guarantee = Guarantee::of(&known, rational);
        Ok(MethodAnswer {
            method: "exact".into(),
            value,
            complement: match subject {
                Subject::FailureMode(_) => None,
                Subject::Requirement(_) => Some(contrary),
            },
            guarantee,
            iterations: None,
        })
    }

    /// The posterior of a rate, where counted basic events bear on it.
    fn credible(
        &self,
        subject: &Subject,
        analysis: &Analysis<'_>,
        varied: &[CountedConstant],
    ) -> Result<Option<CredibleInterval>, Problem> {
        let support = analysis.support();
        let (constants, ids): (Vec<CountedConstant>, Vec<NodeId>) = varied
            .iter()
            .filter_map(|it| Some((it.clone(), self.tree.find(&it.name)?)))
            .filter(|(_, id)| support.contains(id))
            .unzip();
        if constants.is_empty() {
            return Ok(None);
        }
        self.has_no_ranges(&support)?;
        let study = self.asked.study;
        let level = crate::technique::confidence(study.about.confidence)?;
        let sources = Sources::of(&constants);
        let wanted = POINTS * (sources.posteriors.len() + 2);
        let affordable = (MOST_VISITS / analysis.nodes().max(1)).max(FEWEST_POINTS);
        let design = stats::SharesDesign::new(
            &sources.posteriors,
            wanted.min(affordable),
            study.about.seed,
        );
        let cancel = &self.asked.host.cancel;
        let rate = |point: &Vec<f64>| {
            let rates = sources.constants_at(point);
            let instead: Vec<(NodeId, f64)> = ids.iter().copied().zip(rates).collect();
            let found = analysis.probability_at(&instead, cancel)?;
            let probability = f64::midpoint(found.lower, found.upper);
            Ok(match subject {
                Subject::FailureMode(_) => probability,
                Subject::Requirement(_) => 1.0 - probability,
            })
        };
        let values: Vec<f64> = design
            .rows()
            .par_iter()
            .map(rate)
            .collect::<Result<_, Problem>>()?;
        let names: Vec<&str> = sources.names.iter().map(String::as_str).collect();
        let found = CredibleInterval::of_design(&names, &design, &values, level)
            .map_err(|error| Problem::new("cannot-carry-uncertainty", error.to_string()))?;
        Ok(Some(CredibleInterval {
            by_function: true,
            ..found
        }))
    }

    /// Refuses basic events with ranges beside counted ones.
    fn has_no_ranges(&self, support: &[NodeId]) -> Result<(), Problem> {
        let is_range = |id: &&NodeId| {
            let data = self.data(self.tree.name(**id));
            matches!(data, Some(EventData::Interval { lower, upper }) if lower < upper)
        };
        let Some(range) = support.iter().find(is_range) else {
            return Ok(());
        };
        let message = format!(
            "the fault tree of {} has counts, and a range for `{}`: no distribution belongs to a range, so the uncertainty of \
             both cannot be carried on together",
            self.asked.entry.id,
            self.tree.name(*range)
        );
        Err(Problem::new("cannot-carry-uncertainty", message)
            .about(&self.asked.entry.id)
            .remedy(
                "give the event a probability or counts, or leave the counts out (`held = true`)",
            ))
    }

    /// Which failure modes, through basic events that are held, bear on a requirement.
    fn influences(
        &self,
        subject: &Subject,
        analysis: &Analysis<'_>,
        held: &[CountedConstant],
    ) -> Vec<Influence> {
        let support = analysis.support();
        let of = |constant: &CountedConstant| match (subject, &constant.subject) {
            (Subject::Requirement(requirement), Subject::FailureMode(mode)) => Some(Influence {
                requirement: requirement.clone(),
                failure_mode: mode.clone(),
                bears: self
                    .tree
                    .find(&constant.name)
                    .is_some_and(|id| support.contains(&id)),
            }),
            (Subject::Requirement(_) | Subject::FailureMode(_), _) => None,
        };
        held.iter().filter_map(of).collect()
    }

    /// The smallest cut sets of an event, and which basic events matter most.
    fn in_words(&self, event: NodeId, analysis: &Analysis<'_>) -> Result<String, Problem> {
        let cancel: &Cancel = &self.asked.host.cancel;
        let name = |id: &NodeId| self.tree.name(*id).to_owned();
        let sets = analysis.cut_sets(NAMED, cancel)?;
        let shown: Vec<String> = sets
            .sets
            .iter()
            .map(|set| set.iter().map(name).collect::<Vec<_>>().join(" and "))
            .collect();
        let kind = match sets.kind {
            fault_tree::CutSetKind::MinimalCutSets => "minimal cut sets",
            fault_tree::CutSetKind::MinimalSolutions => "minimal solutions",
        };
        let mut parts: Vec<(String, f64)> = analysis
            .importance(cancel)?
            .iter()
            .filter_map(|it| {
                let part = it.criticality?;
                Some((name(&it.event), f64::midpoint(part.lower, part.upper)))
            })
            .collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        let parts: Vec<String> = parts
            .iter()
            .take(NAMED)
            .map(|(name, part)| format!("{name} {:.1} %", 100.0 * part))
            .collect();
        Ok(format!(
            "{}: {} {kind}, the smallest {}; without them less by {}",
            self.tree.name(event),
            sets.count,
            shown.join(", "),
            parts.join(", ")
        ))
    }
}

impl Prepared for Ready<'_> {
    fn settings(&self, counted: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem> {
        counts_as_inputs(counted, inputs);
        Ok(())
    }

    fn constant(&self, name: &str) -> Option<f64> {
        self.data(name)?.value()
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        None
    }

    fn obstacle(&self) -> Option<&Problem> {
        None
    }

    fn not_allowed(&self) -> Option<&Problem> {
        None
    }

    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem> {
        self.analysed(working.counted)
    }

    fn kept_episodes(&self, _: &Path) -> Result<Option<u64>, Problem> {
        Ok(None)
    }
}
