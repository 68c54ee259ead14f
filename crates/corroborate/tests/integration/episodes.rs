//! Episodes of learned policies as evidence.

use crate::support::Copy;
use corroborate::evidence::{Evidence, Subject};
use corroborate::{Host, Problem, RunReport, RunRequest};
use std::fmt::Write;

/// The docking study, whose trials are episodes of a file.
pub(crate) fn study(episodes: &str, cluster: &str) -> Copy {
    let study = Copy::of_template("Model");
    study.edit(
        "ledger.toml",
        "tables.cohort = \"attempts.csv\"\ntables.failure_modes = \"failure_modes.csv\"\ntables.requirements = \"requirements.csv\"",
        &format!("tables.episodes = \"{episodes}\"\ntables.cluster = \"{cluster}\""),
    );
    study.edit(
        "vocabulary.toml",
        "column = \"successes\"",
        "column = \"success\"",
    );
    study.edit(
        "vocabulary.toml",
        "column = \"failure_modes: M\"",
        "column = \"failure\"",
    );
    study
}

pub(crate) fn write(study: &Copy, name: &str, text: &str) {
    let path = study.path(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(path, text).expect("written");
}

pub(crate) fn run(study: &Copy) -> Result<Evidence, Problem> {
    let mut request = RunRequest::new(study.path(""));
    request.only = vec!["E2".into()];
    let host = Host::silent(corroborate::build());
    match corroborate::run(&request, &host)? {
        RunReport::Only(mut all) => Ok(all.remove(0).evidence),
        RunReport::Study(_) => panic!("only one was asked for"),
    }
}

/// Count, trials and effective sample size of requirement 1.
pub(crate) fn counted(evidence: &Evidence) -> (u64, u64, f64) {
    let requirement = Subject::Requirement("1".into());
    let finding = evidence
        .findings
        .iter()
        .find(|it| it.subject == requirement);
    let measure = serde_json::to_value(&finding.expect("found").measure).expect("JSON");
    let number = |key: &str| measure[key].as_f64();
    let count = number("count")
        .or(number("successes"))
        .unwrap_or_else(|| panic!("{measure}"));
    let trials = number("trials").unwrap_or_else(|| panic!("{measure}"));
    let effective = number("effective_trials")
        .or(number("effective"))
        .unwrap_or(trials);
    (count as u64, trials as u64, effective)
}

/// An evaluation in LeRobot's newer layout: of each task, which episodes succeeded.
fn by_task(tasks: &[&[bool]]) -> String {
    let mut parts = String::new();
    let (mut won, mut all) = (0, 0);
    for (at, successes) in tasks.iter().enumerate() {
        let comma = if at == 0 { "" } else { ", " };
        let _ = write!(
            parts,
            "{comma}{{\"task_group\": \"libero\", \"task_id\": {at}, \"metrics\": {{\"sum_rewards\": [], \"successes\": {successes:?}, \
             \"video_paths\": []}}}}"
        );
        won += successes.iter().filter(|it| **it).count();
        all += successes.len();
    }
    let percent = 100.0 * won as f64 / all as f64;
    format!(
        "{{\"per_task\": [{parts}], \"per_group\": {{}}, \"overall\": {{\"avg_sum_reward\": NaN, \"pc_success\": {percent}, \
         \"n_episodes\": {all}}}}}"
    )
}

/// One in the older layout: seeds from 1000 on.
fn by_episode(successes: &[bool]) -> String {
    let episodes = successes.iter().enumerate().map(|(at, won)| {
        format!(
            "{{\"episode_ix\": {at}, \"sum_reward\": 1.5, \"max_reward\": 1.0, \"success\": {won}, \"seed\": {}}}",
            1000 + at
        )
    });
    let percent =
        100.0 * successes.iter().filter(|it| **it).count() as f64 / successes.len() as f64;
    let episodes: Vec<String> = episodes.collect();
    format!(
        "{{\"per_episode\": [{}], \"aggregated\": {{\"pc_success\": {percent}, \"eval_s\": 3.5}}}}",
        episodes.join(", ")
    )
}

#[test]
fn episodes_of_tasks_that_go_well_or_badly_as_a_whole_count_for_less() {
    let (good, bad) = ([true; 20], [false; 20]);
    let alike = study("eval_info.json", "task");
    write(
        &alike,
        "eval_info.json",
        &by_task(&[&good, &good, &good, &bad]),
    );
    let evidence = run(&alike).expect("read");
    let (count, trials, effective) = counted(&evidence);
    assert_eq!((count, trials), (60, 80));
    assert!(effective < 10.0, "{effective}");
    let settings = &evidence.tool.settings;
    assert!(
        settings.contains("80 episodes of one checkpoint") && settings.contains("(4 clusters)"),
        "{settings}"
    );
    // The same episodes, each by itself.
    let apart = study("eval_info.json", "episode");
    write(
        &apart,
        "eval_info.json",
        &by_task(&[&good, &good, &good, &bad]),
    );
    let (count, trials, effective) = counted(&run(&apart).expect("read"));
    assert_eq!((count, trials), (60, 80));
    assert!(effective > 70.0, "{effective}");
}

#[test]
fn each_evaluation_of_a_folder_is_a_checkpoint() {
    let study = study("eval", "checkpoint");
    write(
        &study,
        "eval/run1/eval_info.json",
        &by_episode(&[true, true, false, true]),
    );
    write(
        &study,
        "eval/run2/eval_info.json",
        &by_episode(&[true, false, false, true]),
    );
    let evidence = run(&study).expect("read");
    assert_eq!(counted(&evidence).1, 8);
    assert!(
        evidence.tool.settings.contains("of 2 checkpoints"),
        "{}",
        evidence.tool.settings
    );
    // The same seeds make clusters across checkpoints.
    study.edit(
        "ledger.toml",
        "cluster = \"checkpoint\"",
        "cluster = \"seed\"",
    );
    assert!(
        run(&study)
            .expect("read")
            .tool
            .settings
            .contains("(4 clusters)")
    );
}

#[test]
fn tables_by_hand_and_datasets_are_read() {
    let study = study("episodes.csv", "operator");
    write(
        &study,
        "episodes.csv",
        "task,seed,operator,success,collision,note\npick,1,Ada,True,0,\npick,2,Ada,False,1,slipped\nplace,1,Bob,yes,0,\n",
    );
    let evidence = run(&study).expect("read");
    assert_eq!((counted(&evidence).0, counted(&evidence).1), (2, 3));
    assert!(
        evidence.tool.settings.contains("does not name"),
        "{}",
        evidence.tool.settings
    );
    study.edit(
        "vocabulary.toml",
        "column = \"success\"",
        "column = \"collision\"",
    );
    assert_eq!(counted(&run(&study).expect("read")).0, 1);

    let dataset = self::study("set", "task");
    write(
        &dataset,
        "set/meta/info.json",
        "{\"codebase_version\": \"v2.1\", \"fps\": 30}",
    );
    write(
        &dataset,
        "set/meta/episodes.jsonl",
        "{\"episode_index\": 0, \"tasks\": [\"pick\"], \"length\": 9, \"success\": true}\n\
         {\"episode_index\": 1, \"tasks\": [\"place\"], \"length\": 9, \"success\": false}\n",
    );
    assert_eq!(counted(&run(&dataset).expect("read")).1, 2);
}

#[test]
fn what_cannot_be_counted_is_refused_with_its_place() {
    let fails = |file: &str, cluster: &str, text: &str, said: &str| {
        let study = study(file, cluster);
        write(&study, file, text);
        let problem = run(&study).expect_err(said);
        let shown = problem.to_string();
        assert!(shown.contains(said), "no `{said}`: {shown}");
        problem
    };
    let good = by_episode(&[true, false]);
    fails("eval_info.json", "task", &good, "do not say their task");
    fails(
        "eval_info.json",
        "episode",
        &good.replace("\"pc_success\": 50", "\"pc_success\": 75"),
        "`pc_success` is 75",
    );
    fails(
        "eval_info.json",
        "episode",
        &good.replace("1001", "1000"),
        "the seed 1000 stands twice",
    );
    fails(
        "eval_info.json",
        "episode",
        &good.replace("\"success\": false", "\"success\": NaN"),
        "episode 1 does not say",
    );
    fails(
        "eval_info.json",
        "episode",
        &good[..40],
        "the JSON cannot be read",
    );
    fails(
        "eval_info.json",
        "episode",
        "{\"a\": 1}",
        "neither `per_episode` nor `per_task`",
    );
    let tasks = by_task(&[&[true], &[false]]);
    fails(
        "eval_info.json",
        "episode",
        &tasks.replace("\"n_episodes\": 2", "\"n_episodes\": 3"),
        "`n_episodes` is 3",
    );
    fails("eval_info.json", "seed", &tasks, "do not say their seed");
    fails(
        "e.csv",
        "operator",
        "task,success\na,true\n",
        "do not say their operator",
    );
    fails(
        "e.csv",
        "task",
        "task,success\na,maybe\n",
        "neither true nor false",
    );
    fails("e.csv", "task", "task,won\na,true\n", "no column `success`");
    let again = fails(
        "eval_info.json",
        "episode",
        &good
            .replace("\"episode_ix\": 1", "\"episode_ix\": 0")
            .replace("\"pc", "\n\"pc"),
        "the episode 0 stands twice",
    );
    assert!(again.place().is_some());
    let again = fails(
        "eval_info.json",
        "episode",
        &tasks.replace("\"task_id\": 1", "\"task_id\": 0"),
        "the task libero/0 stands twice",
    );
    assert!(again.place().is_some());
    fails(
        "eval_info.json",
        "episode",
        &format!("{{\"one\": {good}, \"two\": {good}}}"),
        "`two` is the same as `one`",
    );
    fails(
        "e.csv",
        "task",
        "task,episode,success\na,0,true\nb,0,true\na,0,true\n",
        "the episode `0` stands twice",
    );
    let twice = study("eval", "checkpoint");
    for run in ["run1", "run2"] {
        write(&twice, &format!("eval/{run}/eval_info.json"), &good);
    }
    let shown = run(&twice).expect_err("a copy").to_string();
    assert!(
        shown.contains("run2") && shown.contains("the same bytes as"),
        "{shown}"
    );
    let lines = study("set", "task");
    write(
        &lines,
        "set/meta/info.json",
        "{\"codebase_version\": \"v2.1\"}",
    );
    let line = "{\"episode_index\": 0, \"tasks\": [\"a\"], \"success\": true}\n";
    write(&lines, "set/meta/episodes.jsonl", &line.repeat(2));
    let shown = run(&lines).expect_err("twice").to_string();
    assert!(shown.contains("line 2: the episode 0"), "{shown}");
    let empty = study("eval", "task");
    std::fs::create_dir(empty.path("eval")).expect("made");
    assert!(
        run(&empty)
            .expect_err("empty")
            .to_string()
            .contains("neither eval_info.json")
    );
}

#[test]
fn what_makes_episodes_alike_has_to_be_declared() {
    let undeclared = study("e.csv", "task");
    write(&undeclared, "e.csv", "task,success\na,true\n");
    undeclared.edit("ledger.toml", "\ntables.cluster = \"task\"", "");
    let problem = run(&undeclared).expect_err("not declared");
    assert!(
        problem
            .to_string()
            .contains("does not say what makes episodes alike"),
        "{problem}"
    );
    let both = study("e.csv", "task");
    write(&both, "e.csv", "task,success\na,true\n");
    both.edit(
        "ledger.toml",
        "tables.cluster",
        "tables.cohort = \"attempts.csv\"\ntables.cluster",
    );
    assert!(
        run(&both)
            .expect_err("both")
            .to_string()
            .contains("both a cohort")
    );
}

/// Changed, cut and doubled, files of evaluations are other episodes or one error with a remedy, and never a panic.
#[test]
fn no_change_of_a_file_makes_it_panic() {
    let (mut errors, mut read) = (0, 0);
    let files = [
        (
            "eval_info.json",
            "episode",
            by_episode(&[true, false, true]),
        ),
        (
            "eval_info.json",
            "task",
            by_task(&[&[true, false], &[true]]),
        ),
        (
            "e.csv",
            "task",
            "task,seed,success\na,1,true\nb,2,no\n".to_owned(),
        ),
    ];
    for (name, cluster, whole) in files {
        let study = study(name, cluster);
        for at in (0..whole.len()).step_by(3) {
            let (before, behind) = whole.split_at(at);
            for text in [
                before.to_owned(),
                format!("{before}{behind}{behind}"),
                format!("{before}\"{behind}"),
                format!("{before}9{}", &behind[1..]),
                format!("{before}\u{1b}{}", &behind[1..]),
            ] {
                write(&study, name, &text);
                match run(&study) {
                    Ok(_) => read += 1,
                    Err(problem) => {
                        assert!(problem.what_to_do().is_some(), "{problem}: {text}");
                        errors += 1;
                    }
                }
            }
        }
    }
    assert!(errors > 100 && read > 20, "{errors} errors, {read} read");
}
