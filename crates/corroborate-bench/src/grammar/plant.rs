//! The catalogue of faults of generated studies, and how each is planted.
//!
//! Magnitudes go from hardly visible to gross. The *power in theory* of a planted fault is that of the best single test
//! on the data of the study: for a rate that differs, the difference test of [`crate::theory`] at the 5 % level between
//! the faulty asset and the other source that tells most, on the subject that tells most; for two forms that judge
//! runs differently, the probability that one of the runs shows it. Rates of bounded times are counted on 4000 runs of
//! the truth.

use super::draft::{Draft, Rig, Stream};
use super::files::{ids, names};
use super::machine::{Factor, Machine, Run, Time};
use crate::random::Random;
use crate::theory::{Side, power, seen};
use stats::Sample;

/// A fault of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Plant {
    /// Nothing.
    Nothing,
    /// A constant of the model is wrong, and acts once in a run.
    WrongConstant,
    /// A constant of the model is wrong, and acts several times in a run.
    RepeatedConstant,
    /// The model lacks a way to fail.
    MissingBranch,
    /// The model fails in a way that never happens.
    ImpossibleBranch,
    /// The property has another limit of time.
    PropertyBound,
    /// The monitor has another limit of time.
    MonitorBound,
    /// The property waits for the end instead of success.
    PropertyClause,
    /// The monitor waits for the end instead of success.
    MonitorClause,
    /// A word means another state of the model.
    ModelBinding,
    /// A word means another state of traces.
    TraceBinding,
    /// Words count each other's columns.
    WrongColumn,
    /// Two kinds of failure were written down as each other.
    SwappedRows,
    /// The limit of speed has another unit.
    SpeedUnit,
    /// The map of topics declares another unit of length.
    TopicUnit,
    /// A parameter of the simulator is scaled.
    ScaledParameter,
    /// The speed sensor of the recorded system drifted.
    DriftedSensor,
    /// The simulator's clock is wrong.
    WrongClock,
    /// One person fails much more often than all others.
    OutlierPerson,
    /// Model and simulator share a wrong number.
    SharedAssumption,
}

/// Whom it is right to suspect first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Culprit {
    /// The kind of the suspect, as in the program's output.
    pub kind: &'static str,
    /// A part of its file's or part's name that has to be there; empty for any.
    pub names: String,
}

/// What was planted.
#[derive(Clone, Debug)]
pub struct Planted {
    /// The fault.
    pub plant: Plant,
    /// Whom it is right to suspect first; any of them.
    pub culprits: Vec<Culprit>,
    /// The subjects that it touches.
    pub subjects: Vec<String>,
    /// The files in which a change can mend it; empty where no text can.
    pub mended_in: Vec<&'static str>,
    /// What a line that mends it contains; empty for any.
    pub mended_by: String,
    /// The power of the best single test.
    pub power: f64,
    /// What was done, in words.
    pub words: String,
}

impl Plant {
    /// All faults, after nothing.
    pub const ALL: [Plant; 20] = [
        Plant::Nothing,
        Plant::WrongConstant,
        Plant::RepeatedConstant,
        Plant::MissingBranch,
        Plant::ImpossibleBranch,
        Plant::PropertyBound,
        Plant::MonitorBound,
        Plant::PropertyClause,
        Plant::MonitorClause,
        Plant::ModelBinding,
        Plant::TraceBinding,
        Plant::WrongColumn,
        Plant::SwappedRows,
        Plant::SpeedUnit,
        Plant::TopicUnit,
        Plant::ScaledParameter,
        Plant::DriftedSensor,
        Plant::WrongClock,
        Plant::OutlierPerson,
        Plant::SharedAssumption,
    ];

    /// Its name in tables and folders.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Plant::Nothing => "nothing",
            Plant::WrongConstant => "wrong-constant",
            Plant::RepeatedConstant => "repeated-constant",
            Plant::MissingBranch => "missing-branch",
            Plant::ImpossibleBranch => "impossible-branch",
            Plant::PropertyBound => "property-bound",
            Plant::MonitorBound => "monitor-bound",
            Plant::PropertyClause => "property-clause",
            Plant::MonitorClause => "monitor-clause",
            Plant::ModelBinding => "model-binding",
            Plant::TraceBinding => "trace-binding",
            Plant::WrongColumn => "wrong-column",
            Plant::SwappedRows => "swapped-rows",
            Plant::SpeedUnit => "speed-unit",
            Plant::TopicUnit => "topic-unit",
            Plant::ScaledParameter => "scaled-parameter",
            Plant::DriftedSensor => "drifted-sensor",
            Plant::WrongClock => "wrong-clock",
            Plant::OutlierPerson => "outlier-person",
            Plant::SharedAssumption => "shared-assumption",
        }
    }
}

fn culprit(kind: &'static str, names: &str) -> Culprit {
    Culprit {
        kind,
        names: names.to_owned(),
    }
}

