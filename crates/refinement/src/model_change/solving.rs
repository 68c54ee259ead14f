//! A number that acts more than once in a run, or with others, is solved for ([`ModelChange::Solve`]).

use super::{
    Changed, Deciding, ModelChange, NEAR, Read, Refusal, SAME, SetConstant, Solver, Values,
    deciding, deciding_constant, once, rate, rate_of, value_of,
};
use crate::counts::Counts;
use crate::number::{Number, numbers};
use crate::solve::{self, Scale};
use evidence::Subject;
use prism_lang::resolved::ModelType;

/// The most that the log-odds of a constant are changed: a factor of about 160 000.
pub(crate) const FARTHEST: f64 = 12.0;

/// What the log-odds of a constant have to be changed for a change of the structure to be as likely.
const STRUCTURE: f64 = std::f64::consts::LN_10;

/// Decades of disagreement that do not tell two changes apart.
pub(crate) const AS_GOOD: f64 = 0.5;

/// A change that gives the counted rate, what it leaves of the disagreement with all evidence, and how large it is.
struct Candidate {
    left: f64,
    size: f64,
    change: ModelChange,
    changed: Changed,
}

/// The change with which a model has the counted rate, where its constant decides it.
///
/// Setting the constant to the share comes first. If that does not give the rate, the constant acts more than once in a
/// run: then either it is solved for, or it is the share of a draw that is made once. Of the two the one is taken that
/// leaves less disagreement with all evidence (`left`); if both leave as much, to within [`AS_GOOD`], the smaller change
/// in log-odds of the constant, where a change of the structure counts as much as a factor of 10 of the odds.
pub(crate) fn rate_or_solve(
    text: &str,
    solver: &dyn Solver,
    (mode, occurs, counts): (String, String, Counts),
    left: &dyn Fn(&Values) -> f64,
) -> Result<(ModelChange, Changed), Refusal> {
    let near = |changed: &Changed| {
        let rate = rate_of(&changed.values, &mode);
        rate.is_some_and(|rate| (rate - counts.rate()).abs() <= NEAR * counts.rate().max(SAME))
    };
    let of_rate = || ModelChange::Rate {
        mode: mode.clone(),
        occurs: occurs.clone(),
        counts: counts.clone(),
    };
    let set = rate(text, solver, &occurs, (&mode, &counts));
    if set.as_ref().is_ok_and(near) {
        return set.map(|changed| (of_rate(), changed));
    }
    let set = set.and_then(|changed| moves(text, solver, &mode, changed));
    let distance = |value: f64| {
        let now = deciding_constant(text, &occurs).map_or(value, |(_, now)| now);
        Scale::Odds.distance(value, now)
    };
    let mut options = Vec::new();
    if let Ok(changed) = &set
        && let Ok(next) = once(&changed.text, solver, &mode, &occurs)
    {
        options.push(Candidate {
            left: left(&next.values),
            size: distance(counts.rate()) + STRUCTURE,
            change: of_rate(),
            changed: Changed {
                settled: Some(next.values),
                ..changed.clone()
            },
        });
    }
    options.extend(
        solved_options(text, solver, (&mode, &occurs, &counts), left)
            .into_iter()
            .flatten(),
    );
    match best(options) {
        Some(made) => Ok(with_interval(text, solver, made)),
        None => set.map(|changed| (of_rate(), changed)),
    }
}

/// A change whose constant bears on the rate, and is a probability: a share of runs is not how often something comes in a unit of
/// time, and where nothing leads to the draw its probability is not what is wrong.
fn moves(
    text: &str,
    solver: &dyn Solver,
    mode: &str,
    changed: Changed,
) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    if read.model.model_type == ModelType::Ctmc {
        return Err("the counted share cannot be a rate in continuous time".into());
    }
    let (was, is) = (
        rate_of(&solver.values(text)?, mode),
        rate_of(&changed.values, mode),
    );
    let is_moved = match (was, is) {
        (Some(was), Some(is)) => (was - is).abs() > SAME * was.abs().max(is.abs()),
        (was, is) => was.is_some() != is.is_some(),
    };
    match is_moved {
        true => Ok(changed),
        false => Err(
            "its rate stays as it is with the counted share: what leads there is not taken".into(),
        ),
    }
}

