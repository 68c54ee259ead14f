//! Why a model's change is offered, and what has to be known before it is accepted.

use evidence::{StudyResult, Subject};
use refinement::{Changed, Counts, ModelChange, SAME, Trial, Values, rate_of};

/// A p-value below which a predicted rate is not that of the counts.
const OFF: f64 = 0.05;

pub(super) fn reason(
    change: &ModelChange,
    [rate, after]: [Option<f64>; 2],
    counts: &Counts,
) -> String {
    let mode = change.subject().in_words();
    let rate = rate.unwrap_or(0.0);
    match change {
        ModelChange::Branch {
            at: Some(_), name, ..
        } => format!(
            "No command of the model leads to {}, so that its rate of {mode} is {rate}, and it was counted in {}. A branch that leads \
             there has the probability with which both are the same.",
            name.replace('_', " "),
            counts.words()
        ),
        ModelChange::Branch { .. } => format!(
            "The model does not know {mode}, which was seen in {}.",
            counts.words()
        ),
        ModelChange::Rate { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}.",
            counts.words()
        ),
        ModelChange::Solve {
            subject: Subject::Requirement(_),
            ..
        } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. One number of the model is solved for so that \
             both are the same.",
            counts.words()
        ),
        ModelChange::Solve { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. No constant is that share: what decides it \
             acts more than once in a run, or several act together, so that it is solved for.",
            counts.words()
        ),
        ModelChange::Split { split, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. It {} `{}`{}. With a branch that \
             has this probability they agree, and nothing has to be fitted for it.",
            counts.words(),
            if split.by.is_term() {
                "adds"
            } else {
                "declares"
            },
            split.by.written_for(),
            if split.by.is_term() {
                " to the probability of something else"
            } else {
                " and uses it nowhere"
            },
        ),
        ModelChange::Idle { change, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. In the model's text {}. With this change they agree, \
             and nothing has to be fitted for it.",
            counts.words(),
            change.hint()
        ),
        ModelChange::Slip { change, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. If {}, they agree, and nothing has to be fitted for it.",
            counts.words(),
            change.supposed()
        ),
        ModelChange::Branchless { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. Without one branch of a command they {}, and \
             nothing has to be fitted for it.",
            counts.words(),
            match after.and_then(|after| counts.p_value(after)) {
                Some(p) if p < OFF => "come within the margin of each other",
                _ => "agree",
            }
        ),
        ModelChange::Once { .. } => format!(
            "The model's constant is the counted share ({}), but its rate of {mode} is {rate:.6}: it draws again and \
             again where the counts have one opportunity.",
            counts.words()
        ),
    }
}

/// That nothing but the rate to which a number is fitted speaks for it.
pub(super) fn alone(change: &ModelChange, tried: &Trial) -> Option<String> {
    let ModelChange::Solve { subject, .. } = change else {
        return None;
    };
    let is_checked = tried.repairs.iter().any(|it| it.subject != *subject);
    (!is_checked && !tried.repairs.is_empty()).then(|| {
        format!(
            "Nothing but the rate of {} speaks for this number, and one number can be made to give one rate whatever is wrong: look at \
             the guards and branches that bear on it first.",
            subject.in_words()
        )
    })
}

/// What a change of a rate does not yet fix.
pub(super) fn remains(change: &ModelChange, changed: &Changed) -> Option<String> {
    let ModelChange::Rate { counts, mode, .. } = change else {
        return None;
    };
    let rate = rate_of(&changed.values, mode)?;
    let is_far = (rate - counts.rate()).abs() > SAME * counts.rate().max(SAME);
    is_far.then(|| {
        format!(
            "The rate then still is {rate:.6} and not {:.6}; refine again after this one.",
            counts.rate()
        )
    })
}

/// Requirements that the data of the real system miss, and that the changed model would meet: the change would hide it.
pub(super) fn hides(
    result: &StudyResult,
    change: &ModelChange,
    before: &Values,
    after: &Values,
) -> Vec<String> {
    let counts = change.counts();
    let of = |requirement: &evidence::Requirement| {
        let subject = Subject::Requirement(requirement.id.clone());
        let value = |values: &Values| values.get(&subject).copied().flatten();
        let (now, then) = (value(before)?, value(after)?);
        let meets = |rate: f64| is_met(requirement, rate);
        let missed = result.evidence.iter().filter(|piece| {
            let is_real = piece.technique.is_of_system();
            is_real && piece.id != counts.evidence && !piece.intermediate
        });
        let mut missed = missed.filter_map(|piece| {
            let counted = Counts::of(&result.evidence, &piece.id, &subject)?;
            let misses = !meets(counted.rate());
            misses.then(|| counted.words())
        });
        let missed = missed.next().filter(|_| meets(then) && !meets(now))?;
        Some(format!(
            "The model then meets requirement {}, which the system misses ({missed}): this would hide a defect.",
            requirement.id
        ))
    };
    result.requirements.iter().filter_map(of).collect()
}

/// Whether a rate is on the side of the threshold that is required.
fn is_met(requirement: &evidence::Requirement, rate: f64) -> bool {
    match requirement.threshold {
        Some(threshold) => match threshold.direction {
            evidence::Direction::AtLeast => rate >= threshold.value,
            evidence::Direction::AtMost => rate <= threshold.value,
        },
        None => rate >= 1.0,
    }
}
