//! What continuous integration reads and writes: JUnit XML of many runs as evidence, verdicts as JUnit XML, Markdown and SARIF, and what
//! changed between two results.

use crate::support;

use serde_json::Value;
use support::program::{Said, Study};
use support::schema::violations;
use support::{read, root};

/// A file of a run: the requirement that its case verifies, a seed if it has one, and what the case ends with.
fn run_of(verifies: &str, seed: Option<u64>, end: &str) -> String {
    let seed = seed.map_or(String::new(), |seed| {
        format!("<property name=\"seed\" value=\"{seed}\"/>")
    });
    format!(
        "<?xml version=\"1.0\"?>\n<testsuites><testsuite name=\"pytest\" tests=\"1\">\n\
         <testcase classname=\"tests.test_dock\" name=\"test_slow\" time=\"0.1\">\n\
         <properties><property name=\"verifies\" value=\"{verifies}\"/>{seed}</properties>{end}</testcase>\n\
         </testsuite></testsuites>\n"
    )
}

const FAILURE: &str = "<failure message=\"too fast\">0.4 m/s</failure>";
const ERROR: &str = "<error message=\"no simulator\"/>";

/// The docking study with runs of tests as a third piece of evidence.
fn with_runs(files: &[(&str, String)], tables: &str) -> Study {
    let study = Study::new();
    for (name, text) in files {
        study.write(&format!("runs/{name}"), text);
    }
    let ledger = read(&study.path("ledger.toml"));
    let entry = format!(
        "\n[[evidence]]\nid = \"E3\"\ntitle = \"Tests\"\ntechnique = \"experiment\"\nconditions = \"typical\"\n\
         tables.junit = \"runs\"\n{tables}changed = \"Tests.\"\n"
    );
    study.write("ledger.toml", ledger + &entry);
    study
}

fn result(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

/// Count, trials and undecided of the requirement that the tests verify.
fn counted(study: &Study) -> [u64; 3] {
    let result = result(&study.run(&["-q", "run", "study", "--format", "json"]));
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|it| it["id"] == "E3").expect("E3");
    let findings = piece["findings"].as_array().expect("findings");
    let finding = findings
        .iter()
        .find(|it| it["subject"]["id"] == "2")
        .expect("of 2");
    let number = |value: &Value| value.as_u64().unwrap_or_else(|| panic!("{finding}"));
    let measure = &finding["measure"];
    [&measure["count"], &measure["trials"], &finding["undecided"]].map(number)
}

#[test]
fn test_cases_of_many_runs_are_trials() {
    let mut files: Vec<(String, String)> = (0..20)
        .map(|run| {
            (
                format!("run-{run:02}.xml"),
                run_of("2", Some(run), if run == 3 { FAILURE } else { "" }),
            )
        })
        .collect();
    // The same seed again, in a folder of its own, is the same trial.
    files.push((
        "again/run.xml".into(),
        run_of("2", Some(7), "") + "<!-- again -->",
    ));
    files.push(("broken.xml".into(), run_of("2", Some(30), ERROR)));
    files.push(("skipped.xml".into(), run_of("2", Some(31), "<skipped/>")));
    files.push(("notes.txt".into(), "no results".into()));
    let files: Vec<(&str, String)> = files
        .iter()
        .map(|(name, text)| (name.as_str(), text.clone()))
        .collect();
    let study = with_runs(&files, "");
    assert_eq!(counted(&study), [19, 20, 1]);
    // Another file makes it stale.
    study.write("runs/run-50.xml", run_of("2", Some(50), FAILURE));
    assert_eq!(counted(&study), [19, 21, 1]);
}