/// The draw made once where the constant has the counted share already: whoever set it to the share meant one draw, and a
/// constant that was set to counts keeps them. Where no draw made once gives the rate, the constant is solved for.
pub(crate) fn once_or_solve(
    text: &str,
    solver: &dyn Solver,
    (mode, occurs, counts): (String, String, Counts),
    left: &dyn Fn(&Values) -> f64,
) -> Result<(ModelChange, Changed), Refusal> {
    match once(text, solver, &mode, &occurs) {
        Ok(changed) => Ok((
            ModelChange::Once {
                mode,
                occurs,
                counts,
            },
            changed,
        )),
        Err(refusal) => solved_options(text, solver, (&mode, &occurs, &counts), left)
            .ok()
            .and_then(best)
            .map(|made| with_interval(text, solver, made))
            .ok_or(refusal),
    }
}

/// The constants solved for that decide a proposition; where nothing is left to chance there, any of the model's.
fn solved_options(
    text: &str,
    solver: &dyn Solver,
    (mode, occurs, counts): (&str, &str, &Counts),
    left: &dyn Fn(&Values) -> f64,
) -> Result<Vec<Candidate>, Refusal> {
    let read = Read::new(text)?;
    let found = match read.equalities(occurs) {
        // What decides it is not read off the text: whatever moves it may.
        Err(_) => Ok(Deciding::Certain),
        Ok(_) => deciding(&read, occurs),
    };
    let (names, is_any) = match found? {
        Deciding::Constant(name) => (constants(vec![name]), false),
        // Its chance is written into a command.
        Deciding::Expression(names) if names.is_empty() => (numbers(&read), true),
        Deciding::Expression(names) => (constants(names), false),
        Deciding::Certain => (constants(read.chances()), true),
    };
    let subject = Subject::FailureMode(mode.to_owned());
    let mut found = solved(text, solver, &names, (&subject, counts))?;
    if !is_any {
        // Constants of one expression act at one place: the smaller change is as good a guess as any.
        found.truncate(1);
    }
    let candidate = |it: Solved| Candidate {
        left: left(&it.changed.values),
        size: it.size,
        change: ModelChange::Solve {
            subject: subject.clone(),
            number: it.number,
            counts: counts.clone(),
        },
        changed: it.changed,
    };
    Ok(found.into_iter().map(candidate).collect())
}

fn constants(names: Vec<String>) -> Vec<Number> {
    names.into_iter().map(Number::Constant).collect()
}

/// A number as it is called in words: a constant by its name, a literal with its line.
fn at_its_line(number: &Number, text: &str) -> String {
    match (number, number.line(text)) {
        (Number::Literal { digits, .. }, Some(line)) => format!("{digits} of line {line}"),
        _ => number.name().to_owned(),
    }
}

/// The one that leaves least disagreement; of those that leave as much, the smallest.
fn best(options: Vec<Candidate>) -> Option<(ModelChange, Changed)> {
    let least = options
        .iter()
        .map(|it| it.left)
        .fold(f64::INFINITY, f64::min);
    let good = options.into_iter().filter(|it| it.left <= least + AS_GOOD);
    let best = good.min_by(|a, b| a.size.total_cmp(&b.size))?;
    Some((best.change, best.changed))
}

/// A model with a number solved for.
pub(crate) struct Solved {
    pub(crate) number: Number,
    /// How far its log-odds moved.
    size: f64,
    pub(crate) changed: Changed,
}

