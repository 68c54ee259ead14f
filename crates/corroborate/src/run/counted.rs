//! Constants of models that were set to counts, or solved for so that counts come out: held against these, and carried on with
//! their uncertainty.

use crate::corroboration::{Piece, is_rounding};
use crate::technique::CountedConstant;
use diagnostic::Problem;
use evidence::Measure;
use study::{Calibrated, Entry, Study};

/// The constants whose counts are uncertain, with the counts; `value_of` tells a constant of the model.
pub(crate) fn counted_constants(
    study: &Study,
    entry: &Entry,
    before: &[Piece],
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<Vec<CountedConstant>, Problem> {
    let level = crate::technique::confidence(study.about.confidence)?;
    let mut counted = Vec::new();
    check_values(study, entry, before, value_of)?;
    // A step on the way is not compared, so its uncertainty is not asked for.
    if entry.intermediate {
        return Ok(counted);
    }
    for calibrated in &entry.calibrated {
        let calibration = &calibrated.calibration;
        let is_solved = calibrated.constant.is_none()
            && entry.work.model().is_some()
            && value_of(&calibration.parameter).is_some();
        let constant = match &calibrated.constant {
            Some(constant) => constant,
            None if is_solved => &calibration.parameter,
            None => continue,
        };
        // With --only, the evidence that supplies the counts may be left out;
        // the result is then kept under other inputs.
        let finding = before
            .iter()
            .find(|piece| piece.evidence.id == calibration.from)
            .and_then(|piece| piece.evidence.finding(&calibration.subject));
        let Some(finding) = finding else {
            continue;
        };
        let solved_for = match is_solved {
            true => finding.measure.estimate(),
            false => None,
        };
        let Some(posterior) = calibrated.posterior(finding, level) else {
            if is_solved {
                continue;
            }
            return Err(Problem::new(
                "bad-calibration",
                format!(
                    "`{}` of {} was set to {}'s count of {}, which has none",
                    calibration.parameter,
                    entry.id,
                    calibration.from,
                    calibration.subject.id()
                ),
            )
            .at(&study.ledger_source, calibrated.span.clone())
            .remedy("calibrate from evidence that counts"));
        };
        counted.push(CountedConstant {
            name: constant.clone(),
            posterior,
            from: calibration.from.clone(),
            subject: calibration.subject.clone(),
            is_complement: calibrated.is_complement,
            held: calibrated.held,
            solved_for,
        });
    }
    Ok(counted)
}

/// Holds each constant against the counts that the ledger says it was set to: a model that computes with another number
/// would be shown with the uncertainty of this one.
fn check_values(
    study: &Study,
    entry: &Entry,
    before: &[Piece],
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<(), Problem> {
    for calibrated in &entry.calibrated {
        let calibration = &calibrated.calibration;
        let source = before.iter().find(|p| p.evidence.id == calibration.from);
        let finding = source.and_then(|piece| piece.evidence.finding(&calibration.subject));
        let rate = finding.and_then(|finding| finding.measure.estimate());
        let value = calibrated.constant.as_deref().and_then(value_of);
        let (Some(finding), Some(rate), Some(value)) = (finding, rate, value) else {
            continue;
        };
        let set_to = calibrated.value_of(rate);
        if is_rounding(value, set_to) {
            continue;
        }
        return Err(match is_rounding(value, 1.0 - set_to) {
            true => complement_mistaken(study, entry, calibrated, value, rate),
            false => other_value(study, entry, calibrated, value, &finding.measure),
        });
    }
    Ok(())
}

/// A constant that is not what the ledger says it was set to.
fn other_value(
    study: &Study,
    entry: &Entry,
    calibrated: &Calibrated,
    value: f64,
    measure: &Measure,
) -> Problem {
    let calibration = &calibrated.calibration;
    let rate = measure.estimate().unwrap_or(f64::NAN);
    let file = entry.work.model().or(entry.work.tree());
    let file = match file {
        Some(file) => file.to_string_lossy().replace('\\', "/"),
        None => entry.id.clone(),
    };
    let (counted, written) = match *measure {
        Measure::Counts { count, trials, .. } => {
            let of_constant = match calibrated.is_complement {
                true => trials.saturating_sub(count),
                false => count,
            };
            (
                format!("{count}/{trials} = "),
                format!("{of_constant}/{trials}"),
            )
        }
        _ => (String::new(), calibrated.value_of(rate).to_string()),
    };
    let complement = match calibrated.is_complement {
        true => format!(", so that the constant should be {:.6}", 1.0 - rate),
        false => String::new(),
    };
    Problem::new(
        "bad-calibration",
        format!(
            "`{name}` is {value} in {file} ({id}), but the ledger says that it was set to {from}'s rate of {subject}, \
             which is {counted}{rate:.6}{complement}",
            name = calibration.parameter,
            id = entry.id,
            from = calibration.from,
            subject = calibration.subject.id(),
        ),
    )
    .at(&study.ledger_source, calibrated.span.clone())
    .remedy(match entry.work.tree() {
        Some(_) => format!(
            "give `{}` the probability {} in {file}, or remove this line of the ledger if it has another source",
            calibration.parameter,
            calibrated.value_of(rate)
        ),
        None => format!(
            "write `const double {} = {written};` in {file}, or remove this line of the ledger if the constant has another \
             source",
            calibration.parameter
        ),
    })
}

/// A constant that is the complement of what it is said to be: its uncertainty would be that of another number.
fn complement_mistaken(
    study: &Study,
    entry: &Entry,
    calibrated: &Calibrated,
    value: f64,
    rate: f64,
) -> Problem {
    let calibration = &calibrated.calibration;
    let (is, remedy) = match calibrated.is_complement {
        false => (
            "1 minus that",
            "add `complement = true` if the constant is the probability that it does not happen",
        ),
        true => (
            "that itself, and not 1 minus it",
            "leave `complement` out if the constant is the probability that it happens",
        ),
    };
    Problem::new(
        "bad-calibration",
        format!(
            "`{}` of {} is {value}, but {} counts a rate of {rate} for {}: the constant is {is}",
            calibration.parameter,
            entry.id,
            calibration.from,
            calibration.subject.id(),
        ),
    )
    .at(&study.ledger_source, calibrated.span.clone())
    .remedy(remedy)
}
