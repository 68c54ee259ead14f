//! From what the techniques produced to what the study says.

use crate::outcome::Outcome;
use crate::published;
use crate::technique::experiment::repeated;
use crate::technique::{Influence, Produced, copies, counting_undecided, repeated_question};
use diagnostic::Problem;
use evidence::{
    Asset, Clue, Conclusion, Cost, CoverageGap, Denominator, Evidence, Inaccuracy, Matter, Measure,
    StudyResult, Subject, SuspectAsset, SuspectKind, Symptom, TableOf, Verdict,
};
use study::{Entry, Study};

/// Version of the form of `study.json`.
pub const FORMAT: &str = "1.0";

/// How commands that are kept name the study: results do not depend on where it lies.
pub const ANY_STUDY: &str = "STUDY";

/// One entry of the ledger with its evidence.
#[derive(Debug)]
pub struct Piece {
    /// The evidence.
    pub evidence: Evidence,
    /// What it took.
    pub cost: Cost,
    /// Its main figure, for the terminal.
    pub headline: String,
    /// Figures of the source publication, beside ours.
    pub published: Vec<evidence::PublishedFigure>,
    /// What a formal model tells of failure modes and requirements.
    pub influences: Vec<Influence>,
    /// Constants that do not have the value of the counts they were set to.
    pub drifted: Vec<Clue>,
}

/// Puts an entry and what was produced for it together.
pub fn piece(
    study: &Study,
    entry: &Entry,
    assets: Vec<Asset>,
    inputs: String,
    produced: Produced,
) -> Result<Piece, Problem> {
    let headline = headline(study, &produced);
    let published = published::figures(study, entry, &produced);
    let cost = Cost {
        published: entry.published.cost.clone(),
        ..produced.cost
    };
    let conditions = study.about.conditions.get(&entry.conditions);
    let technique = entry.work.technique();
    let declared = entry.work.parts().recordings.and_then(|it| it.repeated);
    let repeated = repeated_question(&entry.id, &produced.repeated_recordings, declared);
    let is_published = technique.is_of_simulator() && entry.work.is_read();
    let once = counting_undecided(study, entry, produced.findings_once)?;
    let findings = counting_undecided(study, entry, produced.findings)?.into_iter();
    // What of it may be told twice counts with and without.
    let findings =
        findings.map(
            |finding| match once.iter().find(|it| it.subject == finding.subject) {
                Some(once) => finding.or_once(once),
                None => finding,
            },
        );
    Ok(Piece {
        evidence: Evidence {
            id: entry.id.clone(),
            title: entry.title.clone(),
            technique,
            tool: produced.tool,
            assets,
            conditions: conditions
                .cloned()
                .unwrap_or_else(|| entry.conditions.clone()),
            changed: entry.changed.clone(),
            calibrated: entry
                .calibrated
                .iter()
                .map(|c| c.calibration.clone())
                .chain(entry.chosen.iter().cloned())
                .collect(),
            intermediate: entry.intermediate,
            published: is_published,
            reproduced_by: entry.reproduced_by.clone(),
            findings: findings.collect(),
            form_differences: produced.form_differences,
            description_gaps: produced.description_gaps,
            failures: produced.failures,
            clusters: produced.clusters,
            shared_rows: Vec::new(),
            common_texts: Vec::new(),
            shared_seeds: Vec::new(),
            undecided_at_random: entry.undecided_at_random.clone(),
            alike_trials: produced.alike_trials,
            lineage_questions: repeated.into_iter().collect(),
            inputs,
        },
        cost,
        headline,
        published,
        influences: produced.influences,
        drifted: Vec::new(),
    })
}

/// A rate to four digits.
fn rounded(rate: f64) -> f64 {
    (rate * 1e4).round() / 1e4
}

