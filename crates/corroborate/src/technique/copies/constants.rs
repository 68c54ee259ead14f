//! Numbers in models and parameter sets that are rates of another piece's counts.
//!
//! # Definition
//! Every number between 0 and 1 in the text of a formal model or a parameter set is held against every count of other
//! evidence that is neither none nor all: 0.87 of 174/200, its complement 0.13, and the quotient 174/200 itself. A number
//! with decimals is the rate if it is the rate rounded to its last digit.
//!
//! # Assumes
//! An independent source finds a rate as the posterior of the counts has it, whatever digits it writes. Trials are
//! independent. How often sources have a multiple of the same number of trials is a guess (`stats::coincidence`).
//!
//! # Guarantee
//! Comments and constants that the ledger declares as calibrated are left out. Not found are
//! numbers that were rounded to so few digits that chance gives as many (0.9).

use super::{Candidate, counted, is_declared, probability, subject_in_words};
use diagnostic::Problem;
use evidence::{AssetRole, CopyKind, Evidence, Subject};
use stats::Sample;
use study::{Entry, Study};

/// Larger texts are no models that somebody writes.
const MOST_BYTES: u64 = 1 << 20;

/// A number between 0 and 1 in a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Number {
    pub text: String,
    pub value: f64,
    /// One in its last digit.
    pub step: f64,
    pub quotient: Option<(u64, u64)>,
    /// Its line, from 1.
    pub line: usize,
    /// What is set to it, where the line says so.
    pub name: Option<String>,
    /// Whether it is subtracted from 1: what is set is what is left.
    pub is_subtracted: bool,
}

/// A number with its piece and file.
pub(super) struct Placed<'a> {
    pub piece: usize,
    pub path: &'a str,
    pub number: Number,
}

/// All numbers against all counts.
pub(super) fn candidates(study: &Study, evidence: &[Evidence]) -> Result<Vec<Candidate>, Problem> {
    let mut candidates = Vec::new();
    for placed in placed(study, evidence)? {
        let piece = &evidence[placed.piece];
        for (other, counts) in evidence.iter().map(counted).enumerate() {
            for (subject, sample) in counts {
                if other != placed.piece && !is_declared(piece, &evidence[other], &subject) {
                    candidates.extend(candidate(&placed, evidence, other, subject, sample));
                }
            }
        }
    }
    Ok(candidates)
}

/// The numbers of each piece's models and parameter sets, each value once.
pub(super) fn placed<'a>(
    study: &Study,
    evidence: &'a [Evidence],
) -> Result<Vec<Placed<'a>>, Problem> {
    let mut found: Vec<Placed> = Vec::new();
    for (piece, it) in evidence.iter().enumerate() {
        let entry = study.ledger.iter().find(|entry| entry.id == it.id);
        let models = it.assets.iter();
        let models = models.filter(|asset| asset.role == AssetRole::SystemModel);
        let begin = found.len();
        for asset in models.filter(|asset| is_read(it, &asset.path)) {
            for number in numbers(&text(study, &asset.path)?) {
                let declared = entry.is_some_and(|entry| is_calibrated(entry, &number));
                let is_known = |other: &Placed| is_same(&other.number, &number);
                if !declared && !found[begin..].iter().any(is_known) {
                    found.push(Placed {
                        piece,
                        path: &asset.path,
                        number,
                    });
                }
            }
        }
    }
    Ok(found)
}

/// Models are read whatever their files are called, of simulations the parameter sets and scenarios.
fn is_read(piece: &Evidence, path: &str) -> bool {
    piece.technique.is_of_model() || path.ends_with(".toml")
}

/// The text of an asset; empty for what is no text that somebody wrote.
pub(super) fn text(study: &Study, path: &str) -> Result<String, Problem> {
    let full = study.folder.join(path);
    let is_small = std::fs::metadata(&full).is_ok_and(|it| it.is_file() && it.len() <= MOST_BYTES);
    if !is_small {
        return Ok(String::new());
    }
    let bytes = std::fs::read(&full).map_err(|error| Problem::cannot_read(&full, &error))?;
    Ok(String::from_utf8(bytes).unwrap_or_default())
}

fn is_calibrated(entry: &Entry, number: &Number) -> bool {
    let names = entry.calibrated.iter().map(|it| &it.calibration.parameter);
    names
        .into_iter()
        .any(|name| number.name.as_ref() == Some(name))
}

