//! A study that a test writes file by file, runs, and has diagnosed and refined.

use super::program::corroborate;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// Its folder, which goes away with it.
pub struct Planted(TempDir);

const STUDY: &str = r#"
title = "A model and counts"
summary = "One model, and trials that were counted by hand."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

/// The evidence M of a model, and T of counts.
pub const LEDGER: &str = r#"
[[evidence]]
id = "M"
title = "A model"
technique = "model-checking"
conditions = "typical"
model = "model.prism"
changed = "The first."
[[evidence]]
id = "T"
title = "Trials"
technique = "experiment"
conditions = "typical"
tables.requirements = "counts.csv"
changed = "Counted by hand."
"#;

impl Planted {
    /// A study without files.
    pub fn new() -> Self {
        Self(TempDir::new().expect("a folder"))
    }

    /// A study of `requirements.toml`, `vocabulary.toml`, `model.prism` and `counts.csv`, which has been run.
    pub fn of_model_and_counts(files: [&str; 4]) -> Self {
        let folder = Self::new();
        folder.write("study.toml", STUDY);
        folder.complete(files);
        folder
    }

    /// The beginning of such a study, whose model's steps take so many seconds.
    pub fn with_step(secs: f64) -> Self {
        let folder = Self::new();
        folder.write(
            "study.toml",
            &format!("{STUDY}[model]\nstep = \"{secs} s\"\n"),
        );
        folder
    }

    /// The other files of such a study, and its run.
    pub fn complete(&self, [requirements, vocabulary, model, counts]: [&str; 4]) {
        for (name, text) in [
            ("ledger.toml", LEDGER),
            ("requirements.toml", requirements),
            ("vocabulary.toml", vocabulary),
            ("model.prism", model),
            ("counts.csv", counts),
        ] {
            self.write(name, text);
        }
        self.run();
    }

    /// The line of the first suspect, which is the model, and the first offered diff; all other offers are left open.
    pub fn first_of_model(&self) -> (u64, String) {
        let diagnosis = self.json("diagnose");
        let asset = &diagnosis["suspects"][0]["asset"];
        assert_eq!(asset["file"], "model.prism", "{diagnosis}");
        let offered = self.json("refine");
        let proposals = offered["proposals"].as_array().expect("proposals");
        // A number that makes up for it says so.
        for other in proposals.iter().skip(1) {
            assert_eq!(other["needs_decision"], true, "{other}");
        }
        let diff = proposals[0]["diff"].as_str().unwrap_or_default();
        (asset["line"].as_u64().unwrap_or_default(), diff.to_owned())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, in a folder of the study if its name says one.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(path, text).expect("written");
    }

    /// The titles of what `refine` offers, in its order.
    pub fn titles(&self) -> Vec<String> {
        let offered = self.json("refine");
        let proposals = offered["proposals"].as_array().expect("proposals");
        let titles = proposals.iter().filter_map(|it| it["title"].as_str());
        titles.map(str::to_owned).collect()
    }

    /// Runs it: whatever it shows, it is a study.
    pub fn run(&self) {
        let said = corroborate(self.path(), &["run", ".", "--quiet"]);
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }

    /// What is kept of a piece of evidence on each subject.
    pub fn findings(&self, evidence: &str) -> Vec<Value> {
        let path = format!("results/evidence/{evidence}.json");
        let kept = super::read(&self.path().join(path));
        let kept: Value = serde_json::from_str(&kept).expect("JSON");
        let findings = kept["content"]["findings"].as_array();
        findings.expect("findings").clone()
    }

    /// What a command says of it as JSON.
    pub fn json(&self, command: &str) -> Value {
        let said = corroborate(self.path(), &[command, ".", "--format", "json", "--quiet"]);
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
    }
}