/// The figure of the first requirement that has one.
pub fn headline(study: &Study, produced: &Produced) -> String {
    let requirement = study.requirements.first().map(|r| r.id.as_str());
    let first = produced
        .findings
        .iter()
        .filter(|f| f.measure.estimate().is_some())
        .min_by_key(|f| Some(f.subject.id()) != requirement);
    let Some(finding) = first else {
        return "nothing was covered".into();
    };
    let what = match &finding.subject {
        Subject::Requirement(id) => format!("requirement {id}"),
        Subject::FailureMode(id) => id.replace('_', " "),
    };
    match &finding.measure {
        Measure::Counts { count, trials, .. } => format!("{what} {count} of {trials}"),
        Measure::Probability {
            answer, credible, ..
        } => {
            let value = match (answer.guarantee.over_schedulers(), answer.complement) {
                (Some((low, high)), _) => format!("{low} to {high} over all schedulers"),
                (None, Some(rest)) if rest > 0.0 && rest < 1e-9 => format!("1 - {rest:.3e}"),
                (None, _) => answer.value.to_string(),
            };
            let given = match finding.denominator {
                Denominator::Triggered | Denominator::Covered => " given its trigger",
                Denominator::OtherTrigger { .. } => " given the model's trigger",
                Denominator::EveryRun | Denominator::NoTrigger | Denominator::AllRuns { .. } => "",
            };
            // The ends of a range with the constants as they are written say less than they seem to.
            let range = credible.as_ref().filter(|it| it.ends.is_some());
            let uncertain = range.map_or(String::new(), |it| {
                format!(
                    ", {} to {} with the uncertainty of its constants",
                    rounded(it.interval.low),
                    rounded(it.interval.high)
                )
            });
            format!("{what} {value}{given}{uncertain}")
        }
        _ => what,
    }
}

/// Compares every pair, concludes, and finds the culprits.
pub fn corroborate(study: &Study, pieces: Vec<Piece>) -> Result<StudyResult, Problem> {
    let mut evidence = Vec::new();
    let mut costs = Vec::new();
    let mut published = Vec::new();
    let mut drifted = Vec::new();
    let mut declared = Vec::new();
    for piece in pieces {
        evidence.push(piece.evidence);
        costs.push(piece.cost);
        published.extend(piece.published);
        drifted.extend(piece.drifted);
        declared.extend(piece.influences);
    }
    repeated::find(study, &mut evidence)?;
    copies::find(study, &mut evidence)?;
    evidence::doubt_triggers(&mut evidence, &study.requirements);
    let levels = evidence::Levels::new(study.about.confidence, study.about.agreement)
        .map_err(|error| Problem::new("bad-level", error.to_string()))?
        .with_error_rates_of(study.about.verdicts.error_rate);
    let influences = declared
        .iter()
        .fold(evidence::Influences::learn(&evidence), |known, one| {
            known.shown(&one.requirement, &one.failure_mode, one.bears)
        });
    let looks = study.looks.clone();
    let looks = looks.map(|looks| looks.with(evidence::Look::of(&evidence)));
    let to_compare = evidence::Study {
        requirements: &study.requirements,
        failure_modes: &study.failure_modes,
        evidence: &evidence,
        influences: &influences,
        levels,
        looks: looks.as_ref(),
    };
    let mut comparisons = evidence::compare(&to_compare);
    let undecided = evidence::undecided(&to_compare, &mut comparisons, &study.costs);
    let mut conclusions = evidence::conclude(&to_compare, &comparisons);
    evidence::bear_clustering(&to_compare, &mut comparisons, &mut conclusions);
    say_where_texts_differ(study, &mut conclusions);
    let synthesis = evidence::synthesise(
        &to_compare,
        (&comparisons, undecided),
        &conclusions,
        study.costs.clone(),
        &study.weights,
    );
    published.extend(published::reproductions(study, &evidence));
    let tables = tables_of(study);
    let matter = Matter {
        requirements: &study.requirements,
        failure_modes: &study.failure_modes,
        evidence: &evidence,
        comparisons: &comparisons,
        cells: &[],
        tables: &tables,
        study: ANY_STUDY,
    };
    let suspects = evidence::rank(&matter, drifted);
    let mut gaps = evidence::coverage_gaps(&to_compare);
    gaps.extend(conditions_without_evidence(study, &evidence));
    Ok(StudyResult {
        format: FORMAT.into(),
        title: study.about.title.clone(),
        summary: summary(study),
        confidence: study.about.confidence,
        requirements: study.requirements.clone(),
        failure_modes: study.failure_modes.clone(),
        evidence,
        comparisons,
        conclusions,
        synthesis,
        suspects,
        diagnosis: None,
        disagreement: None,
        exploration: None,
        calibration: None,
        gaps,
        published,
        costs,
        produced_by: format!("corroborate {}", env!("CARGO_PKG_VERSION")),
    })
}

