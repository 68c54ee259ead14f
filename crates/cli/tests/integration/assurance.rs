//! `assure` and `verify` as their users see them: what they write, and that no changed figure passes.

use crate::support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use support::program::{Said, Study};
use support::schema::violations;
use support::{read, root};

const RESULTS: &str = "study/results";

fn ran() -> Study {
    let study = Study::new();
    let said = study.run(&["run", "study"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    study
}

fn verify(study: &Study) -> Said {
    study.run(&["verify", RESULTS, "--format", "json"])
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

/// The files and places of the faults that were found.
fn faults(said: &Said) -> Vec<(String, String)> {
    let report = json(&said.out);
    let faults = report["faults"].as_array().expect("a list");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    faults
        .iter()
        .map(|fault| (text(&fault["file"]), text(&fault["place"])))
        .collect()
}

/// The pointers of all numbers in a value.
fn numbers(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(place.to_owned()),
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                numbers(item, &format!("{place}/{i}"), found);
            }
        }
        Value::Object(fields) => {
            for (name, field) in fields {
                let name = name.replace('~', "~0").replace('/', "~1");
                numbers(field, &format!("{place}/{name}"), found);
            }
        }
        _ => {}
    }
}

/// The number with another last digit.
fn changed(number: &Value) -> Value {
    let text = number.to_string();
    let (mantissa, exponent) = match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, format!("e{exponent}")),
        None => (text.as_str(), String::new()),
    };
    let last = mantissa
        .chars()
        .last()
        .and_then(|c| c.to_digit(10))
        .expect("a digit");
    let other = json(&format!(
        "{}{}{exponent}",
        &mantissa[..mantissa.len() - 1],
        (last + 1) % 10
    ));
    // In the last place of a double, one digit more may be the same number.
    if &other == number {
        json(&format!(
            "{}{}{exponent}",
            &mantissa[..mantissa.len() - 1],
            (last + 5) % 10
        ))
    } else {
        other
    }
}

#[test]
fn an_untouched_result_holds() {
    let study = ran();
    let before = study.contents();
    let said = verify(&study);
    assert_eq!((said.code, faults(&said).len()), (0, 0), "{said:?}");
    let schema = json(&read(&root().join("schemas/verify.schema.json")));
    let found = violations(&schema, &json(&said.out));
    assert!(found.is_empty(), "{found:?}");
    assert!(before == study.contents(), "nothing was written");
    let text = study.run(&["verify", RESULTS]);
    assert!(
        text.out.contains("Everything that was checked holds."),
        "{text:?}"
    );
    assert!(
        text.out.contains("E1: the model was not solved again"),
        "{text:?}"
    );
    // From elsewhere, the study is named.
    std::fs::rename(study.path("results"), study.beside().join("moved")).expect("moved");
    assert_eq!(study.run(&["verify", "moved"]).code, 2);
    assert_eq!(study.run(&["verify", "moved", "study"]).code, 0);
}

/// Every number in study.json, each changed in its last digit: all of them are named.
#[test]
fn every_changed_number_of_the_result_is_named() {
    let study = ran();
    let path = study.path("results/study.json");
    let mut value = json(&read(&path));
    let mut places = Vec::new();
    numbers(&value, "", &mut places);
    assert!(places.len() > 40, "{} numbers", places.len());
    for place in &places {
        let number = value.pointer_mut(place).expect("a number");
        *number = changed(number);
    }
    std::fs::write(&path, value.to_string()).expect("written");
    let said = verify(&study);
    assert_eq!(said.code, 1, "{said:?}");
    let found = faults(&said);
    for place in &places {
        let named = |(file, at): &(String, String)| file.ends_with("study.json") && at == place;
        assert!(found.iter().any(named), "{place} passes");
    }
}

/// One number at a time, with the report drawn from it again and nothing else touched.
#[test]
fn a_single_changed_number_does_not_pass() {
    let study = ran();
    let path = study.path("results/study.json");
    let original = read(&path);
    let value = json(&original);
    let mut places = Vec::new();
    numbers(&value, "", &mut places);
    for place in places.iter().step_by(places.len() / 12) {
        let old = value.pointer(place).expect("a number");
        let mut other = value.clone();
        *other.pointer_mut(place).expect("a number") = changed(old);
        std::fs::write(&path, other.to_string()).expect("written");
        if study.run(&["report", "study"]).code == 2 {
            continue; // It is not even a result any more.
        }
        let said = verify(&study);
        assert_eq!(said.code, 1, "{place}: {said:?}");
        assert!(
            faults(&said).iter().any(|(_, at)| at == place),
            "{place}: {said:?}"
        );
    }
}

