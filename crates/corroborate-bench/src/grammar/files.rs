//! A generated study as a folder's files.

use super::draft::{Draft, Stream};
use super::machine::{Machine, Mode, Run, Time};
use super::simulator;
use std::fmt::Write as _;

/// A file: its path in the study, with `/` between folders, and its text.
pub type File = (String, String);

/// The names of a study's files that a fault can be in.
pub mod names {
    /// The formal model.
    pub const MODEL: &str = "model.prism";
    /// The simulator's parameters.
    pub const PARAMETERS: &str = "simulation/parameters.txt";
    /// The simulator.
    pub const PROGRAM: &str = "simulation/simulate.awk";
    /// Trials by person or session.
    pub const COHORT: &str = "experiments/trials.csv";
    /// Occurrences by failure mode.
    pub const MODES: &str = "experiments/failures.csv";
    /// Verdicts by requirement.
    pub const VERDICTS: &str = "experiments/verdicts.csv";
    /// Requirements.
    pub const REQUIREMENTS: &str = "requirements.toml";
    /// Words.
    pub const VOCABULARY: &str = "vocabulary.toml";
    /// Where recordings have signals.
    pub const TOPICS: &str = "topics.toml";
}

/// The requirements' identifiers.
pub mod ids {
    /// A run is done.
    pub const DONE: &str = "R1";
    /// A run is done in time.
    pub const IN_TIME: &str = "R2";
    /// The robot is slow near people.
    pub const SLOW: &str = "R3";
    /// What follows something that does not happen in every run.
    pub const RESPONSE: &str = "R4";
}

/// All files of a study.
#[must_use]
pub fn files(draft: &Draft) -> Vec<File> {
    let people = draft.people();
    let mut files: Vec<File> = vec![
        ("study.toml".into(), study(draft)),
        (names::REQUIREMENTS.into(), requirements(draft)),
        (names::VOCABULARY.into(), vocabulary(draft)),
        (names::TOPICS.into(), topics(draft)),
        ("ledger.toml".into(), ledger(draft)),
        (names::MODEL.into(), draft.style.text(&draft.formal)),
        (
            names::PARAMETERS.into(),
            simulator::parameters(&draft.simulated, draft.simulated_motion),
        ),
        (
            names::PROGRAM.into(),
            simulator::program(&draft.simulated, &draft.simulated_columns),
        ),
        (names::COHORT.into(), trials(draft, &people)),
        (names::MODES.into(), failures(draft, &people)),
        (names::VERDICTS.into(), verdicts(draft, &people)),
    ];
    for rig in &draft.rigs {
        let sample = rig.sample;
        let text = format!(
            "mode,occurrences,opportunities\n{},{},{}\n",
            rig.mode, sample.successes, sample.trials
        );
        files.push((format!("experiments/rig_{}.csv", rig.mode), text));
    }
    let mut random = draft.stream(Stream::Operation);
    for (number, (run, speed)) in draft
        .runs(&draft.truth, draft.sizes.recordings, &mut random)
        .iter()
        .enumerate()
    {
        let text = simulator::recording(&draft.truth, run, *speed, &draft.recorded_columns);
        files.push((format!("operation/run-{number:03}.csv"), text));
    }
    files
}

fn study(draft: &Draft) -> String {
    let mut text = format!(
        "title = \"A generated study of the family {}\"\nsummary = \"A system drawn from a grammar, its formal model, a \
         simulator of it, and trials.\"\nseed = {}\nconfidence = 0.95\nagreement = 0.95\n\n[conditions]\ntypical = \
         \"As drawn.\"\nalone = \"A part of the system alone.\"\n\n[model]\n",
        draft.family.name(),
        draft.seed.1 + 1,
    );
    let secs = draft.truth.step_secs;
    let _ = writeln!(text, "step = \"{secs} s\"");
    text
}

/// The threshold of a requirement: a margin below its rate, in whole hundredths.
fn threshold(rate: f64) -> f64 {
    ((rate - 0.12) * 100.0).floor().max(1.0) / 100.0
}

