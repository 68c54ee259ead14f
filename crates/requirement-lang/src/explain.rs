//! What was understood of a sentence, in words and as a small diagram, for a person to confirm.

use crate::sentence::{Amount, ConditionKind, Scope, ScopeKind, Sentence, Stage, Timing};

/// An explanation of a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// What is required, one statement to a line.
    pub words: Vec<String>,
    /// A drawing of scope, trigger and response on a line of time, in plain text.
    pub diagram: String,
}

/// Explains a sentence.
///
/// ```
/// use requirement_lang::{Context, explain, parse};
/// let text = "While lifting, when near, the robot shall within 2 s satisfy slow";
/// let explanation = explain(&parse(text, &Context::default()).tree);
/// assert_eq!(explanation.words, [
///     "Applies in each interval in which `lifting` holds.",
///     "Is triggered each time `near` becomes true in such an interval, and at its beginning if \
///      `near` is true then.",
///     "From each trigger on: `slow` must hold at some time within 2 s; excused if the interval ends \
///      before.",
///     "Every run must meet this.",
/// ]);
/// ```
#[must_use]
pub fn explain(sentence: &Sentence) -> Explanation {
    let mut words = vec![scope(&sentence.scope), trigger(sentence)];
    words.extend(stages(sentence));
    words.extend(sentence.stages.iter().find_map(exact_instant));
    words.push(match &sentence.probability {
        None => "Every run must meet this.".to_owned(),
        Some(probability) => format!(
            "The probability that a run meets this, at all its triggers, must be {} {}.",
            probability.comparison.words(),
            probability.decimal
        ),
    });
    Explanation {
        words,
        diagram: diagram(sentence),
    }
}

/// What a recording has to be like for a stage, if it has to be.
fn exact_instant(stage: &Stage) -> Option<String> {
    let exact = match &stage.timing {
        Timing::After(duration) => matches!(duration.amount, Amount::Secs(secs) if secs > 0.0),
        _ => false,
    };
    exact.then(|| {
        "Note: `after` so many seconds asks for a sample at that exact instant; a recording whose \
         samples are not at equal steps has none and does not meet it, so prefer `within`."
            .to_owned()
    })
}

fn scope(scope: &Scope) -> String {
    let mode = &scope.mode;
    match scope.kind {
        ScopeKind::Global => "Applies throughout each run.".to_owned(),
        ScopeKind::In => format!("Applies in each interval in which `{mode}` holds."),
        ScopeKind::NotIn => format!("Applies in each interval in which `{mode}` does not hold."),
        ScopeKind::Before => {
            format!(
                "Applies from the beginning until `{mode}` first holds, or throughout if it never does."
            )
        }
        ScopeKind::After => {
            format!("Applies from the end of the first interval in which `{mode}` holds.")
        }
        ScopeKind::OnlyIn => format!(
            "Forbids the response where `{mode}` does not hold; demands nothing where it does."
        ),
        ScopeKind::OnlyBefore => {
            format!("Forbids the response from where `{mode}` first holds; demands nothing before.")
        }
        ScopeKind::OnlyAfter => format!(
            "Forbids the response until the first interval in which `{mode}` holds has ended; demands \
             nothing after."
        ),
    }
}

fn trigger(sentence: &Sentence) -> String {
    let everywhere = sentence.scope.kind == ScopeKind::Global;
    let (place, beginning) = if everywhere {
        ("", "of the run")
    } else {
        (" in such an interval", "")
    };
    let begin = if everywhere {
        format!("at the beginning {beginning}")
    } else {
        "at its beginning".to_owned()
    };
    match &sentence.condition {
        None if everywhere => "Is triggered once, at the beginning of the run.".to_owned(),
        None => "Is triggered once in each such interval, at its beginning.".to_owned(),
        Some(condition) => {
            let what = &condition.expression;
            let (becomes, is) = match condition.kind {
                ConditionKind::Unless => ("false", "false"),
                _ => ("true", "true"),
            };
            match condition.kind {
                ConditionKind::Whenever => {
                    format!("Is triggered at all times{place} at which `{what}` is true.")
                }
                _ => format!(
                    "Is triggered each time `{what}` becomes {becomes}{place}, and {begin} if `{what}` is \
                     {is} then."
                ),
            }
        }
    }
}

