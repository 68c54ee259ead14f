//! A generated study before it is written: the truth, each asset's idea of it, and how everything is called.

use super::family::Kind;
use super::machine::{Machine, Run, Time};
use super::prism::Style;
use super::simulator::{Columns, Motion};
use crate::random::Random;
use stats::Sample;
use stats::special::normal_quantile;

/// Who did the trials of the experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Cohort {
    /// What a row is: a person, a session, a day.
    pub header: &'static str,
    /// Rows.
    pub rows: usize,
    /// Trials of each.
    pub attempts: usize,
    /// How alike they are.
    pub correlation: f64,
    /// The header of what succeeded.
    pub success: &'static str,
    /// The header of the codes of failures; a column for each mode if there is none.
    pub codes: Option<&'static str>,
}

/// The sizes of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Simulated episodes.
    pub episodes: usize,
    /// Recordings of the system at work; 0 for none.
    pub recordings: usize,
}

/// A number that was set to tests of one part alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The mode.
    pub mode: String,
    /// The tests.
    pub sample: Sample,
}

/// What a requirement's forms say, where a fault can change them.
#[derive(Clone, Debug, PartialEq)]
pub struct Forms {
    /// Whether requirements have sentences.
    pub has_sentences: bool,
    /// The declared limit of time in seconds.
    pub limit_secs: f64,
    /// The limit that the property has, in the model's units.
    pub property_limit: f64,
    /// The limit that the monitor has, in seconds.
    pub monitor_secs: f64,
    /// The word for which the first requirement's property waits.
    pub property_goal: String,
    /// The word for which its monitor waits.
    pub monitor_goal: String,
    /// The declared limit of speed in m/s.
    pub speed_limit: f64,
    /// The limit of speed that the monitor has, with its unit.
    pub speed_text: String,
}

/// Where a word's bindings are other than its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bindings {
    /// The word `done` means this location to the model.
    pub done_in_model: Option<usize>,
    /// The word `done` means this location to traces.
    pub done_in_traces: Option<usize>,
    /// Modes whose columns or codes are exchanged in the vocabulary.
    pub exchanged: Option<(usize, usize)>,
    /// Modes whose rows are exchanged in the table.
    pub swapped_rows: Option<(usize, usize)>,
    /// The unit that the map of topics declares for the gap, if it is not that of the column.
    pub gap_unit: Option<&'static str>,
}

/// A generated study before it is written.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The family.
    pub family: Kind,
    /// What is true.
    pub truth: Machine,
    /// What the formal model has.
    pub formal: Machine,
    /// What the simulator has.
    pub simulated: Machine,
    /// How the model is written.
    pub style: Style,
    /// How fast the robot is near people.
    pub motion: Motion,
    /// How fast the simulator's is.
    pub simulated_motion: Motion,
    /// The columns of recordings.
    pub columns: Columns,
    /// What the simulator writes instead, where its clock is wrong.
    pub simulated_columns: Columns,
    /// What the system's recorder writes instead, where a sensor drifted.
    pub recorded_columns: Columns,
    /// The requirements' forms.
    pub forms: Forms,
    /// The words' bindings.
    pub bindings: Bindings,
    /// Who did the trials.
    pub cohort: Cohort,
    /// A row of the cohort that fails so much more often, with by how much.
    pub outlier: Option<(usize, f64)>,
    /// How much there is of each.
    pub sizes: Sizes,
    /// Tests of parts alone, to which constants are set.
    pub rigs: Vec<Rig>,
    /// The seed and the number of the study.
    pub seed: (u64, u64),
}

/// Streams of random numbers, so that one asset's data stay as they are when another changes.
#[derive(Clone, Copy, Debug)]
pub enum Stream {
    /// The experiment.
    People = 11,
    /// The recordings.
    Operation,
    /// Figures of the truth that are counted instead of solved.
    Truth,
}

impl Draft {
    /// Draws a study of a family without any fault.
    pub fn draw(family: Kind, seed: u64, number: u64) -> Self {
        let mut random = Random::new(seed ^ 0x67_7261_6d6d, number);
        let truth = family.draw(&mut random);
        let style = Style::draw(&truth, &mut random);
        let speed_limit = random.one_of(&[0.2, 0.25, 0.3, 0.5]);
        let spread = 0.2;
        let slow = random.between(0.85, 0.98);
        let motion = Motion {
            median: speed_limit * (-spread * normal_quantile(slow)).exp(),
            spread,
        };
        let columns = columns(&mut random);
        let forms = forms(&truth, speed_limit, seed, number, &mut random);
        let cohort = cohort(&mut random);
        let mut draft = Self {
            family,
            formal: truth.clone(),
            simulated: truth.clone(),
            style,
            motion,
            simulated_motion: motion,
            simulated_columns: columns.clone(),
            recorded_columns: columns.clone(),
            columns,
            forms,
            bindings: Bindings::default(),
            cohort,
            outlier: None,
            sizes: Sizes {
                episodes: random.one_of(&[60, 100, 150]),
                recordings: if random.chance(0.4) {
                    random.one_of(&[20, 30, 40])
                } else {
                    0
                },
            },
            rigs: Vec::new(),
            seed: (seed, number),
            truth,
        };
        if random.chance(0.35) {
            draft.count_a_constant(&mut random);
        }
        draft
    }

    /// Sets a constant of the model to tests of its part alone.
    fn count_a_constant(&mut self, random: &mut Random) {
        let modes: Vec<_> = self
            .truth
            .modes
            .iter()
            .filter(|mode| !mode.repeats)
            .cloned()
            .collect();
        if modes.is_empty() {
            return;
        }
        let mode = &modes[random.below(modes.len())];
        let trials = random.one_of(&[100, 200, 400]);
        let rate = self.truth.constants[mode.constant].value;
        let successes = (0..trials).filter(|_| random.chance(rate)).count() as u64;
        if successes == 0 {
            return;
        }
        self.set_to_rig(Rig {
            mode: mode.name.clone(),
            sample: Sample { successes, trials },
        });
    }

