//! The one vocabulary of the report: each outcome, verdict and technique has
//! one word, one symbol and one style, so that colour never stands alone.

use evidence::{
    AssetRole, CERTAINTY, Comparison, Conclusion, Direction, ErrorFamily, Guarantee,
    Identification, Inaccuracy, Likeness, Measure, Outcome, RegionOutcome, Requirement, Standing,
    Step, StudyResult, Technique, Threshold, Verdict,
};

use crate::number;

/// How something is marked: a symbol, a word and a style.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// One character.
    pub symbol: &'static str,
    /// Said beside the symbol, or in its place to a screen reader.
    pub word: String,
    /// Which of the tones (`good`, `bad`, `open`, `none`, `plain`) it takes.
    pub tone: &'static str,
}

fn mark(symbol: &'static str, word: impl Into<String>, tone: &'static str) -> Mark {
    Mark {
        symbol,
        word: word.into(),
        tone,
    }
}

/// Verdict on a requirement.
pub fn verdict(verdict: Verdict) -> Mark {
    match verdict {
        Verdict::Satisfied => mark("✓", "satisfied", "good"),
        Verdict::Violated => mark("✗", "not satisfied", "bad"),
        Verdict::Undecided => mark("?", "undecided", "open"),
        Verdict::Conflicting => mark("≠", "conflicting evidence", "bad"),
        Verdict::NotCovered => mark("○", "not covered", "none"),
    }
}

/// Verdict on a requirement with the step on which it stands; one that is not enough for it is open.
pub fn concluded(conclusion: &Conclusion) -> Mark {
    let mut mark = verdict(conclusion.verdict);
    let step = match conclusion.step {
        None | Some(Step::System) => return mark,
        Some(step) => step,
    };
    mark.word = match step {
        Step::Corroborated => format!("{}, corroborated", mark.word),
        _ => format!("{} {}", mark.word, step.words()),
    };
    if conclusion.is_open() {
        mark.tone = "open";
    }
    mark
}

/// The requirements by what is concluded of them and on which step: what stands for a model alone is not told with what stands
/// for the system.
pub fn tally(study: &StudyResult) -> Vec<(Mark, Vec<&str>)> {
    let mut found: Vec<(Mark, Vec<&str>)> = Vec::new();
    for verdict in VERDICTS {
        let own = study.conclusions.iter().filter(|it| it.verdict == verdict);
        let mut of_verdict: Vec<(Option<Step>, Mark, Vec<&str>)> = Vec::new();
        for conclusion in own {
            let mark = concluded(conclusion);
            let id = conclusion.requirement.as_str();
            let mut known = of_verdict.iter_mut();
            match known.find(|(_, other, _)| other.word == mark.word && other.tone == mark.tone) {
                Some((.., ids)) => ids.push(id),
                None => of_verdict.push((conclusion.step, mark, vec![id])),
            }
        }
        // The strongest first.
        of_verdict.sort_by_key(|(step, ..)| std::cmp::Reverse(*step));
        found.extend(of_verdict.into_iter().map(|(_, mark, ids)| (mark, ids)));
    }
    found
}

/// How a piece stands to what is required, as the conclusion says.
pub fn standing(requirement: &Requirement, standing: Standing, measure: &Measure) -> Mark {
    let Some(threshold) = requirement.threshold else {
        return reading(requirement, measure);
    };
    let level = number::level(threshold.value);
    let at_least = threshold.direction == Direction::AtLeast;
    match (standing, at_least) {
        (Standing::Supports, true) => mark("✓", format!("at least {level}"), "good"),
        (Standing::Supports, false) => mark("✓", format!("at most {level}"), "good"),
        (Standing::Denies, true) => mark("✗", format!("below {level}"), "bad"),
        (Standing::Denies, false) => mark("✗", format!("above {level}"), "bad"),
        (Standing::Neither, _) => mark("?", format!("open at {level}"), "open"),
    }
}

/// Of what the intervals are that stand beside rates: `two-sided at 95 % and of one look`. They stand beside the limits of
/// verdicts, which are of one side and may hold at every look: two statements, each of which has to be named.
pub fn intervals(study: &StudyResult) -> String {
    let fixed = match study.synthesis.looks {
        Some(_) => "",
        None => " at numbers of trials that were fixed before",
    };
    intervals_in_short(study) + fixed
}

/// The same at the head of a column, which stands once for each piece of evidence.
pub fn intervals_in_short(study: &StudyResult) -> String {
    let level = number::level(study.confidence);
    let mut findings = study.evidence.iter().flat_map(|it| &it.findings);
    match findings.any(|it| it.measure.holds_at_every_look(study.confidence)) {
        true => format!(
            "two-sided at {level} and of one look (of every look where trials were stopped by what they showed)"
        ),
        false => format!("two-sided at {level} and of one look"),
    }
}