/// The models with each of these constants solved for, of those with which the model has the counted rate; the smallest
/// change first.
pub(crate) fn solved(
    text: &str,
    solver: &dyn Solver,
    names: &[Number],
    (subject, counts): (&Subject, &Counts),
) -> Result<Vec<Solved>, Refusal> {
    let read = Read::new(text)?;
    let mut found: Vec<(f64, &Number, f64)> = Vec::new();
    for name in names {
        let Some((now, scale)) = name.value(&read) else {
            continue;
        };
        let mut rate = |value: f64| rate_with(&read, solver, name, value, subject);
        if let Some(value) = solve::crossing(&mut rate, (now, scale), counts.rate(), FARTHEST) {
            found.push((scale.distance(value, now), name, value));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    if found.is_empty() {
        return Err(match names {
            [] => "its probability has no constant of the model".into(),
            all => {
                let names: Vec<&str> = all.iter().map(Number::name).collect();
                format!(
                    "no value of {} was found that gives the counted rate, from the one that is written on",
                    names.join(" or ")
                )
            }
        });
    }
    let one = |(size, name, value): &(f64, &Number, f64)| {
        let others = found.iter().filter(|(_, other, _)| other != name);
        let notes: Vec<String> = others
            .map(|(_, name, value)| {
                format!(
                    "{} = {} would give the same rate.",
                    name.name(),
                    digits(*value)
                )
            })
            .collect();
        let text = name.set(&read, *value)?;
        Ok(Solved {
            number: (*name).clone(),
            size: *size,
            changed: Changed {
                values: solver.values(&text)?,
                text,
                what: format!(
                    "{} set to {}, with which the rate is that of {}",
                    at_its_line(name, read.text),
                    digits(*value),
                    counts.words()
                ),
                constant: Some(SetConstant {
                    name: at_its_line(name, read.text),
                    is_complement: false,
                    is_solved: true,
                    value: Some(*value),
                }),
                notes,
                alternatives: Vec::new(),
                settled: None,
            },
        })
    };
    found.iter().map(one).collect()
}

/// The change with what the interval of the counts leaves open, where a constant was solved for.
pub(crate) fn with_interval(
    text: &str,
    solver: &dyn Solver,
    (change, mut changed): (ModelChange, Changed),
) -> (ModelChange, Changed) {
    if let ModelChange::Solve {
        subject,
        number,
        counts,
    } = &change
        && let Ok(read) = Read::new(text)
        && let Some(value) = changed.constant.as_ref().and_then(|it| it.value)
        && let Some([low, high]) = interval_of(&read, solver, number, value, (subject, counts))
    {
        changed.notes.push(format!(
            "{} lies between {} and {}, by the interval of the counted rate, {:.1} to {:.1} %{}.",
            at_its_line(number, text),
            digits(low),
            digits(high),
            100.0 * counts.interval()[0],
            100.0 * counts.interval()[1],
            also_with(&read, solver, number, value, (subject, counts))
        ));
    }
    (change, changed)
}

/// With which other values the rate is the same, in words; nothing where none is found.
fn also_with(
    read: &Read,
    solver: &dyn Solver,
    number: &Number,
    value: f64,
    (subject, counts): (&Subject, &Counts),
) -> String {
    let Some((_, scale)) = number.value(read) else {
        return String::new();
    };
    let mut rate = |value: f64| rate_with(read, solver, number, value, subject);
    let others = solve::other_crossings(&mut rate, (value, scale), counts.rate(), FARTHEST);
    let others: Vec<String> = others.into_iter().map(digits).collect();
    match others.is_empty() {
        true => String::new(),
        false => format!(
            ", unless it is another solution: {} gives the same rate, too",
            others.join(" or ")
        ),
    }
}

/// The constant at the ends of the interval of the counts, in order.
fn interval_of(
    read: &Read,
    solver: &dyn Solver,
    number: &Number,
    value: f64,
    (subject, counts): (&Subject, &Counts),
) -> Option<[f64; 2]> {
    let [low, high] = counts.interval();
    let (_, scale) = number.value(read)?;
    let mut rate = |value: f64| rate_with(read, solver, number, value, subject);
    let one = solve::crossing(&mut rate, (value, scale), low, FARTHEST)?;
    let other = solve::crossing(&mut rate, (value, scale), high, FARTHEST)?;
    Some([one.min(other), one.max(other)])
}

pub(super) fn rate_with(
    read: &Read,
    solver: &dyn Solver,
    number: &Number,
    value: f64,
    subject: &Subject,
) -> Option<f64> {
    let text = number.set(read, value).ok()?;
    value_of(&solver.values(&text).ok()?, subject)
}

/// A number with six significant digits, as the PRISM language reads it.
pub(crate) fn digits(value: f64) -> String {
    let digits: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{digits}")
}