#[test]
fn without_seeds_each_file_is_a_run_and_each_try_is_seen() {
    let flaky = "<flakyFailure type=\"f\" message=\"first try\"/>";
    let files = [
        ("a.xml", run_of("", None, "")),
        ("b.xml", run_of("", None, FAILURE)),
        // It passed at the second try: one of two.
        ("c.xml", run_of("", None, flaky)),
    ];
    let study = with_runs(
        &files,
        "tables.tests = { 2 = \"tests.test_dock.test_slow\" }\n",
    );
    assert_eq!(counted(&study), [2, 4, 0]);
    // What stands in brackets tells trials of one test apart.
    let many = "<testsuite name=\"s\" tests=\"3\"><testcase classname=\"tests.test_dock\" name=\"test_slow[1-3]\"/>\
                <testcase classname=\"tests.test_dock\" name=\"test_slow[2-3]\"/>\
                <testcase classname=\"tests.test_dock\" name=\"test_slow[3-3]\"><failure/></testcase></testsuite>";
    let study = with_runs(
        &[("d.xml", many.into())],
        "tables.tests = { 2 = \"test_slow\" }\n",
    );
    assert_eq!(counted(&study), [2, 3, 0]);
}

#[test]
fn results_that_are_no_trials_are_refused_with_their_place() {
    let refused = |files: &[(&str, String)], tables: &str, code: &str, part: &str| {
        let study = with_runs(files, tables);
        let said = study.run(&["plan", "study"]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(&format!("error[{code}]")),
            "{}",
            said.talk
        );
        assert!(said.talk.contains(part), "{}", said.talk);
    };
    let same = [
        ("a.xml", run_of("2", Some(1), "")),
        ("b.xml", run_of("2", Some(1), FAILURE)),
    ];
    refused(&same, "", "bad-junit", "its seed does not fix it");
    let copy = [
        ("a.xml", run_of("2", None, "")),
        ("b.xml", run_of("2", None, "")),
    ];
    refused(&copy, "", "bad-junit", "the same content");
    refused(
        &[("a.xml", run_of("99", None, ""))],
        "",
        "unknown-subject",
        "runs/a.xml:3:1",
    );
    refused(
        &[("a.xml", "<testsuites><a>".into())],
        "",
        "bad-junit",
        "runs/a.xml:1:",
    );
    refused(
        &[("a.xml", "<html/>".into())],
        "",
        "bad-junit",
        "the root of JUnit XML",
    );
    let rate = run_of("2", None, "").replace(
        "<properties>",
        "<properties><property name=\"guarantee\" value=\"x\"/>",
    );
    refused(
        &[("a.xml", rate)],
        "",
        "bad-junit",
        "a rate with its guarantee",
    );
    let named = "tables.tests = { 9 = \"test_slow\" }\n";
    refused(
        &[("a.xml", run_of("2", None, ""))],
        named,
        "unknown-subject",
        "`9`",
    );
    let twice = "tables.requirements = \"requirements.csv\"\n";
    refused(
        &[("a.xml", run_of("2", None, ""))],
        twice,
        "tables-disagree",
        "requirement 2",
    );
}

#[test]
fn verdicts_are_written_for_build_servers_reviews_and_editors() {
    let study = Study::new();
    // Docking now fails in half of the attempts.
    let attempts = read(&study.path("attempts.csv"));
    let mut rows: Vec<String> = attempts.lines().map(str::to_owned).collect();
    for row in rows.iter_mut().skip(1) {
        *row = row
            .split(',')
            .next()
            .map(|session| format!("{session},2,5,"))
            .expect("a row");
    }
    study.write("attempts.csv", rows.join("\n") + "\n");
    study.edit(
        "failure_modes.csv",
        "missed_contact,4,100",
        "missed_contact,0,100",
    );
    let said = study.run(&[
        "-q",
        "run",
        "study",
        "--junit",
        "v.xml",
        "--markdown",
        "v.md",
        "--sarif",
        "v.sarif",
    ]);
    assert_eq!(said.code, 1, "{said:?}");
    let file = |name: &str| read(&study.beside().join(name));
    let junit = file("v.xml");
    assert!(
        junit.contains("<property name=\"verifies\" value=\"1\"/>"),
        "{junit}"
    );
    assert!(junit.contains("<failure type=\""), "{junit}");
    assert!(
        junit.contains("<property name=\"rate E2\" value=\"0.4\"/>"),
        "{junit}"
    );
    let markdown = file("v.md");
    assert!(
        markdown.starts_with("## A robot docks at its charger\n"),
        "{markdown}"
    );
    assert!(markdown.contains("40/100 = 40.0"), "{markdown}");
    let log: Value = serde_json::from_str(&file("v.sarif")).expect("JSON");
    let found = &log["runs"][0]["results"][0];
    let place = &found["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "study/requirements.toml");
    let line = place["region"]["startLine"].as_u64().expect("a line") as usize;
    let text = read(&study.path("requirements.toml"));
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[line - 1..line + 2]
            .iter()
            .any(|it| it.contains("id = \"1\"")),
        "{line}"
    );
    // The report writes the same again.
    let again = [
        "-q", "report", "study", "--junit", "w.xml", "--sarif", "w.sarif",
    ];
    assert_eq!(study.run(&again).code, 1);
    assert_eq!(file("w.xml"), junit);
    assert_eq!(file("w.sarif"), file("v.sarif"));
}