fn requirements(draft: &Draft) -> String {
    let forms = &draft.forms;
    let truth = &draft.truth;
    let done = &truth.locations[truth.done];
    let success = truth.reaches(truth.done);
    let optimum = if truth.time == Time::Choices {
        "Pmin"
    } else {
        "P"
    };
    let shown = |text: &str| match forms.has_sentences {
        true => format!("shall = \"{text}\"\n"),
        false => String::new(),
    };
    let at_least = threshold(success);
    let limit = forms.limit_secs;
    let bound = match truth.time {
        Time::Rates => format!("{:.4}", forms.property_limit),
        _ => format!("{}", forms.property_limit),
    };
    let named = |id: &str, sentence: String, least: f64, text: &str| {
        let threshold = if forms.has_sentences {
            String::new()
        } else {
            format!("threshold = \"at least {least}\"\n")
        };
        format!(
            "[[requirement]]\nid = \"{id}\"\ntext = \"{text}\"\nmargin = 0.05\n{}{threshold}",
            shown(&sentence)
        )
    };
    let mut text = named(
        ids::DONE,
        format!("The robot shall with probability at least {at_least} eventually satisfy {done}."),
        at_least,
        "Most runs shall be completed.",
    );
    let _ = write!(
        text,
        "property = '{optimum}=? [ F \"{}\" ]'\nmonitor.when = \"begun\"\nmonitor.then = [{{ wait_for = \"{}\" }}]\n\
         monitor.at_end = \"fail_pending\"\nexperiment = \"{done}\"\n\n",
        forms.property_goal, forms.monitor_goal,
    );
    let least = threshold(0.8 * success);
    text.push_str(&named(
        ids::IN_TIME,
        format!(
            "The robot shall with probability at least {least} within {limit} s satisfy {done}."
        ),
        least,
        "Most runs shall be completed in time.",
    ));
    let _ = write!(
        text,
        "property = '{optimum}=? [ F<={bound} \"{done}\" ]'\nmonitor.when = \"begun\"\nmonitor.then = [{{ wait_for = \
         \"{done}\", within_secs = {} }}]\nmonitor.at_end = \"fail_pending\"\n\n",
        forms.monitor_secs,
    );
    let _ = write!(
        text,
        "[[requirement]]\nid = \"{}\"\ntext = \"Near people the robot shall be slow.\"\nmargin = 0.05\n\
         threshold = \"at least 0.7\"\nmonitor.when = \"near\"\nmonitor.then = [{{ assert = \"slow\" }}]\n\
         monitor.trigger = \"each_sample\"\n\n",
        ids::SLOW
    );
    if let Some(alarm) = truth.alarm {
        let word = alarm_word(truth, alarm);
        let _ = write!(
            text,
            "[[requirement]]\nid = \"{}\"\ntext = \"After {word} most runs shall be completed.\"\nmargin = 0.05\n\
             threshold = \"at least 0.4\"\nproperty = '{optimum}=? [ G (\"{word}\" => (F \"{done}\")) ]'\n\
             monitor.when = \"{word}\"\nmonitor.then = [{{ wait_for = \"{done}\" }}]\nmonitor.at_end = \"fail_pending\"\n\n",
            ids::RESPONSE
        );
    }
    for mode in &truth.modes {
        text.push_str(&failure_mode(mode, optimum));
    }
    text
}

fn alarm_word(truth: &Machine, alarm: usize) -> String {
    format!("in_case_of_{}", truth.locations[alarm])
}

fn failure_mode(mode: &Mode, optimum: &str) -> String {
    let name = &mode.name;
    // Of a choice that is left open, how often it can come to that.
    let optimum = if optimum == "P" { "P" } else { "Pmax" };
    format!(
        "[[failure_mode]]\nid = \"{name}\"\nname = \"{name}\"\nmeaning = \"The run ends by {name}; counted per run that \
         comes to where it can.\"\nmargin = 0.05\noccurs = '{optimum}=? [ F \"lost_{name}\" ]'\nopportunity = \
         '{optimum}=? [ F \"before_{name}\" ]'\nmonitor.when = \"before_{name}\"\nmonitor.then = [{{ wait_for = \
         \"ended\" }}, {{ assert = \"spared_{name}\" }}]\nexperiment = \"lost_{name}\"\n\n"
    )
}

fn code(draft: &Draft, place: usize) -> String {
    let name = draft.truth.modes[place].name.as_bytes();
    format!("{}{place}", char::from(name[0]).to_ascii_uppercase())
}

fn word(
    name: &str,
    meaning: &str,
    model: Option<String>,
    trace: Option<String>,
    column: Option<String>,
) -> String {
    let mut text = format!("[{name}]\nmeaning = \"{meaning}\"\n");
    for (key, value) in [("model", model), ("trace", trace), ("column", column)] {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = \"{value}\"");
        }
    }
    text.push('\n');
    text
}