/// Digits of the page that a reader sees.
#[test]
fn a_changed_digit_of_the_report_is_found() {
    let study = ran();
    let path = study.path("results/report.html");
    let original = read(&path);
    let digits: Vec<usize> = original
        .char_indices()
        .filter(|(_, c)| c.is_ascii_digit())
        .map(|(place, _)| place)
        .collect();
    for place in digits.iter().step_by(digits.len() / 12) {
        let mut page = original.clone();
        let other = if &page[*place..=*place] == "7" {
            "3"
        } else {
            "7"
        };
        page.replace_range(*place..=*place, other);
        std::fs::write(&path, page).expect("written");
        let said = verify(&study);
        assert_eq!(said.code, 1, "digit at {place}");
        assert!(
            faults(&said)
                .iter()
                .all(|(file, _)| file.ends_with("report.html")),
            "{said:?}"
        );
    }
}

/// The JSON without the spaces between its parts.
fn compact(pretty: &str) -> String {
    let mut is_text = false;
    let mut is_escaped = false;
    let keep = |c: &char| {
        if *c == '"' && !is_escaped {
            is_text = !is_text;
        }
        is_escaped = is_text && *c == '\\' && !is_escaped;
        is_text || !c.is_whitespace()
    };
    pretty.chars().filter(keep).collect()
}

/// Replaces a text in kept evidence, and makes its hash fit.
fn forge(path: &Path, old: &str, new: &str) {
    let text = read(path);
    assert!(text.contains(old), "{} has no {old}", path.display());
    let forged = text.replacen(old, new, 1);
    let begin = forged.find("\"content\": ").expect("a content") + 11;
    let end = forged.rfind('}').expect("an end");
    let digest = blake3::hash(compact(&forged[begin..end]).as_bytes()).to_hex();
    let stated = json(&forged)["digest"]
        .as_str()
        .expect("a digest")
        .to_owned();
    std::fs::write(path, forged.replace(&stated, &digest)).expect("written");
}

/// A count is changed in the evidence, its hash made to fit, and all that follows computed from it:
/// the tables know better.
#[test]
fn evidence_is_held_against_its_tables() {
    let study = ran();
    let path = study.path("results/evidence/E2.json");
    forge(&path, "\"trials\": 100", "\"trials\": 100");
    assert_eq!(
        verify(&study).code,
        0,
        "the forgery is as good as the original"
    );
    forge(&path, "\"trials\": 100", "\"trials\": 101");
    let found = faults(&verify(&study));
    assert!(found.iter().all(|(_, at)| at != "/digest"), "{found:?}");
    let of_evidence = |(file, at): &(String, String)| {
        file.ends_with("E2.json") && at.ends_with("/measure/trials")
    };
    assert!(found.iter().any(of_evidence), "{found:?}");
    assert!(
        found.iter().any(|(file, _)| file.ends_with("study.json")),
        "{found:?}"
    );
    let text = read(&path);
    std::fs::write(
        &path,
        text.replacen("\"trials\": 101", "\"trials\": 102", 1),
    )
    .expect("written");
    let found = faults(&verify(&study));
    assert!(found.iter().any(|(_, at)| at == "/digest"), "{found:?}");
}

/// The same for a campaign: its journal is counted again, and its recordings have their hashes.
/// Needs `python3`, which the simulator is written in.
#[test]
fn evidence_is_held_against_its_journal_and_recordings() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let entries = std::fs::read_dir(root().join("conformance/command")).expect("a study");
    for entry in entries.flatten().filter(|entry| entry.path().is_file()) {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).expect("copied");
    }
    let call = |arguments: &[&str]| support::program::corroborate(folder.path(), arguments);
    let said = call(&["run", "."]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let verify = || call(&["verify", "results", "--format", "json"]);
    let said = verify();
    assert_eq!((said.code, faults(&said).len()), (0, 0), "{said:?}");
    assert!(said.out.contains("journals of episodes"), "{said:?}");
    let evidence = folder.path().join("results/evidence/sim.json");
    let original = read(&evidence);
    let count = &json(&original)["content"]["findings"][0]["measure"]["count"];
    let count = count.as_u64().expect("a count");
    let (old, new) = (
        format!("\"count\": {count}"),
        format!("\"count\": {}", count - 1),
    );
    forge(&evidence, &old, &new);
    let found = faults(&verify());
    let counted = |(file, at): &(String, String)| {
        file.ends_with("sim.json") && at.ends_with("/measure/count")
    };
    assert!(found.iter().any(counted), "{found:?}");
    std::fs::write(&evidence, original).expect("written");
    assert_eq!(verify().code, 0);
    let episodes = folder.path().join("results/episodes/sim");
    let is_recording = |name: &PathBuf| name.to_string_lossy().starts_with("episode-");
    let recording = files(&episodes).into_iter().find(is_recording);
    let recording = episodes.join(recording.expect("a recording"));
    let bytes = std::fs::read(&recording).expect("bytes");
    std::fs::write(&recording, [&bytes[..], b"\n"].concat()).expect("written");
    let found = faults(&verify());
    let name = Path::new(&found[0].0).file_name().expect("a name");
    assert!(found.len() == 1 && recording.ends_with(name), "{found:?}");
    std::fs::write(&recording, bytes).expect("written");
    let journal = episodes.join("journal");
    let lines = read(&journal);
    std::fs::write(&journal, lines.replacen("\"seed\":", "\"seed\":1", 1)).expect("written");
    let found = faults(&verify());
    assert!(
        found.iter().any(|(file, _)| file.ends_with("journal")),
        "{found:?}"
    );
}