/// Adds to a verdict that the requirement's text states another rate or time than what it was judged by: who reads the verdict
/// beside the text would else take it for one on the text.
fn say_where_texts_differ(study: &Study, conclusions: &mut [evidence::Conclusion]) {
    for conclusion in conclusions {
        let subject = Subject::Requirement(conclusion.requirement.clone());
        let form = study.forms.of(&subject);
        for sentence in form.map_or_else(Vec::new, |form| form.text_differs()) {
            conclusion.statement.push(' ');
            conclusion.statement.push_str(&sentence);
        }
    }
}

/// A requirement is asked under every condition that the study declares, so that one under which nothing looked is a gap,
/// whatever was found under others.
fn conditions_without_evidence(study: &Study, evidence: &[Evidence]) -> Vec<CoverageGap> {
    let declared = &study.about.conditions;
    // Evidence says what its conditions mean, not how they are called.
    let name_of = |it: &Evidence| {
        let mut all = declared.iter();
        let found = all.find(|(_, meaning)| **meaning == it.conditions);
        found.map_or(it.conditions.clone(), |(name, _)| name.clone())
    };
    let is_silent = |name: &&String| evidence.iter().all(|it| name_of(it) != **name);
    let silent = declared.keys().filter(is_silent);
    let gaps = silent.flat_map(|condition| {
        study.requirements.iter().map(move |requirement| {
            let subject = Subject::Requirement(requirement.id.clone());
            let has_number = |it: &&Evidence| {
                let finding = it.finding(&subject);
                finding.is_some_and(|finding| finding.measure.estimate().is_some())
            };
            let elsewhere = evidence.iter().filter(has_number);
            let elsewhere: String = elsewhere
                .map(|it| format!(" {} has a number on it under `{}`.", it.id, name_of(it)))
                .collect();
            CoverageGap {
                reason: format!(
                    "No evidence looked under the condition `{condition}`, which the study declares.{elsewhere}"
                ),
                subject,
                evidence: Vec::new(),
            }
        })
    });
    gaps.collect()
}

fn summary(study: &Study) -> String {
    let about = &study.about;
    if about.source.is_empty() {
        about.summary.trim().to_owned()
    } else {
        format!("{} After {}", about.summary.trim(), about.source.trim())
    }
}

/// What the study amounts to, for scripts: violated requirements (on any step of the ladder: a model that violates one
/// has to be looked at) or conflicts between current evidence, or something undecided, not covered, satisfied on a
/// step below the one that the requirement needs, or different in one person alone.
pub fn outcome(result: &StudyResult) -> Outcome {
    let verdict = |wanted: Verdict| result.conclusions.iter().any(|c| c.verdict == wanted);
    if verdict(Verdict::Violated)
        || verdict(Verdict::Conflicting)
        || !result.open_conflicts().is_empty()
    {
        Outcome::Violated
    } else if result.conclusions.iter().all(Conclusion::is_enough)
        && result.differences_of_one().is_empty()
    {
        Outcome::Holds
    } else {
        Outcome::Inconclusive
    }
}

/// Constants whose value is not the rate that they are said to be set to: the same number declared twice has drifted. It
/// is certain, and explains no conflict by itself.
pub fn drift<'e>(
    entry: &Entry,
    constant_of: impl Fn(&str) -> Option<f64>,
    evidence: impl Fn(&str) -> Option<&'e Evidence>,
) -> Vec<Clue> {
    let calibrated = entry.calibrated.iter();
    let found = calibrated.filter_map(|calibrated| {
        let name = calibrated.constant.as_ref()?;
        let value = constant_of(name)?;
        let source = evidence(&calibrated.calibration.from)?;
        let subject = &calibrated.calibration.subject;
        let rate = calibrated.value_of(source.finding(subject)?.measure.estimate()?);
        let is_same = is_rounding(value, rate);
        let counted = Counted {
            source: &source.id,
            rate,
            is_complement: calibrated.is_complement,
        };
        (!is_same).then(|| drifted(entry, (name, value), &counted, subject))
    });
    found.collect()
}