/// At which looks the one-sided limits hold that decide a verdict, as the end of a sentence.
pub fn at_looks(study: &StudyResult) -> &'static str {
    match study.synthesis.looks {
        Some(_) => ", which hold at every look where they say so",
        None => "",
    }
}

/// Why no evidence of a technique is shown for a subject: there is none, or all that there is was left out.
pub fn not_shown(
    study: &StudyResult,
    subject: &evidence::Subject,
    technique: evidence::Technique,
) -> &'static str {
    let is_left_out = study
        .evidence
        .iter()
        .any(|it| it.technique == technique && it.finding(subject).is_some());
    match is_left_out {
        true => "· left out",
        false => "· not asked",
    }
}

/// A number that takes no part in a conclusion.
pub fn apart() -> Mark {
    mark("·", "takes no part", "none")
}

/// For what the error rates of the verdicts hold; `None` where there is no verdict.
pub fn error_rates(study: &StudyResult) -> Option<String> {
    let rates = study.conclusions.iter().map(|one| one.error_rate);
    let rate = rates.max_by_key(|rate| rate.quantities)?;
    if rate.quantities == 0 {
        let nothing = "Error rates: no verdict rests on a test of a rate of the system. Verdicts in simulation and for the model hold for these alone.";
        return Some(nothing.to_owned());
    }
    let level = number::level(rate.level);
    // Said by the verdicts that rest on it.
    let is_borrowed = |it: &evidence::Conclusion| it.statement.contains(evidence::AS_ALIKE);
    let model = match (
        is_counted_by_subject(study),
        study.conclusions.iter().any(is_borrowed),
    ) {
        (true, true) => {
            ", if subjects differ as a beta distribution has it, and are as alike in one column of a table as in its others"
        }
        (true, false) => ", if subjects differ as a beta distribution has it",
        (false, _) => "",
    };
    Some(match rate.holds_for {
        ErrorFamily::Study => format!(
            "Error rates: over the whole study ({} tested), a false \"satisfied\" of the system has a probability of at \
             most {level}, and so has a false \"violated\"{model}. Verdicts in simulation and for the model hold for these alone.",
            match rate.quantities {
                1 => "1 quantity".to_owned(),
                many => format!("{many} quantities"),
            },
        ),
        ErrorFamily::Requirement => format!(
            "Error rates: for each requirement by itself, a false verdict of the system has a probability of at most \
             {level}{model}; over several requirements it is higher. Verdicts in simulation and for the model hold for these alone."
        ),
    })
}

/// Whether any piece has counts by person or session.
fn is_counted_by_subject(study: &StudyResult) -> bool {
    let mut findings = study.evidence.iter().flat_map(|piece| &piece.findings);
    findings.any(|finding| {
        matches!(
            finding.measure,
            Measure::Counts {
                subjects: Some(_),
                ..
            }
        )
    })
}

/// All verdicts in the order in which they are listed.
pub const VERDICTS: [Verdict; 5] = [
    Verdict::Satisfied,
    Verdict::Violated,
    Verdict::Conflicting,
    Verdict::Undecided,
    Verdict::NotCovered,
];

/// Outcome of a comparison.
pub fn outcome(outcome: Outcome) -> Mark {
    match outcome {
        Outcome::Corroborates => mark("≈", "corroborates", "good"),
        Outcome::Conflicts => mark("≠", "conflicts", "bad"),
        Outcome::Inconclusive => mark("?", "inconclusive", "open"),
        Outcome::NotComparable => mark("–", "not comparable", "none"),
    }
}

/// What became of a region of contexts.
pub fn region(outcome: RegionOutcome) -> Mark {
    match outcome {
        RegionOutcome::Differs => mark("≠", "differs", "bad"),
        RegionOutcome::Undecided => mark("?", "undecided", "open"),
        RegionOutcome::Agrees => mark("≈", "agrees", "good"),
    }
}

/// Whether counts say what a parameter is.
pub fn identification(identification: Identification) -> Mark {
    let word = identification.words();
    match identification {
        Identification::Identified => mark("✓", word, "good"),
        Identification::WeaklyIdentified => mark("≈", word, "open"),
        Identification::NotIdentified => mark("?", word, "open"),
    }
}

/// What is shown of a fitted simulation beside reality.
pub fn likeness(likeness: Likeness) -> Mark {
    let word = likeness.words();
    match likeness {
        Likeness::Equivalent => mark("≈", word, "good"),
        Likeness::Different => mark("≠", word, "bad"),
        Likeness::Undecided => mark("?", word, "open"),
        Likeness::Fit => mark("=", word, "none"),
    }
}

/// A finding whose episode, run again, does not show it.
pub fn not_shown_again() -> Mark {
    mark("?", "not shown again", "open")
}