fn vocabulary(draft: &Draft) -> String {
    let truth = &draft.truth;
    let in_model = |place: usize| Some(draft.style.is_at(&draft.formal, place));
    let in_traces = |place: usize| Some(format!("/unit.phase == '{}'", truth.locations[place]));
    let ends: Vec<usize> = (0..truth.locations.len())
        .filter(|place| truth.is_end(*place))
        .collect();
    let any = |each: &dyn Fn(usize) -> Option<String>| {
        let all: Vec<String> = ends.iter().filter_map(|place| each(*place)).collect();
        Some(all.join(" | "))
    };
    let mut text = word(
        "begun",
        "The run has begun.",
        in_model(0),
        in_traces(0),
        None,
    );
    text.push_str(&word(
        &truth.locations[truth.done],
        "The run is completed.",
        in_model(draft.bindings.done_in_model.unwrap_or(truth.done)),
        in_traces(draft.bindings.done_in_traces.unwrap_or(truth.done)),
        Some(draft.cohort.success.into()),
    ));
    text.push_str(&word(
        "ended",
        "The run is over.",
        any(&in_model),
        any(&in_traces),
        None,
    ));
    text.push_str(&word(
        "near",
        "A person is near.",
        None,
        Some("/unit.gap < 1 m".into()),
        None,
    ));
    let slow = format!("/unit.speed < {}", draft.forms.speed_text);
    text.push_str(&word("slow", "The robot is slow.", None, Some(slow), None));
    if let Some(alarm) = truth.alarm {
        let word_of = alarm_word(truth, alarm);
        text.push_str(&word(
            &word_of,
            "It came to that.",
            in_model(alarm),
            in_traces(alarm),
            None,
        ));
    }
    for (place, mode) in truth.modes.iter().enumerate() {
        let counted = match draft.bindings.exchanged {
            Some((one, other)) if place == one => other,
            Some((one, other)) if place == other => one,
            _ => place,
        };
        let column = match draft.cohort.codes {
            Some(header) => format!("{header}: {}", code(draft, counted)),
            None => format!("n_{}", truth.modes[counted].name),
        };
        let name = &mode.name;
        let (lost, before) = (format!("lost_{name}"), format!("before_{name}"));
        let lost_in_traces = in_traces(mode.failed);
        text.push_str(&word(
            &lost,
            &format!("The run has ended by {name}."),
            in_model(mode.failed),
            lost_in_traces,
            Some(column),
        ));
        text.push_str(&word(
            &before,
            &format!("The run can end by {name}."),
            in_model(mode.at),
            in_traces(mode.at),
            None,
        ));
        let spared = Some(format!("!lost_{name}"));
        text.push_str(&word(
            &format!("spared_{name}"),
            &format!("Not {name}."),
            None,
            spared,
            None,
        ));
    }
    text
}

fn topics(draft: &Draft) -> String {
    let [_, phase, gap, speed] = draft.columns.headers;
    let unit = |factor: f64| match factor {
        1000.0 => "mm",
        100.0 => "cm",
        _ => "m",
    };
    let names: Vec<String> = draft
        .truth
        .locations
        .iter()
        .map(|name| format!("\"{name}\""))
        .collect();
    let gap_unit = draft.bindings.gap_unit.unwrap_or(unit(draft.columns.gap));
    format!(
        "[\"/unit.phase\"]\nfrom = \"/csv.{phase}\"\nvalues = [{}]\n\n[\"/unit.gap\"]\nfrom = \"/csv.{gap}\"\nunit = \
         \"{gap_unit}\"\n\n[\"/unit.speed\"]\nfrom = \"/csv.{speed}\"\nunit = \"{}/s\"\n",
        names.join(", "),
        unit(draft.columns.speed),
    )
}