#[test]
fn changed_assets_and_missing_files_are_named() {
    let study = ran();
    let model = read(&study.path("model.prism"));
    study.write("model.prism", format!("{model}\n// touched\n"));
    let said = verify(&study);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(
        said.out
            .contains("model.prism is not the file that E1 rests on"),
        "{said:?}"
    );
    study.write("model.prism", model);
    assert_eq!(verify(&study).code, 0);
    let whole = read(&study.path("results/evidence/E1.json"));
    study.write("results/evidence/E1.json", &whole[..whole.len() / 2]);
    let said = verify(&study);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(faults(&said)[0].0.ends_with("E1.json"), "{said:?}");
    std::fs::remove_file(study.path("results/report.html")).expect("removed");
    assert_eq!(verify(&study).code, 1);
    study.write("results/study.json", "{");
    assert_eq!(verify(&study).code, 2);
    assert_eq!(study.run(&["verify", "nowhere"]).code, 2);
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let found = support::program::contents(folder);
    found
        .into_keys()
        .map(|path| path.strip_prefix(folder).expect("below").to_owned())
        .collect()
}

#[test]
fn the_assurance_case_is_written_and_verified() {
    let study = ran();
    let said = study.run(&["assure", "study"]);
    assert_eq!(said.code, 0, "{said:?}");
    let folder = study.path("results/assurance");
    let names = [
        "argument.gsn.yaml",
        "argument.sacm.xmi",
        "confidence.gsn.yaml",
        "evidence/E1.intoto.json",
        "evidence/E1.json",
        "evidence/E2.intoto.json",
        "evidence/E2.json",
        "provenance.json",
        "report.html",
        "study.intoto.json",
        "study.json",
    ];
    assert_eq!(files(&folder), names.map(PathBuf::from));
    for (name, schema) in [
        ("evidence/E2.intoto.json", "statement-evidence.schema.json"),
        ("study.intoto.json", "statement-study.schema.json"),
    ] {
        let statement = json(&read(&folder.join(name)));
        assert_eq!(statement["_type"], "https://in-toto.io/Statement/v1");
        let schema = json(&read(&root().join("schemas").join(schema)));
        let found = violations(&schema, &statement);
        assert!(found.is_empty(), "{name}: {found:?}");
        for subject in statement["subject"].as_array().expect("subjects") {
            let file = subject["name"].as_str().expect("a name");
            assert!(folder.join(file).exists(), "{file}");
            assert_eq!(subject["digest"]["sha256"].as_str().map(str::len), Some(64));
        }
    }
    assert_eq!(verify(&study).code, 0);
    let argument = read(&folder.join("argument.gsn.yaml"));
    study.write(
        "results/assurance/argument.gsn.yaml",
        argument.replacen("of 100", "of 101", 1),
    );
    let found = faults(&verify(&study));
    assert!(
        found.len() == 1 && found[0].0.ends_with("argument.gsn.yaml"),
        "{found:?}"
    );
    assert_eq!(
        study
            .run(&["assure", "study", "--to", "study/model.prism/x"])
            .code,
        2
    );
}

/// What another program says of a file of the assurance case.
fn judged_by(program: &str, arguments: &[&str]) -> std::process::Output {
    let output = std::process::Command::new(program).args(arguments).output();
    output.unwrap_or_else(|error| panic!("{program}: {error}"))
}

#[test]
#[ignore = "needs gsn2x (version 4) in PATH"]
fn gsn2x_finds_no_fault_in_the_arguments() {
    let study = ran();
    assert_eq!(study.run(&["assure", "study"]).code, 0);
    for name in ["argument", "confidence"] {
        let file = study.path(&format!("results/assurance/{name}.gsn.yaml"));
        let output = judged_by("gsn2x", &["-c", &file.display().to_string()]);
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{output:?}"
        );
    }
}

