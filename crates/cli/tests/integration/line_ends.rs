//! Studies whose files end their lines with CR LF, as editors of Windows write them: everything comes out as with LF, and what
//! is written back keeps them.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use support::program::{Said, corroborate};
use support::{copy_study, files_below, read, root};
use tempfile::TempDir;

/// What people write in a study.
const TEXTS: [&str; 6] = ["toml", "prism", "props", "csv", "md", "json"];

fn is_text(path: &Path) -> bool {
    let ending = path.extension().and_then(|it| it.to_str());
    ending.is_some_and(|it| TEXTS.contains(&it))
}

fn with_cr_lf(text: &str) -> String {
    text.replace("\r\n", "\n").replace('\n', "\r\n")
}

/// Two folders with the same study, the second with CR LF.
fn both(make: impl Fn(&Path)) -> [TempDir; 2] {
    let folders = [(); 2].map(|()| TempDir::new().expect("a folder"));
    folders.iter().for_each(|folder| make(folder.path()));
    for path in files_below(folders[1].path()) {
        if is_text(&path) {
            std::fs::write(&path, with_cr_lf(&read(&path))).expect("written");
        }
    }
    folders
}

fn template(folder: &Path) {
    let made = corroborate(folder, &["init", "s"]);
    assert_eq!(made.code, 0, "{made:?}");
}

/// The texts of a study by their paths, without its results.
fn texts(folder: &Path) -> BTreeMap<String, String> {
    let files = files_below(folder).into_iter();
    let named = files.filter(|path| is_text(path)).map(|path| {
        let name = path.strip_prefix(folder).expect("below it");
        (name.display().to_string(), read(&path))
    });
    named
        .filter(|(name, _)| !name.contains("results"))
        .collect()
}

/// Calls the command in both folders: the same code.
fn called(folders: &[TempDir; 2], arguments: &[&str]) -> [Said; 2] {
    let said = [0, 1].map(|at| corroborate(folders[at].path(), arguments));
    assert_eq!(said[0].code, said[1].code, "{said:?}");
    said
}

/// The second folder has the texts of the first with CR LF; those that the command has made of nothing may have LF.
fn assert_texts_differ_in_line_ends_alone(folders: &[TempDir; 2], made: &[&str]) {
    let [lf, cr_lf] = [0, 1].map(|at| texts(folders[at].path()));
    assert_eq!(
        lf.keys().collect::<Vec<_>>(),
        cr_lf.keys().collect::<Vec<_>>()
    );
    for (name, text) in &lf {
        let is_made = made.iter().any(|it| name.ends_with(it));
        if !(is_made && cr_lf[name] == *text) {
            assert_eq!(cr_lf[name], with_cr_lf(text), "{name}");
        }
    }
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[test]
fn a_study_with_cr_lf_is_run_as_one_with_lf() {
    let folders = both(template);
    called(&folders, &["-q", "run", "s"]);
    let results = [0, 1].map(|at| {
        let text = read(&folders[at].path().join("s/results/study.json"));
        serde_json::from_str::<Value>(&text).expect("JSON")
    });
    for of in ["conclusions", "comparisons"] {
        assert_eq!(results[0][of], results[1][of], "{of}");
    }
    let findings = |at: usize| -> Vec<&Value> {
        let pieces = results[at]["evidence"].as_array().expect("evidence").iter();
        pieces.map(|it| &it["findings"]).collect()
    };
    let values = |at: usize| {
        let findings = findings(at)
            .into_iter()
            .flat_map(|it| it.as_array().expect("findings"));
        let value = |it: &Value| {
            [
                it["measure"]["count"].clone(),
                it["measure"]["answer"]["value"].clone(),
            ]
        };
        findings.map(value).collect::<Vec<_>>()
    };
    assert_eq!(values(0), values(1));
    let verified = called(&folders, &["verify", "s/results", "s"]);
    assert_eq!(verified[1].code, 0, "{verified:?}");
    assert_texts_differ_in_line_ends_alone(&folders, &["looks.toml"]);
}

#[test]
fn requirements_that_are_imported_keep_the_line_ends_of_the_study() {
    let folders = both(template);
    called(&folders, &["requirements", "export", "s", "r.csv"]);
    for folder in &folders {
        let file = folder.path().join("r.csv");
        let text = read(&file).replacen("At least 90%", "\"At least 90%\nat \"\"once\"\"", 1);
        // The rest of that field, up to the next one.
        let text = text.replacen("attempts shall succeed.", "attempts shall succeed.\"", 1);
        let added = "NEW,\"Two\nlines.\",Since,open,1\n";
        std::fs::write(&file, format!("{text}{added}")).expect("written");
    }
    let import = ["requirements", "import", "s", "r.csv", "--format", "json"];
    let said = called(&folders, &import);
    let reports = [json(&said[0]), json(&said[1])];
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[1]["added"][0], "NEW", "{said:?}");
    assert_eq!(
        reports[1]["changed"].as_array().map(Vec::len),
        Some(1),
        "{said:?}"
    );
    assert_texts_differ_in_line_ends_alone(&folders, &["requirements-sync.toml", "r.csv"]);
    // The texts are the same on both sides now, and a field can be set that was not there.
    for again in called(&folders, &import) {
        assert_eq!(json(&again)["written"], serde_json::json!([]), "{again:?}");
    }
    for folder in &folders {
        let file = folder.path().join("r.csv");
        let text = read(&file).replacen(",Since,open,1", ",Since,closed,1", 1);
        std::fs::write(&file, text.replacen(",,,", ",Why,,", 1)).expect("written");
    }
    called(&folders, &import);
    assert_texts_differ_in_line_ends_alone(&folders, &["requirements-sync.toml", "r.csv"]);
}