fn ledger(draft: &Draft) -> String {
    let mut text = String::new();
    for rig in &draft.rigs {
        let _ = write!(
            text,
            "[[evidence]]\nid = \"rig_{0}\"\ntitle = \"Tests of {0} alone\"\ntechnique = \"experiment\"\nconditions = \
             \"alone\"\ntables.failure_modes = \"experiments/rig_{0}.csv\"\nchanged = \"One part, tested alone.\"\n\n",
            rig.mode
        );
    }
    let _ = write!(
        text,
        "[[evidence]]\nid = \"model\"\ntitle = \"Formal model\"\ntechnique = \"model-checking\"\nconditions = \
         \"typical\"\nmodel = \"{}\"\nchanged = \"The formal model.\"\n",
        names::MODEL
    );
    if !draft.rigs.is_empty() {
        text.push_str("calibrated = [\n");
        for rig in &draft.rigs {
            let place = draft.truth.mode(&rig.mode).map_or(0, |mode| mode.constant);
            let complement = if draft.style.complement[place] {
                "complement = true, "
            } else {
                ""
            };
            let constant = draft.style.constant(&draft.formal, place);
            let _ = writeln!(
                text,
                "    {{ constant = \"{constant}\", {complement}from = \"rig_{0}\", failure_mode = \"{0}\" }},",
                rig.mode
            );
        }
        text.push_str("]\n");
    }
    let _ = write!(
        text,
        "\n[[evidence]]\nid = \"simulation\"\ntitle = \"Simulation\"\ntechnique = \"simulation\"\nconditions = \
         \"typical\"\ncommand = [\"awk\", \"-v\", \"seed={{seed}}\", \"-v\", \"out={{recording}}\", \"-f\", \"{}\", \"{}\"]\n\
         leaves = \"csv\"\nepisodes = {}\nchanged = \"The simulator.\"\n\n\
         [[evidence]]\nid = \"trials\"\ntitle = \"Experiments\"\ntechnique = \"experiment\"\nconditions = \"typical\"\n\
         tables.cohort = \"{}\"\ntables.failure_modes = \"{}\"\ntables.requirements = \"{}\"\nchanged = \"Trials.\"\n",
        names::PROGRAM,
        names::PARAMETERS,
        draft.sizes.episodes,
        names::COHORT,
        names::MODES,
        names::VERDICTS,
    );
    if draft.sizes.recordings > 0 {
        text.push_str(
            "\n[[evidence]]\nid = \"operation\"\ntitle = \"At work\"\ntechnique = \"operation\"\nconditions = \"typical\"\n\
             recordings = \"operation\"\nrepeated_recordings = \"the machine has few ways to go\"\nchanged = \"Recordings.\"\n",
        );
    }
    text
}

fn trials(draft: &Draft, people: &[Vec<Run>]) -> String {
    let truth = &draft.truth;
    let cohort = &draft.cohort;
    let mut text = format!("{},{},attempts", cohort.header, cohort.success);
    match cohort.codes {
        Some(header) => {
            let _ = write!(text, ",{header}");
        }
        None => truth.modes.iter().for_each(|mode| {
            let _ = write!(text, ",n_{}", mode.name);
        }),
    }
    for (row, runs) in people.iter().enumerate() {
        let done = runs.iter().filter(|run| run.was_at(truth.done)).count();
        let _ = write!(text, "\n{},{done},{}", row + 1, runs.len());
        let count = |place: usize| {
            let mode = &truth.modes[swapped(draft, place)];
            runs.iter().filter(|run| run.was_at(mode.failed)).count()
        };
        if cohort.codes.is_some() {
            let codes = 0..truth.modes.len();
            let codes: Vec<String> = codes
                .flat_map(|place| vec![code(draft, place); count(place)])
                .collect();
            let _ = write!(text, ",{}", codes.join(" "));
        } else {
            for place in 0..truth.modes.len() {
                let _ = write!(text, ",{}", count(place));
            }
        }
    }
    text.push('\n');
    text
}

/// The mode whose failures were written down as those of the mode at `place`.
fn swapped(draft: &Draft, place: usize) -> usize {
    match draft.bindings.swapped_rows {
        Some((one, other)) if place == one => other,
        Some((one, other)) if place == other => one,
        _ => place,
    }
}

fn failures(draft: &Draft, people: &[Vec<Run>]) -> String {
    let runs: Vec<&Run> = people.iter().flatten().collect();
    let mut text = String::from("mode,occurrences,opportunities\n");
    let modes = &draft.truth.modes;
    for (place, mode) in modes.iter().enumerate() {
        // What the vocabulary counts in the cohort has to be what this table says: a study whose tables contradict each
        // other is refused.
        let counted = swapped(draft, place);
        let counted = match draft.bindings.exchanged {
            Some((one, other)) if counted == one => other,
            Some((one, other)) if counted == other => one,
            _ => counted,
        };
        let from = &modes[counted];
        let count = runs.iter().filter(|run| run.was_at(from.failed)).count();
        let of = runs
            .iter()
            .filter(|run| run.was_at(mode.at))
            .count()
            .max(count);
        let _ = writeln!(text, "{},{count},{of}", mode.name);
    }
    text
}

fn verdicts(draft: &Draft, people: &[Vec<Run>]) -> String {
    let runs: Vec<&Run> = people.iter().flatten().collect();
    let limit = draft.forms.limit_secs;
    let in_time = |run: &&&Run| {
        run.entered(draft.truth.done)
            .is_some_and(|at| at <= limit + 1e-9)
    };
    let passed = runs.iter().filter(in_time).count();
    format!(
        "requirement,covered,passed,failed\n{},{},{passed},{}\n",
        ids::IN_TIME,
        runs.len(),
        runs.len() - passed
    )
}