/// Whether a constant is a rate as written with a few digits: equal to it when the rate is rounded to the constant's
/// decimals, of which there are two or more.
pub fn is_rounding(value: f64, rate: f64) -> bool {
    let written = value.to_string();
    let decimals = written
        .split_once('.')
        .map_or(0, |(_, digits)| digits.len());
    let half_unit = 0.5 * 10_f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX));
    let difference = (value - rate).abs();
    let is_rounded = decimals >= 2 && difference <= half_unit * (1.0 + 1e-9);
    is_rounded || difference <= 5e-4 * rate.max(1e-3)
}

/// What a constant was set to.
struct Counted<'a> {
    /// Whose counts.
    source: &'a str,
    rate: f64,
    is_complement: bool,
}

fn drifted(
    entry: &Entry,
    (name, value): (&str, f64),
    counted: &Counted<'_>,
    subject: &Subject,
) -> Clue {
    let Counted {
        source,
        rate,
        is_complement,
    } = *counted;
    let subject_words = subject.id().replace('_', " ");
    let what = match is_complement {
        false => subject_words,
        true => format!("no {subject_words}"),
    };
    let counted = format!("{source} counts a rate of {rate:.6} for {what}");
    let model = entry.work.model();
    let file = model.map(|model| model.to_string_lossy().replace('\\', "/"));
    Clue {
        inaccuracy: Inaccuracy::SystemModel,
        asset: SuspectAsset {
            kind: SuspectKind::FormalModel,
            file,
            part: Some(format!("constant {name}")),
            evidence: vec![entry.id.clone()],
            together: Vec::new(),
            line: None,
        },
        subject: subject.clone(),
        score: 0.0,
        title: format!("{name} of {} has drifted from its source", entry.id),
        explanation: format!("It is {value}, but {counted}."),
        symptom: Symptom::Drifted {
            subject: subject.clone(),
            form: name.to_owned(),
            required: format!("{rate:.6}, as {counted}"),
            found: value.to_string(),
        },
        figures: Vec::new(),
        witnesses: Vec::new(),
        ruled_out: Vec::new(),
        resolved_by: None,
    }
}

/// Which table of each entry counts what: with a table of its own, or else in a cohort.
pub(crate) fn tables_of(study: &Study) -> Vec<TableOf> {
    let of = |entry: &Entry| {
        let tables = entry.work.tables();
        let file = |counts: evidence::Counted| {
            let tables = tables?;
            let file = match counts {
                evidence::Counted::FailureModes => tables.failure_modes,
                evidence::Counted::Requirements => tables.requirements,
                evidence::Counted::BySubject => tables.cohort,
            };
            // A table of totals names requirements or failure modes itself.
            let is_bound = counts == evidence::Counted::BySubject;
            Some(TableOf {
                evidence: entry.id.clone(),
                counts,
                file: file?.to_string_lossy().replace('\\', "/"),
                bound_in: is_bound.then(|| "vocabulary.toml".to_owned()),
            })
        };
        [
            evidence::Counted::FailureModes,
            evidence::Counted::Requirements,
            evidence::Counted::BySubject,
        ]
        .into_iter()
        .filter_map(file)
        .collect::<Vec<_>>()
    };
    study.ledger.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::is_rounding;

    #[test]
    fn a_rounding_has_at_least_two_decimals_and_is_the_nearest_number_of_these() {
        let (slips, decided) = (7.0 / 98.0, 174.0 / 200.0);
        for (value, rate) in [(0.07, slips), (0.071, slips), (0.071428571, slips)] {
            assert!(is_rounding(value, rate), "{value} {rate}");
        }
        for (value, rate) in [(0.5, 0.5), (0.0, 0.0), (1.0, 1.0), (0.87, decided)] {
            assert!(is_rounding(value, rate), "{value} {rate}");
        }
        for (value, rate) in [
            (0.3, decided),
            (0.9, decided),
            (0.88, decided),
            (0.1, slips),
        ] {
            assert!(!is_rounding(value, rate), "{value} {rate}");
        }
        for (value, rate) in [(0.0, 0.004), (1.0, 0.996), (0.072, slips)] {
            assert!(!is_rounding(value, rate), "{value} {rate}");
        }
    }
}
