//! Figures that the source publication prints, beside ours.
//!
//! Computed figures must be the same: counts exactly, probabilities to 1e-12.
//! Counts of random runs must be statistically consistent: Fisher's exact
//! test, corrected by Holm over the figures of one pair of evidence.

use crate::technique::Produced;
use evidence::{Evidence, Measure, MethodAnswer, PublishedFigure, Subject};
use study::{Entry, Study};

/// Distance at which two printed probabilities count as the same.
const TOLERANCE: f64 = 1e-12;

/// The figures of one entry.
pub fn figures(study: &Study, entry: &Entry, produced: &Produced) -> Vec<PublishedFigure> {
    let published = &entry.published;
    let mut figures = Vec::new();
    let counts = [
        ("states", published.states, produced.cost.states),
        (
            "transitions",
            published.transitions,
            produced.cost.transitions,
        ),
    ];
    for (quantity, theirs, ours) in counts {
        if let Some(theirs) = theirs {
            figures.push(PublishedFigure {
                evidence: entry.id.clone(),
                quantity: quantity.into(),
                published: theirs.to_string(),
                ours: ours.map_or("none".into(), |n| n.to_string()),
                agrees: ours == Some(theirs),
                judged: "exactly".into(),
            });
        }
    }
    if let (Some(success), Some(first)) = (&published.success, study.requirements.first()) {
        let subject = Subject::Requirement(first.id.clone());
        let method = success.method.name();
        let quantity = format!("requirement {} by the method `{method}`", first.id);
        let ours = method_answer(produced, &subject, method);
        figures.push(probability(entry, quantity, &success.value, ours));
    }
    for (id, value) in &published.requirements {
        let subject = Subject::Requirement(id.clone());
        let ours = method_answer(produced, &subject, "sound");
        figures.push(probability(entry, format!("requirement {id}"), value, ours));
    }
    figures
}

fn method_answer<'a>(
    produced: &'a Produced,
    subject: &Subject,
    method: &str,
) -> Option<&'a MethodAnswer> {
    let finding = produced.findings.iter().find(|f| &f.subject == subject)?;
    let Measure::Probability { answer, others, .. } = &finding.measure else {
        return None;
    };
    std::iter::once(answer)
        .chain(others)
        .find(|a| a.method == method)
}

fn probability(
    entry: &Entry,
    quantity: String,
    published: &str,
    ours: Option<&MethodAnswer>,
) -> PublishedFigure {
    let theirs: Option<f64> = published.parse().ok();
    let agrees = matches!((theirs, ours), (Some(a), Some(b)) if (a - b.value).abs() <= TOLERANCE);
    PublishedFigure {
        evidence: entry.id.clone(),
        quantity,
        published: published.to_owned(),
        ours: ours.map_or("none".into(), |a| a.value.to_string()),
        agrees,
        judged: "within 1e-12".into(),
    }
}

/// Published counts beside those of the evidence that reproduces them.
pub fn reproductions(study: &Study, evidence: &[Evidence]) -> Vec<PublishedFigure> {
    let alpha = 1.0 - study.about.confidence;
    let mut figures = Vec::new();
    for theirs in evidence {
        let Some(ours) = theirs
            .reproduced_by
            .as_ref()
            .and_then(|id| evidence.iter().find(|e| &e.id == id))
        else {
            continue;
        };
        let pairs: Vec<_> = theirs
            .findings
            .iter()
            .filter_map(|finding| {
                let published = sample(&finding.measure)?;
                let subject = &finding.subject;
                let found = ours.finding(subject).and_then(|f| sample(&f.measure));
                Some((subject, published, found))
            })
            .collect();
        let p_values: Vec<f64> = pairs
            .iter()
            .filter_map(|(_, published, found)| Some(stats::fisher_exact(*published, (*found)?)))
            .collect();
        let mut corrected = stats::holm(&p_values).into_iter();
        for (subject, published, found) in pairs {
            let p = found.and_then(|_| corrected.next());
            figures.push(PublishedFigure {
                evidence: ours.id.clone(),
                quantity: in_words(subject),
                published: fraction(published),
                ours: found.map_or("never covered".into(), fraction),
                agrees: p.is_some_and(|p| p >= alpha),
                judged: match p {
                    Some(p) => {
                        format!("consistent unless p < {alpha:.2}; Fisher's p = {p:.3} (Holm)")
                    }
                    None => "cannot be judged".into(),
                },
            });
        }
    }
    figures
}

fn sample(measure: &Measure) -> Option<stats::Sample> {
    match measure {
        Measure::Counts { count, trials, .. } if *trials > 0 => {
            stats::Sample::new(*count, *trials).ok()
        }
        _ => None,
    }
}

fn fraction(sample: stats::Sample) -> String {
    format!("{} of {}", sample.successes, sample.trials)
}

fn in_words(subject: &Subject) -> String {
    match subject {
        Subject::Requirement(id) => format!("requirement {id} passed"),
        Subject::FailureMode(id) => id.replace('_', " "),
    }
}