/// The values of an attribute, in the order of the text.
fn attribute<'t>(text: &'t str, name: &str) -> Vec<&'t str> {
    let begin = format!(" {name}=\"");
    let values = text.split(&begin).skip(1);
    values
        .map(|it| it.split('"').next().expect("its end"))
        .collect()
}

/// Both arguments in SACM: all that the others have, and every reference leads somewhere.
#[test]
fn the_arguments_in_sacm_are_whole() {
    let study = ran();
    assert_eq!(study.run(&["assure", "study"]).code, 0);
    let text = read(&study.path("results/assurance/argument.sacm.xmi"));
    let ids = attribute(&text, "xmi:id");
    let unique: std::collections::BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), unique.len());
    let mut references = 0;
    for name in [
        "source",
        "target",
        "reasoning",
        "metaClaim",
        "referencedArtifactElement",
    ] {
        for id in attribute(&text, name)
            .into_iter()
            .flat_map(|it| it.split(' '))
        {
            assert!(unique.contains(id), "{name} {id}");
            references += 1;
        }
    }
    assert!(references > 20, "{references}");
    for (package, file) in [("safety", "argument"), ("confidence", "confidence")] {
        let yaml = read(&study.path(&format!("results/assurance/{file}.gsn.yaml")));
        let elements = yaml
            .lines()
            .filter_map(|it| it.strip_prefix('"')?.strip_suffix("\":"));
        for element in elements {
            assert!(
                unique.contains(format!("{package}.{element}").as_str()),
                "{element}"
            );
        }
    }
    // Each claim point of the safety argument is about the claim that argues it.
    assert!(!attribute(&text, "metaClaim").is_empty());
    assert!(
        attribute(&text, "metaClaim")
            .iter()
            .all(|it| it.starts_with("confidence.G-"))
    );
}

#[test]
#[ignore = "needs python3 with pyecore in PATH, and the metamodel's folder (tools/sacm) in CORROBORATE_SACM"]
fn the_metamodel_of_sacm_takes_the_arguments() {
    let study = ran();
    assert_eq!(study.run(&["assure", "study"]).code, 0);
    let script = root()
        .join("conformance/peers/sacm.py")
        .display()
        .to_string();
    let metamodel = std::env::var("CORROBORATE_SACM").expect("CORROBORATE_SACM");
    let file = study
        .path("results/assurance/argument.sacm.xmi")
        .display()
        .to_string();
    let output = judged_by("python3", &[&script, &metamodel, &file]);
    assert!(output.status.success(), "{output:?}");
    assert!(
        String::from_utf8_lossy(&output.stdout).contains("ArgumentReasoning"),
        "{output:?}"
    );
}

#[test]
#[ignore = "needs python3 with the package `in-toto-attestation` in PATH"]
fn the_in_toto_package_reads_the_statements_whole() {
    // A field that is not of the format is an error of `Parse`; `validate` holds the statement against the specification.
    const READ: &str = "import json, sys\n\
        from google.protobuf import json_format\n\
        from in_toto_attestation.v1 import statement_pb2\n\
        from in_toto_attestation.v1.statement import Statement\n\
        for name in sys.argv[1:]:\n    \
            given = json.load(open(name))\n    \
            read = json_format.Parse(json.dumps(given), statement_pb2.Statement())\n    \
            Statement.copy_from_pb(read).validate()\n    \
            assert json.loads(json_format.MessageToJson(read)) == given, name\n";
    let study = ran();
    assert_eq!(study.run(&["assure", "study"]).code, 0);
    let names = ["study", "evidence/E1", "evidence/E2"];
    let files = names.map(|name| study.path(&format!("results/assurance/{name}.intoto.json")));
    let files = files.map(|file| file.display().to_string());
    let mut arguments = vec!["-c", READ];
    arguments.extend(files.iter().map(String::as_str));
    let output = judged_by("python3", &arguments);
    assert!(output.status.success(), "{output:?}");
}

#[test]
#[ignore = "needs python3 with the package `prov` in PATH"]
fn the_prov_package_reads_the_provenance_whole() {
    const READ: &str = "import json, sys\n\
        from prov.model import ProvDocument\n\
        given = json.load(open(sys.argv[1]))\n\
        read = ProvDocument.deserialize(sys.argv[1], format='json')\n\
        again = json.loads(read.serialize(format='json'))\n\
        tables = [name for name in given if name != 'prefix']\n\
        assert [len(given[t]) for t in tables] == [len(again[t]) for t in tables]\n\
        assert read == ProvDocument.deserialize(content=json.dumps(again), format='json')\n";
    let study = ran();
    assert_eq!(study.run(&["assure", "study"]).code, 0);
    let file = study.path("results/assurance/provenance.json");
    let output = judged_by("python3", &["-c", READ, &file.display().to_string()]);
    assert!(output.status.success(), "{output:?}");
}