/// Outcome of a comparison, where agreement may be only a fit.
pub fn comparison(result: Outcome, independent: bool) -> Mark {
    let mut mark = outcome(result);
    if !independent && result == Outcome::Corroborates {
        mark.word = "agrees, a fit".to_owned();
    }
    mark
}

/// Outcome of the comparison of a pair, whose runs may be paired.
pub fn pair(pair: &Comparison) -> Mark {
    let mut mark = comparison(pair.outcome, pair.independent);
    if pair.paired && pair.outcome == Outcome::Corroborates {
        mark.word = "agrees, paired".to_owned();
    }
    mark
}

/// All outcomes in the order in which they are listed.
pub const OUTCOMES: [Outcome; 4] = [
    Outcome::Conflicts,
    Outcome::Inconclusive,
    Outcome::Corroborates,
    Outcome::NotComparable,
];

/// Where the interval of a finding lies with respect to what is required, for evidence that takes part in no conclusion.
///
/// A reading of two fields side by side, as the eye does it in the forest
/// plot; where a conclusion judged the piece, [`standing`] shows what it said.
pub fn reading(requirement: &Requirement, measure: &Measure) -> Mark {
    match measure {
        Measure::NotExpressible { .. } => return mark("⊘", "not expressible", "none"),
        Measure::NotCovered { .. } => return mark("○", "not covered", "none"),
        Measure::Counts { trials: 0, .. } => return mark("○", "not covered", "none"),
        _ => {}
    }
    match (requirement.threshold, measure) {
        (None, Measure::Counts { count, trials, .. }) if count == trials => {
            // Trials alone never show certainty, however many pass.
            mark("?", "no violation seen", "open")
        }
        (None, Measure::Counts { count, trials, .. }) => {
            let violations = number::count(trials.saturating_sub(*count));
            mark("✗", format!("violations: {violations}"), "bad")
        }
        (None, _) => certainty(measure),
        (Some(_), _) if has_no_bound(measure) => mark("?", "error unknown", "open"),
        (Some(threshold), _) => against(threshold.direction, threshold.value, measure),
    }
}

/// Whether a computed number has an unknown error.
pub fn has_no_bound(measure: &Measure) -> bool {
    matches!(
        measure,
        Measure::Probability { answer, credible: None, .. }
            if matches!(answer.guarantee, Guarantee::Estimated { .. })
    )
}

fn certainty(measure: &Measure) -> Mark {
    let Measure::Probability { answer, .. } = measure else {
        return mark("○", "not covered", "none");
    };
    let (low, high) = match answer.guarantee {
        Guarantee::Exact { .. } => (answer.value, answer.value),
        Guarantee::Bounded { low, high } | Guarantee::Schedulers { low, high, .. } => (low, high),
        Guarantee::Statistical { .. } => return mark("?", "known at a level only", "open"),
        Guarantee::Estimated { .. } => return mark("?", "error unknown", "open"),
    };
    let short_of_one = answer.complement.is_some_and(|rest| rest > 0.0) || low < 1.0;
    match (low, high) {
        (_, high) if high < 1.0 - CERTAINTY => mark("✗", "not certain", "bad"),
        (low, _) if low < 1.0 - CERTAINTY => mark("?", "1 is within the bounds", "open"),
        _ if short_of_one => mark("✓", "practically certain", "good"),
        _ => mark("✓", "certain", "good"),
    }
}

fn against(direction: Direction, value: f64, measure: &Measure) -> Mark {
    let Some(interval) = measure.interval() else {
        return mark("○", "not covered", "none");
    };
    let level = number::level(value);
    // As the conclusions read a computed probability.
    let slack = match measure {
        Measure::Probability {
            answer,
            credible: None,
            ..
        } if answer.guarantee.is_certain() => CERTAINTY,
        _ => 0.0,
    };
    let (above, below) = (interval.low >= value - slack, interval.high < value - slack);
    match direction {
        Direction::AtLeast if above => mark("✓", format!("above {level}"), "good"),
        Direction::AtLeast if below => mark("✗", format!("below {level}"), "bad"),
        Direction::AtMost if interval.high <= value + slack => {
            mark("✓", format!("below {level}"), "good")
        }
        Direction::AtMost if interval.low > value + slack => {
            mark("✗", format!("above {level}"), "bad")
        }
        _ => mark("?", format!("spans {level}"), "open"),
    }
}

/// What a requirement asks for: `at least 95 %`, or `always`.
pub fn asked(requirement: &Requirement) -> String {
    match requirement.threshold {
        None => "always".to_owned(),
        Some(threshold) => {
            let side = match threshold.direction {
                Direction::AtLeast => "at least",
                Direction::AtMost => "at most",
            };
            format!("{side} {}", number::level(threshold.value))
        }
    }
}