/// Whether two numbers are one coincidence: the same value, or its complement.
fn is_same(one: &Number, other: &Number) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    near(one.value, other.value) || near(one.value, 1.0 - other.value)
}

fn candidate(
    placed: &Placed,
    evidence: &[Evidence],
    other: usize,
    subject: Subject,
    sample: Sample,
) -> Option<Candidate> {
    let number = &placed.number;
    let failures = Sample {
        successes: sample.failures(),
        trials: sample.trials,
    };
    let (rate, rest) = (rate(number, sample), rate(number, failures));
    let (chance, met) = (rate.0 + rest.0, rate.1 || rest.1);
    if chance < 1e-9 {
        return None;
    }
    let (id, with) = (&evidence[placed.piece].id, &evidence[other].id);
    let name = number.name.as_ref();
    let is_named_rest = number.is_subtracted && name.is_some();
    let what = name.map_or(format!("{id}'s {}", number.text), |name| {
        let subtracted = if is_named_rest { "1-" } else { "" };
        format!("{id}'s `{name}` = {subtracted}{}", number.text)
    });
    // What is named has the rate if what is subtracted has that of the contrary.
    let is_rate = rate.1 != is_named_rest;
    let of_rest = if is_rate { "" } else { "1 minus " };
    Some(Candidate {
        pieces: [placed.piece, other],
        kind: CopyKind::Constant,
        key: format!("{} {} {}", number.text, sample.successes, sample.trials),
        chance,
        met,
        notable: evidence[placed.piece].technique.is_of_model(),
        finding: format!(
            "{what} is {of_rest}{with}'s {}/{} of {} (an independent source gives it with a probability of {})",
            sample.successes,
            sample.trials,
            subject_in_words(&subject),
            probability(chance)
        ),
        places: vec![format!("{}:{}", placed.path, number.line)],
        declare: name.map(|name| declaration(name, with, &subject, of_rest)),
        subjects: vec![subject],
    })
}

fn declaration(name: &str, with: &str, subject: &Subject, of_rest: &str) -> String {
    let subject = match subject {
        Subject::Requirement(id) => format!("requirement = \"{id}\""),
        Subject::FailureMode(id) => format!("failure_mode = \"{id}\""),
    };
    let complement = match of_rest {
        "" => "",
        _ => ", complement = true",
    };
    format!("calibrated = [{{ constant = \"{name}\", from = \"{with}\", {subject}{complement} }}]")
}

/// The probability that an independent source writes this number for these counts, and whether it is their rate.
fn rate(number: &Number, sample: Sample) -> (f64, bool) {
    let counts = (sample.successes, sample.trials);
    let exact = sample.successes as f64 / sample.trials as f64;
    let deviation = (exact * (1.0 - exact) / sample.trials as f64).sqrt();
    if (number.value - exact).abs() > 10.0 * deviation + number.step {
        return (0.0, false);
    }
    if let Some(quotient) = number.quotient
        && quotient.1 == sample.trials
    {
        let again = Sample {
            successes: quotient.0,
            trials: quotient.1,
        };
        return (stats::quotient_by_chance(again), quotient == counts);
    }
    let met = (number.value - exact).abs() <= 0.5 * number.step * (1.0 + 1e-9);
    let chance = stats::constant_by_chance(sample, number.value, number.step);
    (chance, met)
}

/// The numbers between 0 and 1 in a text, without those in comments.
pub(super) fn numbers(text: &str) -> Vec<Number> {
    let mut found = Vec::new();
    for (line, whole) in (1..).zip(text.lines()) {
        let code = whole.split("//").next().unwrap_or_default();
        let code = code.split('#').next().unwrap_or_default();
        let mut at = 0;
        while let Some(token) = token(code, at) {
            at = token.end;
            let Some((value, step, quotient, end)) = read(code, &token) else {
                continue;
            };
            at = end;
            if value > 0.0 && value < 1.0 {
                found.push(Number {
                    text: code[token.start..end].split_whitespace().collect(),
                    value,
                    step,
                    quotient,
                    line,
                    name: name(code, token.start),
                    is_subtracted: is_subtracted(&code[..token.start]),
                });
            }
        }
    }
    found
}

/// Whether a line up to a number ends with `1-`.
fn is_subtracted(before: &str) -> bool {
    let minuend = before.trim_end().strip_suffix('-').map(str::trim_end);
    let left = minuend.and_then(|it| it.strip_suffix('1').or_else(|| it.strip_suffix("1.0")));
    left.is_some_and(|it| !it.ends_with(|c: char| c.is_ascii_alphanumeric() || "._".contains(c)))
}

