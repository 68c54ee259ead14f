//! The evidence pack end to end: made of a study, the same bytes each time, verified with and without the program, refused where it
//! would say something wrong.

use crate::support;

use serde_json::Value;
use std::process::Command;
use support::program::{Said, Study, contents, said};
use support::schema::violations;
use support::{read, root};

fn ran() -> Study {
    let study = Study::new();
    assert_eq!(study.run(&["-q", "run", "study"]).code, 0);
    assert_eq!(study.run(&["pack", "--new-key", "signer.pem"]).code, 0);
    study
}

/// A pack of the study, made without a browser, so that it is the same wherever the tests run.
fn pack(study: &Study, to: &str, further: &[&str]) -> Said {
    let arguments = [&["pack", "study", "--to", to], further].concat();
    let mut command = support::program::command(study.beside(), &arguments);
    said(command.env("PATH", ""))
}

fn verified(study: &Study, arguments: &[&str]) -> (i32, Value) {
    let said = study.run(&[&["verify"], arguments, &["--format", "json"]].concat());
    let report: Value = serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{said:?}"));
    let schema = read(&root().join("schemas/verify-pack.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    assert_eq!(violations(&schema, &report), Vec::<String>::new());
    (said.code, report)
}

#[test]
fn a_pack_is_the_same_each_time_and_its_signature_is_verified() {
    let study = ran();
    let key = ["--key", "signer.pem"];
    let first = pack(&study, "one.zip", &key);
    assert_eq!(first.code, 0, "{first:?}");
    assert!(
        first.out.contains("Signed by the key ")
            && first.out.contains("Report as PDF: not in this pack"),
        "{first:?}"
    );
    assert_eq!(pack(&study, "deep/er/two.zip", &key).code, 0);
    let bytes = |name: &str| std::fs::read(study.beside().join(name)).expect("a file");
    assert!(bytes("one.zip") == bytes("deep/er/two.zip"));
    let (code, report) = verified(&study, &["one.zip", "--key", "signer.pub.pem"]);
    assert_eq!(
        (code, &report["signature"]["is"]),
        (0, &"valid".into()),
        "{report}"
    );
    let (code, report) = verified(&study, &["one.zip"]);
    assert_eq!(
        (code, &report["signature"]["is"]),
        (3, &"not-verified".into())
    );
    // Of the study's own files.
    assert_eq!(report["study"], "A robot docks at its charger");
    let report: Value =
        serde_json::from_str(&pack(&study, "three.zip", &["--format", "json"]).out).expect("JSON");
    let schema = read(&root().join("schemas/pack.schema.json"));
    assert_eq!(
        violations(&serde_json::from_str(&schema).expect("JSON"), &report),
        Vec::<String>::new()
    );
    assert!(report["signed_by"].is_null());
    let (code, report) = verified(&study, &["three.zip"]);
    assert_eq!((code, &report["signature"]["is"]), (3, &"absent".into()));
    assert!(
        study
            .run(&["verify", "three.zip"])
            .out
            .contains("NOT SIGNED")
    );
    let (code, _) = verified(&study, &["three.zip", "--key", "signer.pub.pem"]);
    assert_eq!(code, 1);
}

/// What is in a pack, with the programs that its page asks for; nothing if they are not here.
fn unpacked(study: &Study, pack: &str) -> Option<std::path::PathBuf> {
    let to = study.beside().join("unpacked");
    let unzip = Command::new("unzip")
        .args(["-q", pack, "-d"])
        .arg(&to)
        .current_dir(study.beside())
        .status();
    match unzip {
        Ok(status) => assert!(status.success()),
        Err(_) => {
            eprintln!("skipped: unzip is not here");
            return None;
        }
    }
    Some(to)
}

#[test]
fn what_is_unpacked_is_the_study_with_its_results_and_follows_again() {
    let study = ran();
    let bom =
        r#"{"bomFormat": "CycloneDX", "specVersion": "1.6", "components": [{"name": "nav2"}]}"#;
    std::fs::write(study.beside().join("robot.cdx.json"), bom).expect("written");
    std::fs::write(study.beside().join("r.pdf"), "%PDF-1.7 made by hand").expect("written");
    let made = pack(
        &study,
        "one.zip",
        &["--sbom", "robot.cdx.json", "--pdf", "r.pdf"],
    );
    assert_eq!(made.code, 0, "{made:?}");
    let Some(folder) = unpacked(&study, "one.zip") else {
        return;
    };
    let again = study.run(&["verify", "unpacked/study/results"]);
    assert_eq!(again.code, 0, "{again:?}");
    for (name, content) in contents(&study.path("results/evidence")) {
        let name = name.file_name().expect("a name").to_owned();
        let packed = std::fs::read(folder.join("study/results/evidence").join(name));
        assert!(packed.expect("it is packed") == content);
    }
    assert_eq!(read(&folder.join("sbom/1-robot.cdx.json")), bom);
    assert_eq!(
        read(&folder.join("results/report.pdf")),
        "%PDF-1.7 made by hand"
    );
    let manifest: Value = serde_json::from_str(&read(&folder.join("manifest.json"))).expect("JSON");
    let schema = read(&root().join("schemas/statement-pack.schema.json"));
    assert_eq!(
        violations(&serde_json::from_str(&schema).expect("JSON"), &manifest),
        Vec::<String>::new()
    );
    let log: Value =
        serde_json::from_str(&read(&folder.join("verification/log.json"))).expect("JSON");
    let schema = read(&root().join("schemas/pack-log.schema.json"));
    assert_eq!(
        violations(&serde_json::from_str(&schema).expect("JSON"), &log),
        Vec::<String>::new()
    );
    // Each of SACE's artefacts of verification has a part, and only the letters that its guidance has.
    let parts = manifest["predicate"]["parts"].as_array().expect("parts");
    for letters in ["Q", "RR", "SS", "TT", "VV"] {
        assert!(parts.iter().any(|it| it["sace"] == letters), "{letters}");
    }
    let reqif = read(&folder.join("requirements/requirements.reqif"));
    assert!(
        reqif.contains("</REQ-IF>") && reqif.contains("<SPEC-OBJECT "),
        "{reqif}"
    );
    let readme = read(&folder.join("README.md"));
    for shown in [
        "**Not signed**",
        "CycloneDX 1.6, 1 component",
        "[TT] Verification results",
    ] {
        assert!(readme.contains(shown), "{shown} is not in\n{readme}");
    }
    let sarif = read(&folder.join("results/findings.sarif"));
    assert!(
        !sarif.contains(&study.beside().display().to_string()),
        "{sarif}"
    );
    let table = read(&folder.join("traceability/traceability.csv"));
    assert_eq!(
        table.lines().count(),
        5,
        "a head, and two pieces for each of two requirements: {table}"
    );
    assert!(
        table.contains("not expressible") && table.contains("96,100,0.96,"),
        "{table}"
    );
    assert!(!table.contains(",bounded,the verdict"), "{table}");
    // What the page marks as missing is in the table, too.
    let rows: Vec<&str> = table.lines().skip(1).collect();
    let lacks = |row: &&&str| row.trim_end_matches('"').ends_with("no test names it");
    assert_eq!(rows.iter().filter(lacks).count(), rows.len(), "{table}");
    let gap = |row: &&&str| row.contains("not expressible: ") && row.contains("; no test names it");
    assert!(rows.iter().any(|row| gap(&row)), "{table}");
    let page = read(&folder.join("traceability/traceability.html"));
    assert!(
        page.contains("no test names it")
            && page.contains("successes") == table.contains("successes")
    );
}

#[test]
fn open_requirements_and_what_was_left_out_are_said() {
    let study = Study::new();
    let asked = |before: &str, now: &str| {
        let shall = |rate: &str| format!("with probability at least {rate} within");
        study.edit("requirements.toml", &shall(before), &shall(now));
        let run = study.run(&["-q", "run", "study"]);
        assert!([1, 3].contains(&run.code), "{run:?}");
        let made = pack(&study, "one.zip", &[]);
        assert_eq!(made.code, 0, "{made:?}");
        made.out
    };
    study.edit(
        "study.toml",
        "[conditions]",
        "[conditions]\nnight = \"In the\\u001b[2J dark.\"",
    );
    // The model computes 95 %, and 96 of 100 trials decide neither.
    let violated = asked("0.9", "0.96");
    for said in [
        "requirement 1: What trials of the system would show: it is violated for the model.",
        "conditions `night`: Anything: no evidence is of these conditions (In the [2J dark.).",
        "requirement 2: Not covered: E1 cannot express it.",
        "the pack: Who made it: the pack is not signed",
    ] {
        assert!(violated.contains(said), "{said} is not in\n{violated}");
    }
    assert!(!violated.contains("conditions `typical`"), "{violated}");
    let for_the_model = asked("0.96", "0.945");
    let said = "requirement 1: That it holds of what it has to: it is satisfied for the model, and needs to be corroborated.";
    assert!(for_the_model.contains(said), "{for_the_model}");
}

#[test]
fn what_would_be_wrong_is_refused_with_its_remedy_and_nothing_is_written() {
    let study = ran();
    let refused = |further: &[&str], code: &str, remedy: &str| {
        let said = pack(&study, "no.zip", further);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(&format!("error[{code}]")) && said.talk.contains(remedy),
            "{said:?}"
        );
        assert!(!study.beside().join("no.zip").exists());
    };
    refused(&["--key", "signer.pub.pem"], "bad-key", "--new-key");
    refused(&["--key", "nowhere.pem"], "cannot-read", "check the name");
    std::fs::write(study.beside().join("x.json"), "{\"a\": }").expect("written");
    refused(&["--sbom", "x.json"], "bad-sbom", "x.json:1:7");
    refused(&["--pdf", "x.json"], "bad-pdf", "report.html");
    let report = read(&study.path("results/report.html"));
    study.write("results/report.html", report.replace("96", "97"));
    refused(
        &[],
        "result-does-not-follow",
        "corroborate verify study/results study",
    );
    study.write("results/report.html", report);
    study.edit("requirements.toml", "margin = 0.10", "margin = 0.09");
    refused(&[], "stale-result", "run `corroborate run study`");
    std::fs::remove_dir_all(study.path("results")).expect("removed");
    refused(&[], "not-run", "run `corroborate run study` first");
    let twice = study.run(&["pack", "--new-key", "signer.pem"]);
    assert!(
        twice.code == 2 && twice.talk.contains("error[key-exists]"),
        "{twice:?}"
    );
    let key = study.run(&["verify", "study", "--key", "signer.pub.pem"]);
    assert!(
        key.code == 2 && key.talk.contains("error[not-a-pack]"),
        "{key:?}"
    );
    let deep = study.run(&["verify", "signer.pem", "study"]);
    assert!(
        deep.code == 2 && deep.talk.contains("error[not-a-pack]"),
        "{deep:?}"
    );
    let (code, none) = verified(&study, &["signer.pem"]);
    assert!(
        code == 1
            && none["faults"][0]["fault"]
                .as_str()
                .is_some_and(|it| it.contains("not an evidence pack")),
        "{none}"
    );
}

#[test]
#[cfg(unix)]
fn a_secret_key_can_be_read_by_its_owner_alone() {
    use std::os::unix::fs::PermissionsExt;
    let study = ran();
    let mode = |name: &str| {
        std::fs::metadata(study.beside().join(name))
            .expect("a file")
            .permissions()
            .mode()
    };
    assert_eq!(mode("signer.pem") & 0o777, 0o600);
    assert_eq!(mode("signer.pub.pem") & 0o444, 0o444);
    assert!(
        read(&study.beside().join("signer.pem")) != read(&study.beside().join("signer.pub.pem"))
    );
}

/// A study in which a file has a name that would lead out of the folder, or mean something to a program.
#[test]
fn hostile_names_stay_within_the_pack() {
    let study = Study::new();
    let model = read(&study.path("model.prism"));
    std::fs::write(study.beside().join("-rf $(touch owned).prism"), model).expect("written");
    study.edit(
        "ledger.toml",
        "model = \"model.prism\"",
        "model = \"../-rf $(touch owned).prism\"",
    );
    assert_eq!(study.run(&["-q", "run", "study"]).code, 0);
    let made = pack(&study, "one.zip", &[]);
    assert_eq!(made.code, 0, "{made:?}");
    let said = "does not find these there: ../-rf $(touch owned).prism.";
    assert!(made.out.contains(said), "{made:?}");
    let (_, report) = verified(&study, &["one.zip"]);
    assert_eq!(report["faults"], serde_json::json!([]));
    let Some(folder) = unpacked(&study, "one.zip") else {
        return;
    };
    assert!(
        folder
            .join("study/%2E%2E/%2Drf %24(touch owned).prism")
            .exists()
    );
    assert!(!study.beside().join("owned").exists());
}

/// A name with spaces is kept, so that what is unpacked follows again.
#[test]
fn plain_names_stay_as_they_are() {
    let study = Study::new();
    let model = read(&study.path("model.prism"));
    study.write("my models (1)/a & b.prism", model);
    study.edit(
        "ledger.toml",
        "model = \"model.prism\"",
        "model = \"my models (1)/a & b.prism\"",
    );
    assert_eq!(study.run(&["-q", "run", "study"]).code, 0);
    let made = pack(&study, "one.zip", &[]);
    assert!(
        made.code == 0 && !made.out.contains("does not find these"),
        "{made:?}"
    );
    if unpacked(&study, "one.zip").is_some() {
        let again = study.run(&["verify", "unpacked/study/results"]);
        assert_eq!(again.code, 0, "{again:?}");
    }
}

/// What lies beside the result and was not verified is not signed.
#[test]
fn only_what_belongs_to_the_result_is_packed() {
    let study = ran();
    assert_eq!(study.run(&["-q", "diagnose", "study"]).code, 0);
    let said =
        "Left out of study/results: diagnosis.json (diagnosis.json is not of the present evidence";
    let fresh = pack(&study, "fresh.zip", &[]);
    assert!(fresh.code == 0 && !fresh.out.contains(said), "{fresh:?}");
    // Changed by hand, and no longer in the result, which was made again.
    let diagnosis = read(&study.path("results/diagnosis.json"));
    study.write(
        "results/diagnosis.json",
        diagnosis.replacen("\"digest\": \"", "\"digest\": \"0", 1),
    );
    assert_eq!(study.run(&["-q", "run", "study"]).code, 0);
    study.write("results/evidence/X9.json", "{}");
    study.write("results/evidence/E1/note.txt", "invented");
    study.write("results/episodes/OLD/journal", "invented");
    study.write("results/exploration/exploration.json", "{}");
    let made = pack(&study, "one.zip", &["--format", "json"]);
    // An exploration that cannot be read is nothing that `run` has taken.
    assert_eq!(made.code, 0, "{made:?}");
    for words in [
        said,
        "corroborate diagnose STUDY",
        "episodes/OLD/journal, evidence/E1/note.txt, evidence/X9.json (no entry of ledger.toml",
        "exploration/exploration.json (",
    ] {
        assert!(made.out.contains(words), "{words} is not in\n{made:?}");
    }
    let Some(folder) = unpacked(&study, "one.zip") else {
        return;
    };
    let manifest = read(&folder.join("manifest.json"));
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    let parts = manifest["subject"].as_array().expect("parts");
    for name in ["diagnosis", "X9", "note.txt", "OLD", "exploration"] {
        let is_in = |it: &Value| it["name"].as_str().is_some_and(|it| it.contains(name));
        assert!(!parts.iter().any(is_in), "{name}");
    }
}

#[test]
fn nothing_but_a_pack_is_written_over() {
    let study = ran();
    for name in ["study/requirements.toml", "signer.pem", "study"] {
        let before = study.contents();
        let said = pack(&study, name, &[]);
        assert!(
            said.code == 2 && said.talk.contains("error[pack-over-file]"),
            "{said:?}"
        );
        assert!(before == study.contents(), "{name}");
    }
    std::fs::write(study.beside().join("one.zip"), "").expect("written");
    assert_eq!(pack(&study, "one.zip", &[]).code, 0);
    assert_eq!(pack(&study, "one.zip", &["--key", "signer.pem"]).code, 0);
    let (code, _) = verified(&study, &["one.zip", "--key", "signer.pub.pem"]);
    assert_eq!(code, 0);
}

#[test]
fn evidence_on_an_absolute_path_is_not_packed() {
    let study = Study::new();
    let model = read(&study.path("model.prism"));
    let path = study.beside().join("outside.prism");
    std::fs::write(&path, model).expect("written");
    let named = format!("model = '{}'", path.display());
    study.edit("ledger.toml", "model = \"model.prism\"", &named);
    assert_eq!(study.run(&["-q", "run", "study"]).code, 0);
    let said = pack(&study, "one.zip", &[]);
    assert!(
        said.code == 2 && said.talk.contains("error[absolute-path]"),
        "{said:?}"
    );
    assert!(!study.beside().join("one.zip").exists());
}

/// Nothing is said of a signature that could not be reached.
#[test]
fn a_damaged_pack_is_not_said_to_be_unsigned() {
    let study = ran();
    assert_eq!(pack(&study, "one.zip", &["--key", "signer.pem"]).code, 0);
    let whole = std::fs::read(study.beside().join("one.zip")).expect("a file");
    std::fs::write(study.beside().join("cut.zip"), &whole[..100]).expect("written");
    for key in [&[][..], &["--key", "signer.pub.pem"]] {
        let (code, report) = verified(&study, &[&["cut.zip"], key].concat());
        assert_eq!(
            (code, &report["signature"]["is"]),
            (1, &"not-read".into()),
            "{report}"
        );
        assert!(!report.to_string().contains("not signed"), "{report}");
        assert!(!report.to_string().contains("no signature"), "{report}");
    }
}

/// Every byte of a small pack is changed in the tests of the crate; here some of a real one, by the program.
#[test]
fn changed_bytes_of_a_real_pack_are_noticed() {
    let study = ran();
    assert_eq!(pack(&study, "one.zip", &["--key", "signer.pem"]).code, 0);
    let file = study.beside().join("one.zip");
    let whole = std::fs::read(&file).expect("a file");
    for at in (1..whole.len()).step_by(whole.len() / 12) {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        std::fs::write(&file, &bytes).expect("written");
        let said = study.run(&["verify", "one.zip", "--key", "signer.pub.pem"]);
        assert_eq!(said.code, 1, "byte {at}: {said:?}");
    }
}

/// The envelope and the statement in it, as others read them.
#[test]
#[ignore = "needs python3 with the packages `securesystemslib`, `cryptography` and `in-toto-attestation` in PATH"]
fn the_securesystemslib_package_verifies_the_signature() {
    const READ: &str = "import json, sys\n\
        from cryptography.hazmat.primitives.serialization import load_pem_public_key\n\
        from google.protobuf import json_format\n\
        from in_toto_attestation.v1 import statement_pb2\n\
        from in_toto_attestation.v1.statement import Statement\n\
        from securesystemslib.dsse import Envelope\n\
        from securesystemslib.exceptions import VerificationError\n\
        from securesystemslib.signer import SSlibKey\n\
        given = json.load(open(sys.argv[1]))\n\
        keyid = given['signatures'][0]['keyid']\n\
        envelope = Envelope.from_dict(given)\n\
        public = load_pem_public_key(open(sys.argv[2], 'rb').read())\n\
        key = SSlibKey.from_crypto(public, keyid=keyid)\n\
        assert len(envelope.verify([key], 1)) == 1\n\
        read = json_format.Parse(envelope.payload.decode(), statement_pb2.Statement())\n\
        Statement.copy_from_pb(read).validate()\n\
        assert json.loads(json_format.MessageToJson(read)) == json.loads(envelope.payload)\n\
        envelope.payload = envelope.payload.replace(b'satisfied', b'violated', 1) + b' '\n\
        try:\n    envelope.verify([key], 1)\n\
        except VerificationError:\n    sys.exit(0)\n\
        sys.exit('a changed payload was verified')\n";
    let study = ran();
    assert_eq!(pack(&study, "one.zip", &["--key", "signer.pem"]).code, 0);
    let folder = unpacked(&study, "one.zip").expect("unzip is here");
    let files = [
        folder.join("manifest.dsse.json"),
        study.beside().join("signer.pub.pem"),
    ];
    let output = Command::new("python3")
        .args(["-c", READ])
        .args(files)
        .output();
    let output = output.expect("python3 starts");
    assert!(output.status.success(), "{output:?}");
}