/// A threshold as a label in a plot: `1a ≥ 95 %`.
pub fn threshold_label(id: &str, threshold: Threshold) -> String {
    let side = match threshold.direction {
        Direction::AtLeast => "≥",
        Direction::AtMost => "≤",
    };
    format!("{id} {side} {}", number::level(threshold.value))
}

/// A technique's name as a heading.
pub fn technique(technique: Technique) -> &'static str {
    technique.traits().heading
}

/// The techniques to show, from the most abstract to the most real: those that every study is expected to use, and others
/// only if the study has evidence of them.
pub fn techniques(study: &evidence::StudyResult) -> Vec<Technique> {
    let is_there = |it: Technique| study.evidence.iter().any(|e| e.technique == it);
    let is_shown = |it: &Technique| it.traits().is_expected || is_there(*it);
    Technique::ALL.into_iter().filter(is_shown).collect()
}

/// Where a fault is to be sought.
pub fn inaccuracy(inaccuracy: Inaccuracy) -> &'static str {
    match inaccuracy {
        Inaccuracy::Tool => "tool inaccuracy",
        Inaccuracy::RequirementModel => "requirement model inaccuracy",
        Inaccuracy::SystemModel => "system model inaccuracy",
        Inaccuracy::Undetermined => "reason not yet separated",
    }
}

/// What an asset is for.
pub fn role(role: AssetRole) -> &'static str {
    match role {
        AssetRole::SystemModel => "system model",
        AssetRole::RequirementModel => "requirement model",
        AssetRole::Data => "data",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::{Interval, MethodAnswer};

    fn requirement(threshold: Option<f64>) -> Requirement {
        Requirement {
            id: "1a".into(),
            text: String::new(),
            threshold: threshold.map(|value| Threshold {
                direction: Direction::AtLeast,
                value,
            }),
            property: None,
            sentence: None,
            monitor: None,
            margin: 0.05,
            asks_for: None,
            same_quantity_as: None,
            ..Requirement::default()
        }
    }

    fn counts(count: u64, trials: u64, low: f64, high: f64) -> Measure {
        Measure::Counts {
            by_subject: None,
            subjects: None,
            count,
            trials,
            effective_trials: None,
            interval: Interval { low, high },
        }
    }

    fn probability(value: f64, complement: Option<f64>, guarantee: Guarantee) -> Measure {
        Measure::Probability {
            answer: MethodAnswer {
                method: "sound".into(),
                value,
                complement,
                guarantee,
                iterations: None,
            },
            others: vec![],
            credible: None,
        }
    }

    #[test]
    fn an_interval_is_read_against_its_threshold() {
        let read = |count, low, high| {
            reading(&requirement(Some(0.95)), &counts(count, 100, low, high)).tone
        };
        assert_eq!(read(88, 0.80, 0.93), "bad");
        assert_eq!(read(98, 0.96, 0.99), "good");
        assert_eq!(read(94, 0.90, 0.96), "open");
    }

    #[test]
    fn a_number_without_bound_is_read_as_open() {
        let loose = Guarantee::Estimated {
            reason: "stopped".into(),
        };
        let measure = probability(0.9999948, None, loose);
        for threshold in [None, Some(0.95)] {
            assert_eq!(reading(&requirement(threshold), &measure).tone, "open");
        }
    }

    #[test]
    fn certainty_needs_an_exact_one() {
        let tone = |value, complement, guarantee| {
            reading(
                &requirement(None),
                &probability(value, complement, guarantee),
            )
            .tone
        };
        let exact = || Guarantee::Exact { rational: None };
        assert_eq!(tone(1.0, Some(0.0), exact()), "good");
        assert_eq!(tone(0.998, None, exact()), "bad");
        let bounded = |low, high| Guarantee::Bounded { low, high };
        assert_eq!(tone(1.0, None, bounded(1.0 - 1e-12, 1.0)), "good");
        assert_eq!(tone(1.0, None, bounded(0.9, 1.0)), "open");
        assert_eq!(tone(0.9, None, bounded(0.8, 0.95)), "bad");
    }

    #[test]
    fn a_shortfall_is_not_called_certain_and_trials_are_not_called_proof() {
        let exact = Guarantee::Exact { rational: None };
        let short = probability(1.0, Some(1e-53), exact);
        assert_eq!(
            reading(&requirement(None), &short).word,
            "practically certain"
        );
        let passed = reading(&requirement(None), &counts(93, 93, 0.96, 1.0));
        assert_eq!(
            (passed.word.as_str(), passed.tone),
            ("no violation seen", "open")
        );
    }

    #[test]
    fn nothing_seen_is_not_the_same_as_nothing_sayable() {
        let none = counts(0, 0, 0.0, 1.0);
        assert_eq!(reading(&requirement(None), &none).word, "not covered");
        let unsayable = Measure::NotExpressible { reason: "x".into() };
        assert_eq!(
            reading(&requirement(None), &unsayable).word,
            "not expressible"
        );
    }
}