/// The next number from a place on.
fn token(code: &str, from: usize) -> Option<std::ops::Range<usize>> {
    let bytes = code.as_bytes();
    let is_word = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b'.';
    let starts = |i: &usize| {
        let before = i.checked_sub(1).map(|i| bytes[i]);
        bytes[*i].is_ascii_digit() && !before.is_some_and(is_word)
    };
    let start = (from..bytes.len()).find(starts)?;
    let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    let mut end = start;
    while digit(end) {
        end += 1;
    }
    if bytes.get(end) == Some(&b'.') && digit(end + 1) {
        end += 1;
        while digit(end) {
            end += 1;
        }
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if digit(end + 1 + sign) {
            end += 1 + sign;
            while digit(end) {
                end += 1;
            }
        }
    }
    Some(start..end)
}

type Read = (f64, f64, Option<(u64, u64)>, usize);

/// The value of a number or quotient of whole numbers, one in its last digit, and where it ends.
fn read(code: &str, token: &std::ops::Range<usize>) -> Option<Read> {
    let text = &code[token.clone()];
    if let Ok(above) = text.parse::<u64>() {
        let rest = code[token.end..].trim_start().strip_prefix('/')?;
        let below = self::token(rest, 0).filter(|it| rest[..it.start].trim().is_empty())?;
        let end = code.len() - rest.len() + below.end;
        let below: u64 = rest[below].parse().ok()?;
        let value = above as f64 / below as f64;
        return Some((value, 1.0 / below as f64, Some((above, below)), end));
    }
    let value: f64 = text.parse().ok()?;
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, it)| it.len()) as i32;
    let step = 10_f64.powi(exponent.parse::<i32>().ok()? - decimals);
    Some((value, step, None, token.end))
}

/// What a line sets: the word before its first `=`, if the number stands behind that.
fn name(code: &str, at: usize) -> Option<String> {
    let (left, _) = code.split_once('=').filter(|(left, _)| left.len() < at)?;
    let words: Vec<&str> = left.split_whitespace().collect();
    let is_name = |word: &str| {
        let mut letters = word.chars();
        letters.all(|c| c.is_alphanumeric() || c == '_' || c == '-' || c == '.')
    };
    let last = words.last().filter(|word| is_name(word))?;
    let declares = words.len() == 1 || words.first() == Some(&"const");
    declares.then(|| (*last).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_with_their_last_digit_and_name() {
        let text = "dtmc\nconst double p_ok = 0.870; // 0.5\n[] s=0 -> 174/200:(s'=1) + 26 / 200:(s'=2);\n\
                    x : [0..10] init 0;\nfriction = 8.5e-3 # 0.25\nconst int n = 3;";
        let found = numbers(text);
        let short: Vec<_> = found
            .iter()
            .map(|it| (it.text.as_str(), it.line, it.name.as_deref()))
            .collect();
        assert_eq!(
            short,
            [
                ("0.870", 2, Some("p_ok")),
                ("174/200", 3, None),
                ("26/200", 3, None),
                ("8.5e-3", 5, Some("friction")),
            ]
        );
        assert!((found[0].step - 1e-3).abs() < 1e-15 && (found[3].step - 1e-4).abs() < 1e-15);
        assert_eq!(found[2].quotient, Some((26, 200)));
    }

    #[test]
    fn a_number_is_a_rate_if_it_rounds_to_it() {
        let sample = Sample {
            successes: 26,
            trials: 30,
        };
        let of = |text: &str| {
            let number = numbers(text).remove(0);
            rate(&number, sample)
        };
        assert!(of("0.867").1 && of("0.8667").1 && of("0.87").1 && !of("0.866").1);
        assert!(of("26/30").1 && of("13/15").1 && !of("25/30").1);
        assert_eq!(of("0.1"), (0.0, false));
        // Of 30 trials, or any other round number, others count, too; of 31 hardly.
        assert!(of("0.8667").0 > 0.05 && of("0.87").0 > 0.05);
        let odd = Sample {
            successes: 26,
            trials: 31,
        };
        let (chance, met) = rate(&numbers("0.8387").remove(0), odd);
        assert!(met && chance < 0.02, "{chance}");
    }
}