fn stages(sentence: &Sentence) -> Vec<String> {
    let ends = !matches!(
        sentence.scope.kind,
        ScopeKind::Global | ScopeKind::After | ScopeKind::OnlyBefore
    );
    let only = sentence.scope.kind.is_only();
    let count = sentence.stages.len();
    let mut lines = Vec::new();
    for (index, stage) in sentence.stages.iter().enumerate() {
        let followed = index + 1 < count;
        let start = match index {
            0 => "From each trigger on",
            _ => "Then, from there on",
        };
        let text = if only {
            forbidden(stage)
        } else {
            demanded(stage, ends, followed)
        };
        lines.push(format!("{start}: {text}."));
    }
    lines
}

/// What a stage demands; `ends`: of a scope that can end; `followed` by another stage.
fn demanded(stage: &Stage, ends: bool, followed: bool) -> String {
    let response = format!("`{}`", stage.response);
    let (excused, to_the_end) = match ends {
        true => (
            "; excused if the interval ends before",
            "to the end of the interval",
        ),
        false => ("", "to the end of the run"),
    };
    match &stage.timing {
        Timing::Immediately => format!("{response} must hold at once"),
        Timing::Next => format!("{response} must hold at the next step{excused}"),
        Timing::Eventually if ends => {
            format!("{response} must hold at some time before the interval ends")
        }
        Timing::Eventually => format!("{response} must hold at some time"),
        Timing::Always => format!("{response} must hold all the time {to_the_end}"),
        Timing::Never => format!("{response} must not hold at any time {to_the_end}"),
        Timing::Within(duration) => {
            format!("{response} must hold at some time within {duration}{excused}")
        }
        Timing::For(duration) if ends => format!(
            "{response} must hold for {duration}, or to the end of the interval if that comes before"
        ),
        Timing::For(duration) => format!("{response} must hold for {duration}"),
        Timing::After(duration) => format!(
            "{response} must not hold before {duration} have passed, and must hold then{excused}"
        ),
        Timing::Until(stop) | Timing::Before(stop) => {
            let ending = if followed { excused } else { to_the_end };
            demanded_until(stage, &stop.to_string(), followed, ending)
        }
    }
}

/// The same for the timings with a stop condition. `ending`: what is said of the end of the interval.
fn demanded_until(stage: &Stage, stop: &str, followed: bool, ending: &str) -> String {
    let response = format!("`{}`", stage.response);
    match (&stage.timing, followed) {
        (Timing::Until(_), true) => {
            format!("{response} must hold until `{stop}` holds, which must come{ending}")
        }
        (Timing::Until(_), false) => {
            format!("{response} must hold until `{stop}` holds, or {ending} if it does not")
        }
        (_, true) => {
            format!(
                "{response} must hold at some time, and `{stop}` not before or at that time{ending}"
            )
        }
        (_, false) => format!(
            "{response} must hold at some time before `{stop}` holds; excused if that does not come"
        ),
    }
}

/// What a stage forbids in a scope with `only`.
fn forbidden(stage: &Stage) -> String {
    let response = format!("`{}`", stage.response);
    match &stage.timing {
        Timing::Immediately => format!("{response} must not hold at once"),
        Timing::Next => format!("{response} must not hold at the next step, if there is one"),
        Timing::Eventually => format!("{response} must not hold at any time"),
        Timing::Always => format!("{response} must fail to hold at some time"),
        Timing::Never => format!("{response} must hold at some time"),
        Timing::Within(duration) => {
            format!("{response} must not hold at any time within {duration}")
        }
        Timing::For(duration) => {
            format!(
                "{response} must fail to hold at some time within {duration}; excused if the interval ends before"
            )
        }
        Timing::After(duration) => {
            format!(
                "{response} must hold earlier than {duration}, or not hold when {duration} have passed"
            )
        }
        Timing::Until(stop) => {
            format!(
                "{response} must fail to hold at some time before `{stop}` holds; excused if that does not come"
            )
        }
        Timing::Before(stop) => {
            format!("{response} must not hold at any time before `{stop}` holds")
        }
    }
}