    /// Sets the constant of a mode to counts, and says so.
    pub fn set_to_rig(&mut self, rig: Rig) {
        let Some(mode) = self.truth.mode(&rig.mode) else {
            return;
        };
        let (place, sample) = (mode.constant, rig.sample);
        let counted = match self.style.complement[place] {
            true => sample.trials - sample.successes,
            false => sample.successes,
        };
        self.formal.constants[place].value = sample.successes as f64 / sample.trials as f64;
        self.style.given[place] = Some(format!("{counted}/{}", sample.trials));
        self.style.inline[place] = false;
        self.rigs.push(rig);
    }

    /// A stream of random numbers of this study.
    #[must_use]
    pub fn stream(&self, stream: Stream) -> Random {
        Random::new(self.seed.0 ^ ((stream as u64) << 40), self.seed.1)
    }

    /// Runs of the truth with their speeds near people.
    #[must_use]
    pub fn runs(&self, machine: &Machine, count: usize, random: &mut Random) -> Vec<(Run, f64)> {
        let one = |random: &mut Random| {
            let run = machine.run(random);
            let speed = self.motion.median * (self.motion.spread * random.normal()).exp();
            (run, speed)
        };
        (0..count).map(|_| one(random)).collect()
    }

    /// Each row's runs in the experiment.
    #[must_use]
    pub fn people(&self) -> Vec<Vec<Run>> {
        let mut random = self.stream(Stream::People);
        let mut all = Vec::new();
        for row in 0..self.cohort.rows {
            let mut own = self.truth.of_cluster(self.cohort.correlation, &mut random);
            if let Some((_, factor)) = self.outlier.filter(|(who, _)| *who == row) {
                own = self.with_odds_of_failing(factor);
            }
            all.push(
                (0..self.cohort.attempts)
                    .map(|_| own.run(&mut random))
                    .collect(),
            );
        }
        all
    }

    /// The truth for somebody with whom everything fails as if tried so many times.
    #[must_use]
    pub fn with_odds_of_failing(&self, factor: f64) -> Machine {
        let mut own = self.truth.clone();
        for mode in &self.truth.modes {
            let value = &mut own.constants[mode.constant].value;
            *value = 1.0 - (1.0 - value.min(1.0)).powf(factor);
        }
        own
    }

    /// What a model calls this many seconds.
    #[must_use]
    pub fn in_model_time(&self, secs: f64) -> f64 {
        let units = secs / self.truth.step_secs;
        match self.truth.time {
            Time::Rates => units,
            // A run that ends at the limit is in time.
            _ => (units + 1e-9).floor(),
        }
    }
}

fn columns(random: &mut Random) -> Columns {
    let (gap_header, gap) =
        random.one_of(&[("gap", 1.0), ("distance_mm", 1000.0), ("range_cm", 100.0)]);
    let (speed_header, speed) = random.one_of(&[("speed", 1.0), ("speed_mm_per_s", 1000.0)]);
    let (time_header, time) = random.one_of(&[("time [s]", 1.0), ("stamp [ms]", 1000.0)]);
    Columns {
        headers: [
            time_header,
            random.one_of(&["phase", "state", "activity"]),
            gap_header,
            speed_header,
        ],
        time,
        gap,
        speed,
    }
}

fn cohort(random: &mut Random) -> Cohort {
    let rows = random.one_of(&[6, 10, 15, 24]);
    Cohort {
        header: random.one_of(&["person", "session", "day", "participant"]),
        rows,
        attempts: random.one_of(&[8, 10, 12]),
        correlation: random.one_of(&[0.0, 0.03, 0.08]),
        success: random.one_of(&["successes", "completed", "ok", "good_runs"]),
        codes: random.one_of(&[Some("failure_codes"), Some("remarks"), None]),
    }
}

/// The runs from which a limit of time is taken.
const RUNS_FOR_LIMIT: usize = 400;

fn forms(truth: &Machine, speed_limit: f64, seed: u64, number: u64, random: &mut Random) -> Forms {
    let mut stream = Random::new(seed ^ ((Stream::Truth as u64) << 40), number);
    let runs = (0..RUNS_FOR_LIMIT).map(|_| truth.run(&mut stream));
    let mut times: Vec<f64> = runs.filter_map(|run| run.entered(truth.done)).collect();
    times.sort_by(f64::total_cmp);
    let share = random.between(0.8, 0.97);
    let at = times
        .get((share * times.len() as f64) as usize)
        .copied()
        .unwrap_or(10.0);
    let limit_secs = match truth.time {
        Time::Rates => (at * 10.0).ceil() / 10.0,
        _ => (at / truth.step_secs).round() * truth.step_secs,
    };
    let limit_secs = (limit_secs * 1e3).round() / 1e3;
    let units = limit_secs / truth.step_secs;
    let property_limit = if truth.time == Time::Rates {
        units
    } else {
        (units + 1e-9).floor()
    };
    Forms {
        has_sentences: random.chance(0.7),
        limit_secs,
        property_limit,
        monitor_secs: limit_secs,
        property_goal: truth.locations[truth.done].clone(),
        monitor_goal: truth.locations[truth.done].clone(),
        speed_limit,
        speed_text: speed(speed_limit, random),
    }
}

fn speed(limit: f64, random: &mut Random) -> String {
    if random.chance(0.5) {
        format!("{} mm/s", (limit * 1000.0).round())
    } else {
        format!("{limit} m/s")
    }
}