/// Plants a fault; `None` where the system has nothing that it could be planted in.
#[must_use]
pub fn plant(plant: Plant, draft: &mut Draft) -> Option<Planted> {
    let mut random = Random::new(draft.seed.0 ^ 0x666c_6177, draft.seed.1);
    let mut planted = Planted {
        plant,
        culprits: Vec::new(),
        subjects: Vec::new(),
        mended_in: Vec::new(),
        mended_by: String::new(),
        power: 0.0,
        words: "nothing".into(),
    };
    let done = match plant {
        Plant::Nothing => Some(()),
        Plant::WrongConstant => constant(draft, &mut planted, false, &mut random),
        Plant::RepeatedConstant => constant(draft, &mut planted, true, &mut random),
        Plant::MissingBranch => missing(draft, &mut planted, &mut random),
        Plant::ImpossibleBranch => impossible(draft, &mut planted, &mut random),
        Plant::PropertyBound | Plant::MonitorBound => bound(draft, &mut planted, &mut random),
        Plant::PropertyClause | Plant::MonitorClause => clause(draft, &mut planted),
        Plant::ModelBinding | Plant::TraceBinding => binding(draft, &mut planted),
        Plant::WrongColumn | Plant::SwappedRows => columns(draft, &mut planted),
        Plant::SpeedUnit | Plant::TopicUnit => unit(draft, &mut planted),
        Plant::ScaledParameter => scaled(draft, &mut planted, &mut random),
        Plant::DriftedSensor => drifted(draft, &mut planted, &mut random),
        Plant::WrongClock => clock(draft, &mut planted, &mut random),
        Plant::OutlierPerson => outlier(draft, &mut planted, &mut random),
        Plant::SharedAssumption => shared(draft, &mut planted, &mut random),
    };
    done.map(|()| planted)
}

/// A value by this factor: odds are scaled, so that a probability stays one.
fn scaled_value(value: f64, factor: f64, is_rate: bool) -> f64 {
    let wrong = if is_rate {
        value * factor
    } else {
        value * factor / (1.0 - value + value * factor)
    };
    (wrong * 1e4).round().max(1.0) / 1e4
}

/// A factor from hardly visible to gross, to either side.
fn factor(random: &mut Random) -> f64 {
    let by = random.log_between(1.5, 8.0);
    if random.chance(0.6) { by } else { 1.0 / by }
}

/// A mode whose constant acts once in a run, or several times, and is not set to counts.
fn mode_of(draft: &Draft, repeats: bool, random: &mut Random) -> Option<usize> {
    let is_set = |name: &str| draft.rigs.iter().any(|rig| rig.mode == name);
    let modes = draft.truth.modes.iter().enumerate();
    let fit = modes.filter(|(_, mode)| mode.repeats == repeats && !is_set(&mode.name));
    let fit: Vec<usize> = fit.map(|(place, _)| place).collect();
    (!fit.is_empty()).then(|| fit[random.below(fit.len())])
}

fn is_rate(machine: &Machine, constant: usize) -> bool {
    let mut factors = machine
        .commands
        .iter()
        .flat_map(|it| &it.branches)
        .flat_map(|it| &it.weight);
    machine.time == Time::Rates && !factors.any(|it| *it == Factor::Not(constant))
}