/// A line of time: the scope in brackets, the trigger `T`, and below it where the response matters.
///
/// ```text
///      [lifting ............)
///      . . . T======2 s=====|
///            ^ near          at some time: slow
/// ```
fn diagram(sentence: &Sentence) -> String {
    let (left, right, label) = extent(&sentence.scope);
    let mut scope = vec![' '; WIDTH];
    scope[left..right].fill('-');
    scope[left] = '[';
    scope[right - 1] = if right == WIDTH { '>' } else { ')' };
    let at = left + 6 * usize::from(sentence.condition.is_some());
    let mut trigger = vec![' '; WIDTH];
    trigger[at] = 'T';
    let mut lines = vec![
        line("scope", scope, &label),
        line("trigger", trigger, &triggered_by(sentence)),
    ];
    let mut start = at;
    for stage in &sentence.stages {
        let (drawn, end) = stage_line(stage, start, right, sentence.scope.kind.is_only());
        lines.push(drawn);
        start = end;
    }
    lines.join("\n")
}

/// How many letters the line of time has.
const WIDTH: usize = 48;

fn line(name: &str, drawn: Vec<char>, text: &str) -> String {
    format!("{name:<9} {} {text}", drawn.into_iter().collect::<String>())
}

fn triggered_by(sentence: &Sentence) -> String {
    let Some(condition) = &sentence.condition else {
        return "beginning of the scope".to_owned();
    };
    let how = match condition.kind {
        ConditionKind::Upon => "becomes true",
        ConditionKind::Whenever => "is true",
        ConditionKind::Unless => "becomes false",
    };
    format!("{} {how}", condition.expression)
}

/// Where the scope is drawn, and what it is called.
fn extent(scope: &Scope) -> (usize, usize, String) {
    let mode = &scope.mode;
    match scope.kind {
        ScopeKind::Global => (0, 48, "the whole run".to_owned()),
        ScopeKind::In => (6, 42, format!("{mode}")),
        ScopeKind::NotIn => (6, 42, format!("not ({mode})")),
        ScopeKind::Before => (0, 42, format!("before {mode}")),
        ScopeKind::After => (6, 48, format!("after {mode}")),
        ScopeKind::OnlyIn => (6, 42, format!("not ({mode}): response forbidden")),
        ScopeKind::OnlyBefore => (6, 48, format!("from {mode} on: response forbidden")),
        ScopeKind::OnlyAfter => (
            0,
            42,
            format!("up to the end of {mode}: response forbidden"),
        ),
    }
}

/// The line of one stage that begins at `start`, and where the next one begins.
fn stage_line(stage: &Stage, start: usize, right: usize, only: bool) -> (String, usize) {
    let time = (start + 12).min(right - 1);
    let (from, to, kind, next) = match &stage.timing {
        Timing::Immediately => (start, start + 1, '#', start),
        Timing::Next => (start + 1, start + 2, '#', start + 1),
        Timing::Eventually => (start, right, '?', time),
        Timing::Always => (start, right, '#', start),
        Timing::Never => (start, right, 'x', start),
        Timing::Within(_) | Timing::Before(_) => (start, time, '?', time),
        Timing::For(_) | Timing::Until(_) => (start, time, '#', time),
        Timing::After(_) => (start, time, 'x', time),
    };
    let mut drawn = vec![' '; WIDTH];
    drawn[from..to.min(WIDTH)].fill(kind);
    let end = match &stage.timing {
        Timing::Within(duration) | Timing::For(duration) => format!(", up to {duration}"),
        Timing::After(duration) => {
            drawn[time] = '#';
            format!(", {duration}")
        }
        Timing::Until(stop) | Timing::Before(stop) => format!(", up to {stop}"),
        _ => String::new(),
    };
    let meaning = match kind {
        _ if matches!(stage.timing, Timing::Immediately | Timing::Next) => "at that point (#)",
        '?' => "at some time (?)",
        'x' => "at no time (x)",
        _ => "all the time (#)",
    };
    let negation = if only { "not: " } else { "" };
    let text = format!("{negation}{}, {meaning}{end}", stage.response);
    (line("response", drawn, &text), next.min(right - 2))
}