#[test]
fn mistakes_have_the_same_place() {
    let folders = both(|folder| {
        template(folder);
        for (file, old, new) in [
            (
                "model.prism",
                "endmodule",
                "  [] nothing=0 -> true;\nendmodule",
            ),
            ("requirements.toml", "margin = 0.10", "margin = 10"),
            (
                "vocabulary.toml",
                "model = \"robot=docked\"",
                "modell = \"robot=docked\"",
            ),
        ] {
            let path = folder.join("s").join(file);
            let text = read(&path);
            assert!(text.contains(old), "{file}");
            std::fs::write(&path, text.replacen(old, new, 1)).expect("written");
        }
    });
    for arguments in [
        &["plan", "s"][..],
        &["check", "s/model.prism", "P=? [ F x=1 ]"],
        &["requirements", "s"],
    ] {
        let said = called(&folders, arguments);
        assert_eq!(said[0].talk, said[1].talk, "{arguments:?}");
        assert!(!said[1].talk.is_empty() && !said[1].talk.contains('\r'));
    }
}

/// A new model beside the old one with a new entry of the ledger, and tables that are changed in their places.
#[test]
fn what_refine_changes_keeps_the_line_ends() {
    let replaced = |folder: &Path, file: &str, old: &str, new: &str| {
        let path = folder.join(file);
        let text = read(&path);
        assert!(text.contains(old), "{file}");
        std::fs::write(&path, text.replacen(old, new, 1)).expect("written");
    };
    let folders = both(|folder| {
        template(folder);
        replaced(
            folder,
            "s/model.prism",
            "pTouches = 0.95",
            "pTouches = 0.70",
        );
    });
    let offered = called(&folders, &["refine", "s", "--format", "json"]);
    assert_eq!(
        json(&offered[0])["proposals"],
        json(&offered[1])["proposals"]
    );
    let said = called(&folders, &["refine", "s", "--all", "--format", "json"]);
    let applied = [json(&said[0]), json(&said[1])];
    assert_eq!(applied[0]["applied"], applied[1]["applied"]);
    assert_texts_differ_in_line_ends_alone(&folders, &["looks.toml"]);
    let ledger = read(&folders[1].path().join("s/ledger.toml"));
    assert!(ledger.contains("\r\nid = \"E1-r1\"\r\n"), "{ledger}");

    let folders = both(|folder| {
        copy_study(&root().join("crates/cli/tests/data/two_failures"), folder);
        replaced(
            folder,
            "experiments/failures.csv",
            "slip,2,100\ndrop,25,100",
            "slip,25,100\ndrop,2,100",
        );
        replaced(
            folder,
            "experiments/trials.csv",
            "n_slip,n_drop",
            "n_drop,n_slip",
        );
    });
    called(&folders, &["run", ".", "--quiet"]);
    called(&folders, &["diagnose", ".", "--paths", "100", "--quiet"]);
    let before = texts(folders[1].path());
    let said = called(
        &folders,
        &["refine", ".", "--accept", "1", "--format", "json"],
    );
    assert_eq!(json(&said[0])["applied"], json(&said[1])["applied"]);
    assert_ne!(texts(folders[1].path()), before);
    assert_texts_differ_in_line_ends_alone(&folders, &["looks.toml"]);
}
