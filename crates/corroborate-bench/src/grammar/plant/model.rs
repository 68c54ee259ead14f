//! Faults of formal models: wrong constants, ways to fail that are missing or never happen.

use super::{Planted, culprit, trials_of, worth};
use crate::grammar::draft::Draft;
use crate::grammar::files::{ids, names};
use crate::grammar::machine::{Factor, Machine, Time};
use crate::random::Random;
use crate::theory::{Side, power};

/// A value by this factor: odds are scaled, so that a probability stays one.
pub(super) fn scaled_value(value: f64, factor: f64, is_rate: bool) -> f64 {
    let wrong = if is_rate {
        value * factor
    } else {
        value * factor / (1.0 - value + value * factor)
    };
    (wrong * 1e4).round().max(1.0) / 1e4
}

/// A factor from hardly visible to gross, to either side.
pub(super) fn factor(random: &mut Random) -> f64 {
    let by = random.log_between(1.5, 8.0);
    if random.chance(0.6) { by } else { 1.0 / by }
}

/// A mode whose constant acts once in a run, or several times, and is not set to counts.
pub(super) fn mode_of(draft: &Draft, repeats: bool, random: &mut Random) -> Option<usize> {
    let is_set = |name: &str| draft.rigs.iter().any(|rig| rig.mode == name);
    let modes = draft.truth.modes.iter().enumerate();
    let fit = modes.filter(|(_, mode)| mode.repeats == repeats && !is_set(&mode.name));
    let fit: Vec<usize> = fit.map(|(place, _)| place).collect();
    (!fit.is_empty()).then(|| fit[random.below(fit.len())])
}

pub(super) fn is_rate(machine: &Machine, constant: usize) -> bool {
    let mut factors = machine
        .commands
        .iter()
        .flat_map(|it| &it.branches)
        .flat_map(|it| &it.weight);
    machine.time == Time::Rates && !factors.any(|it| *it == Factor::Not(constant))
}

pub(super) fn constant(
    draft: &mut Draft,
    planted: &mut Planted,
    repeats: bool,
    random: &mut Random,
) -> Option<()> {
    let place = mode_of(draft, repeats, random)?;
    let constant = draft.truth.modes[place].constant;
    let was = draft.truth.constants[constant].value;
    let wrong = scaled_value(was, factor(random), is_rate(&draft.truth, constant));
    draft.formal.constants[constant].value = wrong;
    planted.words = format!(
        "{} is {wrong} instead of {was} in the model",
        draft.truth.constants[constant].name
    );
    of_model(draft, planted, place);
    Some(())
}

/// A fault of the model at a mode.
pub(super) fn of_model(draft: &Draft, planted: &mut Planted, place: usize) {
    planted.culprits = vec![culprit("formal-model", "")];
    planted.subjects = touched(draft, &draft.formal, place);
    planted.mended_in = vec![names::MODEL];
    let constant = draft.truth.modes[place].constant;
    if !draft.style.inline[constant] {
        planted.mended_by = draft.style.constant(&draft.truth, constant);
    }
    planted.power = of_machines(draft, &draft.formal, None);
}

/// The subjects that a machine has otherwise than the truth; the mode at `place` is one of them.
pub(super) fn touched(draft: &Draft, machine: &Machine, place: usize) -> Vec<String> {
    let mut all = vec![draft.truth.modes[place].name.clone()];
    let differs = |one: Option<f64>, other: Option<f64>| match (one, other) {
        (Some(one), Some(other)) => (one - other).abs() > 1e-3,
        (one, other) => one.is_some() != other.is_some(),
    };
    for (mode, own) in draft.truth.modes.iter().zip(&machine.modes) {
        if mode.name != all[0] && differs(draft.truth.rate(mode), machine.rate(own)) {
            all.push(mode.name.clone());
        }
    }
    all.extend([ids::DONE, ids::IN_TIME, ids::RESPONSE].map(str::to_owned));
    all
}

/// The power of the best test between a wrong machine and what is right: of a model whose numbers are computed where
/// `episodes` is none, else of a simulator's so many episodes.
pub(super) fn of_machines(draft: &Draft, wrong: &Machine, episodes: Option<f64>) -> f64 {
    let truth = &draft.truth;
    let trials = trials_of(draft);
    let mut best: f64 = 0.0;
    let mut look = |wrong_rate: f64, right: f64, reached: f64, wrong_reached: f64| {
        let side = match episodes {
            None => Side::computed(wrong_rate),
            Some(episodes) => Side::independent(wrong_rate, (episodes * wrong_reached).max(1.0)),
        };
        let mut others = vec![Side::independent(
            right,
            worth(draft, trials * reached).max(1.0),
        )];
        match episodes {
            None => others.push(Side::independent(
                right,
                (draft.sizes.episodes as f64 * reached).max(1.0),
            )),
            Some(_) => others.push(Side::computed(right)),
        }
        for other in others {
            best = best.max(power(side, other, 0.05));
        }
    };
    // A model whose constants were counted leaves its answer open by as much as these counts do.
    if draft.rigs.is_empty() {
        let (one, other) = (wrong.reaches(wrong.done), truth.reaches(truth.done));
        look(one, other, 1.0, 1.0);
    }
    for (mode, own) in truth.modes.iter().zip(&wrong.modes) {
        if let (Some(one), Some(other)) = (wrong.rate(own), truth.rate(mode)) {
            look(one, other, truth.reaches(mode.at), wrong.reaches(own.at));
        }
    }
    best
}

pub(super) fn missing(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let place = mode_of(draft, false, random)?;
    let (at, failed) = (draft.truth.modes[place].at, draft.truth.modes[place].failed);
    let constant = draft.truth.modes[place].constant;
    for command in draft
        .formal
        .commands
        .iter_mut()
        .filter(|command| command.at == at)
    {
        command.branches.retain(|branch| branch.to != failed);
        for branch in &mut command.branches {
            branch.weight.retain(|it| *it != Factor::Not(constant));
        }
    }
    planted.words = format!("the model cannot fail by {}", draft.truth.modes[place].name);
    of_model(draft, planted, place);
    planted.mended_by = String::new();
    Some(())
}

pub(super) fn impossible(
    draft: &mut Draft,
    planted: &mut Planted,
    random: &mut Random,
) -> Option<()> {
    let place = mode_of(draft, false, random)?;
    let constant = draft.truth.modes[place].constant;
    let wrong = (random.log_between(0.03, 0.4) * 1e3).round() / 1e3;
    draft.truth.constants[constant].value = 0.0;
    draft.simulated.constants[constant].value = 0.0;
    draft.formal.constants[constant].value = wrong;
    planted.words = format!(
        "the model fails by {} in {wrong}, the system never",
        draft.truth.modes[place].name
    );
    of_model(draft, planted, place);
    Some(())
}
