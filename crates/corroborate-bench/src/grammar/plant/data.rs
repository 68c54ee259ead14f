//! Faults of tables, simulators and recordings: exchanged columns, parameters, sensors, clocks, people, shared numbers.

use super::model::{factor, is_rate, mode_of, of_machines, scaled_value, touched};
use super::{Plant, Planted, culprit, share, trials_of, worth};
use crate::grammar::draft::{Draft, Rig};
use crate::grammar::files::{ids, names};
use crate::grammar::machine::Time;
use crate::random::Random;
use crate::theory::{Side, power};
use stats::Sample;

pub(super) fn columns(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    let rates = draft
        .truth
        .modes
        .iter()
        .map(|mode| draft.truth.reaches(mode.failed));
    let rates: Vec<f64> = rates.collect();
    let order = |one: &usize, other: &usize| rates[*one].total_cmp(&rates[*other]);
    let low = (0..rates.len()).min_by(order)?;
    let high = (0..rates.len()).max_by(order)?;
    if low == high {
        return None;
    }
    let trials = trials_of(draft);
    planted.power = power(
        Side::independent(rates[high], worth(draft, trials)),
        Side::computed(rates[low]),
        0.05,
    );
    planted.subjects = [low, high]
        .map(|place| draft.truth.modes[place].name.clone())
        .into();
    if planted.plant == Plant::WrongColumn {
        draft.bindings.exchanged = Some((low, high));
        planted.culprits = vec![culprit("vocabulary", "lost_"), culprit("data", "")];
        planted.mended_in = vec![names::VOCABULARY, names::MODES];
    } else {
        draft.bindings.swapped_rows = Some((low, high));
        planted.culprits = vec![culprit("data", "")];
        planted.mended_in = vec![names::MODES, names::COHORT];
    }
    planted.words = format!(
        "{} and {} are exchanged",
        planted.subjects[0], planted.subjects[1]
    );
    Some(())
}

pub(super) fn scaled(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let repeats = random.chance(0.5);
    let place = mode_of(draft, repeats, random).or_else(|| mode_of(draft, !repeats, random))?;
    let constant = draft.truth.modes[place].constant;
    let was = draft.truth.constants[constant].value;
    let wrong = scaled_value(was, factor(random), is_rate(&draft.truth, constant));
    draft.simulated.constants[constant].value = wrong;
    planted.culprits = vec![culprit("simulation", "")];
    planted.subjects = touched(draft, &draft.simulated, place);
    planted.mended_in = vec![names::PARAMETERS];
    planted.mended_by = draft.truth.constants[constant].name.clone();
    planted.power = of_machines(draft, &draft.simulated, Some(draft.sizes.episodes as f64));
    planted.words = format!(
        "{} is {wrong} instead of {was} in the simulator",
        draft.truth.constants[constant].name
    );
    Some(())
}

pub(super) fn drifted(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    draft.sizes.recordings = draft.sizes.recordings.max(40);
    let by = random.one_of(&[0.7, 1.15, 1.3, 1.6]);
    draft.recorded_columns.speed *= by;
    let limit = draft.forms.speed_limit;
    let near = draft.truth.near?;
    let reached = share(draft, &|run, _| run.was_at(near));
    let slow = |limit: f64| {
        share(draft, &|run, speed| run.was_at(near) && speed < limit) / reached.max(1e-9)
    };
    let (right, seen) = (slow(limit), slow(limit / by));
    let sides = [
        Side::independent(seen, (draft.sizes.recordings as f64 * reached).max(1.0)),
        Side::independent(right, (draft.sizes.episodes as f64 * reached).max(1.0)),
    ];
    planted.power = power(sides[0], sides[1], 0.05);
    // Two sources alone speak of it: which of them is wrong, nothing tells.
    planted.culprits = vec![culprit("data", "operation"), culprit("simulation", "")];
    planted.subjects = vec![ids::SLOW.into()];
    planted.words = format!("the recorded speed is {by} of the true one");
    Some(())
}

pub(super) fn clock(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let by = random.one_of(&[0.5, 0.8, 1.25, 2.0]);
    draft.simulated_columns.time *= by;
    let limit = draft.forms.limit_secs;
    let done = draft.truth.done;
    let within = |limit: f64| {
        share(draft, &|run, _| {
            run.entered(done).is_some_and(|at| at <= limit + 1e-9)
        })
    };
    let episodes = Side::independent(within(limit / by), draft.sizes.episodes as f64);
    planted.power = power(episodes, Side::computed(within(limit)), 0.05);
    planted.culprits = vec![culprit("simulation", ""), culprit("time-step", "")];
    planted.subjects = vec![ids::IN_TIME.into()];
    planted.mended_in = vec![names::PROGRAM];
    planted.words = format!("the simulator's clock runs at {by}");
    Some(())
}

pub(super) fn outlier(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let who = random.below(draft.cohort.rows);
    let by = random.one_of(&[4.0, 8.0, 16.0]);
    if draft.truth.time == Time::Rates {
        return None;
    }
    draft.outlier = Some((who, by));
    let own = draft.with_odds_of_failing(by);
    // That row against what the others say, allowing for the choice among all rows.
    let row = Side::independent(own.reaches(own.done), draft.cohort.attempts as f64);
    let others = Side::computed(draft.truth.reaches(draft.truth.done));
    planted.power = power(row, others, 0.05 / draft.cohort.rows as f64);
    planted.culprits = vec![culprit("data", "")];
    planted.subjects = draft
        .truth
        .modes
        .iter()
        .map(|mode| mode.name.clone())
        .collect();
    planted
        .subjects
        .extend([ids::DONE, ids::IN_TIME].map(str::to_owned));
    planted.words = format!("row {} fails {by} times as often", who + 1);
    Some(())
}

pub(super) fn shared(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let place = mode_of(draft, false, random)?;
    let mode = draft.truth.modes[place].clone();
    let was = draft.truth.constants[mode.constant].value;
    let wrong = scaled_value(was, random.log_between(2.0, 6.0), false);
    // Somebody tested the part alone, where it behaves otherwise; both took that number.
    let trials = 200;
    let successes = (0..trials).filter(|_| random.chance(wrong)).count().max(1) as u64;
    draft.set_to_rig(Rig {
        mode: mode.name.clone(),
        sample: Sample { successes, trials },
    });
    draft.simulated.constants[mode.constant].value = successes as f64 / trials as f64;
    planted.subjects = touched(draft, &draft.formal, place);
    planted.culprits = vec![
        culprit("formal-model", ""),
        culprit("simulation", ""),
        culprit("data", "rig"),
    ];
    let worth = worth(draft, trials_of(draft) * draft.truth.reaches(mode.at)).max(1.0);
    let counted = Side::independent(wrong, trials as f64);
    // The simulator says what the model says: the experiment alone can tell.
    planted.power = power(counted, Side::independent(was, worth), 0.05);
    planted.mended_in = vec![names::MODEL, names::PARAMETERS];
    planted.words = format!(
        "model and simulator have {wrong} instead of {was} for {}",
        mode.name
    );
    Some(())
}