/// The verdict stands on trials of the system, and the model says another number: the exit code is 1, and no format says that all is well.
#[test]
fn a_conflict_below_a_satisfied_requirement_is_in_every_format() {
    let study = Study::new();
    let attempts = read(&study.path("attempts.csv"));
    let rows = attempts.lines().enumerate().map(|(at, row)| match at {
        0 => row.to_owned(),
        _ => format!("{},2,5,", row.split(',').next().expect("a session")),
    });
    study.write("attempts.csv", rows.collect::<Vec<_>>().join("\n") + "\n");
    study.edit(
        "failure_modes.csv",
        "missed_contact,4,100",
        "missed_contact,0,100",
    );
    let shall = |rate: &str| format!("with probability at least {rate} within");
    study.edit("requirements.toml", &shall("0.9"), &shall("0.1"));
    let files = ["--junit", "v.xml", "--sarif", "v.sarif"];
    let said = study.run(&[&["-q", "run", "study"][..], &files].concat());
    assert_eq!(said.code, 1, "{said:?}");
    let result = read(&study.path("results/study.json"));
    let result: Value = serde_json::from_str(&result).expect("JSON");
    assert_eq!(result["conclusions"][0]["verdict"], "satisfied", "{result}");
    let file = |name: &str| read(&study.beside().join(name));
    let junit = file("v.xml");
    assert!(
        junit.contains("failures=\"2\"") && junit.contains("E1 and E2 conflict. "),
        "{junit}"
    );
    let log: Value = serde_json::from_str(&file("v.sarif")).expect("JSON");
    let found = &log["runs"][0]["results"][0];
    assert_eq!(found["ruleId"], "conflicting", "{log}");
    assert_eq!(
        found["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
        "study/requirements.toml"
    );
    let pack = study.run(&["pack", "study", "--to", "p.zip"]);
    let said = "requirement 1: Which of two pieces of evidence is right: E1 and E2 conflict. ";
    assert!(pack.code == 0 && pack.out.contains(said), "{pack:?}");
}

#[test]
fn mistakes_of_a_study_are_findings_at_their_lines() {
    let study = Study::new();
    study.edit(
        "ledger.toml",
        "conditions = \"typical\"",
        "conditions = \"tropical\"",
    );
    for command in ["plan", "run"] {
        let name = format!("{command}.sarif");
        let said = study.run(&[command, "study", "--sarif", &name]);
        assert_eq!(said.code, 2, "{said:?}");
        let log: Value = serde_json::from_str(&read(&study.beside().join(name))).expect("JSON");
        let found = &log["runs"][0]["results"][0];
        assert!(
            said.talk
                .contains(found["ruleId"].as_str().expect("a rule"))
        );
        let place = &found["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uri"], "study/ledger.toml");
        let line = place["region"]["startLine"].as_u64().expect("a line") as usize;
        assert!(
            read(&study.path("ledger.toml"))
                .lines()
                .nth(line - 1)
                .expect("a line")
                .contains("tropical")
        );
    }
}