fn constant(
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
fn of_model(draft: &Draft, planted: &mut Planted, place: usize) {
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
fn touched(draft: &Draft, machine: &Machine, place: usize) -> Vec<String> {
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

/// Trials of the experiment.
fn trials_of(draft: &Draft) -> f64 {
    (draft.cohort.rows * draft.cohort.attempts) as f64
}

/// Independent trials of the experiment with this many opportunities.
fn worth(draft: &Draft, trials: f64) -> f64 {
    let rows = draft.cohort.rows as f64;
    trials / (1.0 + (trials / rows - 1.0).max(0.0) * draft.cohort.correlation)
}

/// The power of the best test between a wrong machine and what is right: of a model whose numbers are computed where
/// `episodes` is none, else of a simulator's so many episodes.
fn of_machines(draft: &Draft, wrong: &Machine, episodes: Option<f64>) -> f64 {
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

fn missing(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

fn impossible(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

/// The share of runs of the truth for which something holds, of 4000.
fn share(draft: &Draft, holds: &dyn Fn(&Run, f64) -> bool) -> f64 {
    let mut random = draft.stream(Stream::Truth);
    let runs = draft.runs(&draft.truth, 4000, &mut random);
    runs.iter()
        .filter(|(run, speed)| holds(run, *speed))
        .count() as f64
        / 4000.0
}

fn judged_runs(draft: &Draft) -> usize {
    draft.sizes.episodes + draft.sizes.recordings
}

fn bound(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let factor = match random.below(4) {
        // Seconds taken for the model's units, or the other way round; as a limit in tenths.
        0 if (draft.truth.step_secs - 1.0).abs() > 0.1 => draft.truth.step_secs,
        1 => 10.0,
        _ => random.one_of(&[0.6, 0.75, 0.85, 1.3, 1.6, 2.5]),
    };
    let limit = draft.forms.limit_secs;
    let wrong = (limit * factor * 100.0).round() / 100.0;
    let is_property = planted.plant == Plant::PropertyBound;
    if is_property {
        draft.forms.property_limit = draft.in_model_time(wrong);
        planted.culprits = vec![culprit("property", ids::IN_TIME)];
    } else {
        draft.forms.monitor_secs = wrong;
        planted.culprits = vec![culprit("monitor", ids::IN_TIME)];
    }
    let done = draft.truth.done;
    let by = |limit: f64| {
        share(draft, &|run, _| {
            run.entered(done).is_some_and(|at| at <= limit + 1e-9)
        })
    };
    let (right, judged) = (by(limit), by(wrong));
    planted.power = if is_property {
        let trials = worth(draft, (draft.cohort.rows * draft.cohort.attempts) as f64);
        let others = [trials, draft.sizes.episodes as f64]
            .map(|n| power(Side::computed(judged), Side::independent(right, n), 0.05));
        others[0].max(others[1])
    } else {
        let episodes = Side::independent(judged, draft.sizes.episodes as f64);
        power(episodes, Side::computed(right), 0.05)
    };
    if draft.forms.has_sentences && (right - judged).abs() > 0.0 {
        // Forms are held against their sentence: the limits differ in the text itself.
        planted.power = 1.0;
    }
    planted.subjects = vec![ids::IN_TIME.into()];
    planted.mended_in = vec![names::REQUIREMENTS];
    planted.words = format!("a limit of {wrong} s instead of {limit} s");
    Some(())
}

fn clause(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    let success = draft.truth.reaches(draft.truth.done);
    if planted.plant == Plant::PropertyClause {
        draft.forms.property_goal = "ended".into();
        planted.culprits = vec![culprit("property", ids::DONE)];
    } else {
        draft.forms.monitor_goal = "ended".into();
        planted.culprits = vec![culprit("monitor", ids::DONE)];
    }
    planted.power = seen(1.0 - success, judged_runs(draft));
    planted.subjects = vec![ids::DONE.into()];
    planted.mended_in = vec![names::REQUIREMENTS];
    planted.words = "a form waits for the end of the run".into();
    Some(())
}

fn binding(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    let near = draft.truth.near?;
    // The state before: not all that come near have been completed, by the clock; or the wrong end.
    let worst = draft.truth.modes.iter().max_by(|one, other| {
        draft
            .truth
            .reaches(one.failed)
            .total_cmp(&draft.truth.reaches(other.failed))
    })?;
    let (failed, is_model) = (worst.failed, planted.plant == Plant::ModelBinding);
    let _ = near;
    let word = draft.truth.locations[draft.truth.done].clone();
    if is_model {
        draft.bindings.done_in_model = Some(failed);
    } else {
        draft.bindings.done_in_traces = Some(failed);
    }
    planted.culprits = vec![culprit("vocabulary", &word), culprit("vocabulary", "")];
    planted.power = 1.0;
    planted.subjects = [ids::DONE, ids::IN_TIME, ids::RESPONSE]
        .map(str::to_owned)
        .into();
    planted.mended_in = vec![names::VOCABULARY];
    planted.mended_by = if is_model {
        "model".into()
    } else {
        "trace".into()
    };
    planted.words = format!(
        "the word {word} means the end {} to {}",
        draft.truth.locations[failed],
        if is_model { "the model" } else { "traces" }
    );
    Some(())
}

fn columns(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
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

fn unit(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    planted.subjects = vec![ids::SLOW.into()];
    if planted.plant == Plant::SpeedUnit {
        draft.forms.speed_text = format!("{} m/s", (draft.forms.speed_limit * 1000.0).round());
        planted.culprits = vec![culprit("vocabulary", ""), culprit("monitor", ids::SLOW)];
        planted.mended_in = vec![names::VOCABULARY, names::REQUIREMENTS];
        planted.words = format!("slow means {}", draft.forms.speed_text);
    } else {
        // Gaps of 0.4 and 3 seem to be millimetres: somebody is near all the time.
        draft.bindings.gap_unit = Some(if draft.columns.gap > 1.0 { "m" } else { "mm" });
        planted.culprits = vec![
            culprit("vocabulary", ""),
            culprit("data", ""),
            culprit("monitor", ids::SLOW),
        ];
        planted.mended_in = vec![names::TOPICS];
        planted.words = "the map of topics has another unit of length".into();
    }
    // Both that could tell read the same words: no difference between pieces of evidence shows it.
    planted.power = 0.0;
    Some(())
}

fn scaled(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

fn drifted(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

fn clock(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

fn outlier(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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

fn shared(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
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