#[test]
fn mistakes_of_a_model_are_findings_at_their_lines() {
    let study = Study::new();
    study.edit(
        "model.prism",
        "const double pTouches = 0.95;",
        "const double pTouches = ;",
    );
    let said = study.run(&[
        "check",
        "study/model.prism",
        "P=? [ F x=1 ]",
        "--sarif",
        "m.sarif",
    ]);
    assert_eq!(said.code, 2, "{said:?}");
    let log: Value = serde_json::from_str(&read(&study.beside().join("m.sarif"))).expect("JSON");
    let place = &log["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "study/model.prism");
    let line = place["region"]["startLine"].as_u64().expect("a line") as usize;
    let text = read(&study.path("model.prism"));
    assert!(
        text.lines()
            .nth(line - 1)
            .expect("a line")
            .contains("pTouches ="),
        "{log}"
    );
}

fn diff(study: &Study, old: &str, new: &str) -> (i32, Value) {
    let said = study.run(&["diff", old, new, "--format", "json"]);
    let report = result(&said);
    let schema = read(&root().join("schemas/diff.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    assert_eq!(violations(&schema, &report), Vec::<String>::new());
    (said.code, report)
}

/// A requirement under another name is the same one, by its text: its verdict did not get worse.
#[test]
fn a_requirement_that_was_renamed_is_said_to_be_renamed() {
    let study = Study::new();
    let run = |out: &str| study.run(&["-q", "run", "study", "--out", out]).code;
    assert_eq!(run("one"), 0);
    study.edit("requirements.toml", "id = \"1\"", "id = \"DOCK-1\"");
    let table = read(&study.path("requirements.csv"));
    let rows = table.lines().map(|row| match row.strip_prefix("1,") {
        Some(rest) => format!("DOCK-1,{rest}\n"),
        None => format!("{row}\n"),
    });
    study.write("requirements.csv", rows.collect::<String>());
    run("renamed");
    let (code, report) = diff(&study, "one", "renamed");
    assert_eq!(
        report["renamed"],
        serde_json::json!([{ "before": "1", "after": "DOCK-1" }])
    );
    assert_eq!(code, 0, "{report}");
    let verdicts = report["verdicts"].as_array().expect("a list");
    assert!(verdicts.iter().all(|it| it["changed"] == false), "{report}");
    let text = study.run(&["diff", "one", "renamed"]).out;
    assert!(
        text.contains("Renamed: 1 requirement\n  DOCK-1: before 1 (the text is the same)\n"),
        "{text}"
    );
}

#[test]
fn a_difference_says_what_is_stale_what_stands_and_what_changed_beyond_chance() {
    let study = Study::new();
    let run = |out: &str| study.run(&["-q", "run", "study", "--out", out]).code;
    assert_eq!(run("one"), 0);
    assert_eq!(run("same"), 0);
    let (code, none) = diff(&study, "one", "same/study.json");
    assert_eq!(code, 0);
    let fates = |report: &Value| -> Vec<String> {
        let pieces = report["evidence"].as_array().expect("a list");
        pieces
            .iter()
            .map(|it| format!("{} {}", it["id"], it["fate"]).replace('"', ""))
            .collect()
    };
    assert_eq!(fates(&none), ["E1 stands", "E2 stands"]);
    assert_eq!(none["rates"].as_array().map(Vec::len), Some(0));
    // One attempt less succeeded: that is no change beyond chance. The model stands.
    let attempts = read(&study.path("attempts.csv"));
    study.edit("attempts.csv", "\n2,5,5,", "\n2,4,5,M");
    study.edit(
        "failure_modes.csv",
        "missed_contact,4,",
        "missed_contact,5,",
    );
    run("little");
    // Though the verdict is no longer supported by the trials.
    let (code, little) = diff(&study, "one", "little");
    assert_eq!(code, 1, "{little}");
    assert_eq!(fates(&little), ["E1 stands", "E2 produced-again"]);
    let rates = little["rates"].as_array().expect("a list");
    assert!(
        !rates.is_empty() && rates.iter().all(|it| it["beyond_chance"] == false),
        "{little}"
    );
    let files = little["evidence"][1]["files"].to_string();
    assert!(
        files.contains("attempts.csv") && !files.contains("model.prism"),
        "{files}"
    );
    // Half of them: beyond chance, and for the worse.
    let half: String = attempts
        .lines()
        .enumerate()
        .map(|(line, row)| match line {
            0 => format!("{row}\n"),
            _ => row
                .split(',')
                .next()
                .map(|it| format!("{it},2,5,\n"))
                .expect("a row"),
        })
        .collect();
    study.write("attempts.csv", half);
    study.edit(
        "failure_modes.csv",
        "missed_contact,5,",
        "missed_contact,0,",
    );
    run("half");
    let (code, half) = diff(&study, "one", "half");
    assert_eq!(code, 1);
    let changed = half["rates"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|it| it["subject"]["id"] == "1");
    let changed = changed.expect("of requirement 1");
    assert_eq!(
        (&changed["beyond_chance"], &changed["worse"]),
        (&true.into(), &true.into()),
        "{changed}"
    );
    assert!(
        half["verdicts"]
            .as_array()
            .expect("a list")
            .iter()
            .any(|it| it["worse"] == true)
    );
    // For the better it is no failure.
    assert_eq!(diff(&study, "half", "one").0, 0);
    // What is asked for is loosened by the same edit: that is said, and the rate is judged as before.
    study.edit("requirements.toml", "margin = 0.10", "margin = 0.99");
    run("loose");
    let (code, loose) = diff(&study, "one", "loose");
    assert_eq!(code, 1, "{loose}");
    let asked = &loose["asked"][0];
    assert!(
        asked["before"]
            .as_str()
            .is_some_and(|it| it.ends_with("margin 0.1"))
            && asked["after"]
                .as_str()
                .is_some_and(|it| it.ends_with("margin 0.99")),
        "{loose}"
    );
    let rates = loose["rates"].as_array().expect("a list");
    let of_1 = rates.iter().find(|it| it["subject"]["id"] == "1");
    assert_eq!(of_1.expect("of requirement 1")["beyond_margin"], true);
    assert_eq!(half["asked"], serde_json::json!([]));
    let text = study.run(&["diff", "one", "loose"]).out;
    assert!(text.contains("Asked for: 1 requirement changed"), "{text}");
    let text = study.run(&["diff", "one", "half"]).out;
    assert!(text.contains("\nStands as it was: 1\n  E1\n"), "{text}");
    assert!(text.contains("worse: 1: "), "{text}");
    // What is unchanged as it is printed is no change.
    let of_costs = text.lines().skip_while(|it| !it.starts_with("Costs: "));
    for line in of_costs.filter(|it| it.contains(", before ")) {
        let (now, before) = line.split_once(", before ").expect("both");
        let now = now.split_whitespace().nth(1).expect("a number");
        assert_ne!(now, before, "{line}");
    }
    let markdown = study
        .run(&["diff", "one", "half", "--format", "markdown"])
        .out;
    assert!(
        markdown.starts_with("## A robot docks at its charger: what changed"),
        "{markdown}"
    );
    let said = study.run(&["diff", "one", "nowhere"]);
    assert!(
        said.code == 2 && said.talk.contains("error[not-run]"),
        "{said:?}"
    );
}

/// A script of `ci/`, run beside a study with the program under test.
fn script(study: &Study, name: &str, arguments: &[&str], fail_on: &str) -> Said {
    let mut command = std::process::Command::new("sh");
    command
        .arg(root().join("ci").join(name))
        .args(arguments)
        .current_dir(study.beside())
        .env("CORROBORATE", env!("CARGO_BIN_EXE_corroborate"))
        .env("CORROBORATE_MUJOCO", "")
        .env("CORROBORATE_TRUST", "/")
        .env("CORROBORATE_FAIL_ON", fail_on);
    support::program::said(&mut command)
}

#[test]
fn a_step_of_continuous_integration_fails_on_a_regression_and_on_what_it_is_told_to() {
    let study = Study::new();
    let step = |arguments: &[&str], fail_on: &str| script(&study, "study.sh", arguments, fail_on);
    let first = step(&["study", "base", "nowhere"], "regression");
    assert_eq!(first.code, 0, "{first:?}");
    assert!(!study.beside().join("base/ci/diff.md").exists());
    for name in ["junit.xml", "summary.md", "findings.sarif"] {
        assert!(study.beside().join("base/ci").join(name).exists(), "{name}");
    }
    let attempts = read(&study.path("attempts.csv"));
    let half = attempts.lines().enumerate().map(|(line, row)| match line {
        0 => format!("{row}\n"),
        _ => row
            .split(',')
            .next()
            .map(|it| format!("{it},2,5,\n"))
            .expect("a row"),
    });
    study.write("attempts.csv", half.collect::<String>());
    study.edit(
        "failure_modes.csv",
        "missed_contact,4,",
        "missed_contact,0,",
    );
    let worse = step(&["study", "now", "base"], "regression");
    assert_eq!(worse.code, 1, "{worse:?}");
    assert!(read(&study.beside().join("now/ci/diff.md")).contains("worse: 1"));
    // What was violated before is no regression, but a violation.
    assert_eq!(step(&["study", "again", "now"], "regression").code, 0);
    assert_eq!(step(&["study", "again", "now"], "violation").code, 1);
    assert_eq!(step(&["study", "again"], "regression").code, 1);
    assert_eq!(step(&["study", "again"], "never").code, 0);
    assert_eq!(step(&["study", "again"], "sometimes").code, 2);
    study.write("ledger.toml", "[[evidence]]\n");
    assert_eq!(step(&["study", "again", "now"], "never").code, 2);
    assert_eq!(step(&["study"], "never").code, 2);
}

#[test]
fn the_hook_checks_the_studies_of_changed_files_once_each() {
    let study = Study::new();
    let hook = |files: &[&str]| script(&study, "pre-commit/check-studies", files, "never");
    assert_eq!(
        hook(&["study/ledger.toml", "study/model.prism", "elsewhere.toml"]).code,
        0
    );
    study.edit(
        "ledger.toml",
        "conditions = \"typical\"",
        "conditions = \"tropical\"",
    );
    let said = hook(&["study/model.prism", "study/ledger.toml"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert_eq!(
        said.talk.matches("error[unknown-conditions]").count(),
        1,
        "{}",
        said.talk
    );
    assert_eq!(hook(&["elsewhere.toml"]).code, 0);
}

/// The published schemas are not kept here: they are named by the environment, and read by Python's `jsonschema` and `lxml`.
#[test]
fn what_is_written_conforms_to_the_published_schemas() {
    let schemas = ["CORROBORATE_SARIF_SCHEMA", "CORROBORATE_JUNIT_SCHEMA"].map(std::env::var_os);
    let [Some(sarif), Some(junit)] = schemas else {
        eprintln!("skipped: CORROBORATE_SARIF_SCHEMA and CORROBORATE_JUNIT_SCHEMA name no schemas");
        return;
    };
    let study = Study::new();
    assert_eq!(
        study
            .run(&[
                "-q", "run", "study", "--junit", "v.xml", "--sarif", "v.sarif"
            ])
            .code,
        0
    );
    study.edit(
        "ledger.toml",
        "conditions = \"typical\"",
        "conditions = \"tropical\"",
    );
    assert_eq!(
        study
            .run(&["-q", "plan", "study", "--sarif", "p.sarif"])
            .code,
        2
    );
    // pytest writes properties of a case, too, which the schema of Jenkins' plugin has of suites alone.
    let check = "import json, sys, jsonschema, lxml.etree as xml\n\
                 sarif = jsonschema.Draft4Validator(json.load(open(sys.argv[1])))\n\
                 for name in ('v.sarif', 'p.sarif'):\n    sarif.validate(json.load(open(name)))\n\
                 text = open(sys.argv[2]).read()\n\
                 case = text.index('name=\"testcase\"')\n\
                 text = text[:case] + text[case:].replace('<xs:element ref=\"skipped\"/>', '<xs:element ref=\"properties\"/><xs:element ref=\"skipped\"/>', 1)\n\
                 xml.XMLSchema(xml.fromstring(text.encode())).assertValid(xml.parse('v.xml'))\n";
    let said = std::process::Command::new("python3")
        .args(["-c", check])
        .args([sarif, junit])
        .current_dir(study.beside())
        .output()
        .expect("python3 runs");
    assert!(
        said.status.success(),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
}
