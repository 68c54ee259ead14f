//! Studies that name what is not theirs: files elsewhere, by paths, links, addresses and records; pipes and devices; links through
//! which results would be written. Each is refused with its place, nothing of what it names is printed, and nothing outside of the
//! study is written.
//!
//! `NAMED` was drawn up before there was a check; `FOUND` are cases that were thought of while it was made.

use crate::support;

use std::os::unix::fs::symlink;
use std::path::PathBuf;
use support::program::{Said, Study, command, contents, said};

/// What must not be printed: the content of files elsewhere, in a form that no reader takes.
const SECRET: &str = "TOPSECRET {[( = ,";

/// A study and what it must not reach, beside each other.
struct Hostile(Study);

impl Hostile {
    fn new(template: &str) -> Self {
        let study = Self(Study::of_template(template));
        let secrets = study.0.beside().join("elsewhere");
        std::fs::create_dir_all(&secrets).expect("made");
        for name in [
            "secret",
            "secret.csv",
            "secret.toml",
            "secret.xml",
            "secret.sdf",
            "scene.toml",
        ] {
            std::fs::write(secrets.join(name), format!("{SECRET}\n{SECRET}\n")).expect("written");
        }
        study
    }

    fn edit(self, file: &str, old: &str, new: &str) -> Self {
        self.0.edit(file, old, new);
        self
    }

    fn write(self, file: &str, text: &str) -> Self {
        self.0.write(file, text);
        self
    }

    /// In place of a file or folder of the study stands a link.
    fn link(self, file: &str, to: &str) -> Self {
        let path = self.0.path(file);
        let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        symlink(to, path).expect("linked");
        self
    }

    fn pipe(self, file: &str) -> Self {
        let path = self.0.path(file);
        let _ = std::fs::remove_file(&path);
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.expect("mkfifo").success());
        self
    }

    fn call(&self, arguments: &[&str]) -> Said {
        let mut call = command(self.0.beside(), arguments);
        said(
            call.env("CORROBORATE_TRUST", "")
                .env("XDG_STATE_HOME", self.state()),
        )
    }

    fn state(&self) -> PathBuf {
        self.0.beside().join("state")
    }

    fn elsewhere(&self) -> std::collections::BTreeMap<PathBuf, Vec<u8>> {
        contents(&self.0.beside().join("elsewhere"))
    }

    /// Fails if it is not refused as it should be; says what is wrong.
    fn fault(&self, arguments: &[&str], place: &str) -> Option<String> {
        let before = self.elsewhere();
        let said = self.call(arguments);
        let text = format!("{}{}", said.out, said.talk);
        let wrong = [
            (said.code != 2, "the exit code is not 2"),
            (
                !text.contains("error[outside-study]"),
                "it is not refused as outside",
            ),
            (!text.contains(place), "the place is missing"),
            (!text.contains("--allow"), "there is no remedy"),
            (text.contains("TOPSECRET"), "what it names is printed"),
            (self.elsewhere() != before, "something outside is written"),
        ];
        let wrong: Vec<&str> = wrong.iter().filter(|it| it.0).map(|it| it.1).collect();
        (!wrong.is_empty()).then(|| format!("{arguments:?}: {wrong:?}\n{said:?}"))
    }
}

/// A case: what it is, the study, the call, and what of the place has to be told.
type Case = (
    &'static str,
    fn() -> Hostile,
    &'static [&'static str],
    &'static str,
);

const RUN: &[&str] = &["run", "study"];
const INSPECT: &[&str] = &["inspect", "study", "--trust"];
const MODEL: &str = "model = \"model.prism\"";
const LEDGER: &str = "ledger.toml:";
const SCENE: &str = "simulation/scene.toml:";
const URDF: &str = "simulation/carrier.urdf";
const ROBOT: &str = "file = \"carrier.urdf\"";
const BODY: &str = "<geometry><cylinder radius=\"0.25\" length=\"0.26\"/></geometry>";

fn docking(old: &str, new: &str) -> Hostile {
    Hostile::new("docking").edit("ledger.toml", old, new)
}

fn robot(file: &str, text: &str) -> Hostile {
    let named = format!("file = \"{file}\"");
    Hostile::new("mobile")
        .edit("simulation/scene.toml", ROBOT, &named)
        .write(&format!("simulation/{file}"), text)
}

fn mesh(address: &str) -> Hostile {
    let shape = format!("<geometry><mesh filename=\"{address}\"/></geometry>");
    Hostile::new("mobile").edit(URDF, BODY, &shape)
}

#[rustfmt::skip]
const NAMED: &[Case] = &[
    ("an absolute path", || docking(MODEL, "model = \"/etc/passwd\""), RUN, LEDGER),
    ("a path that leads up", || docking(MODEL, "model = \"../elsewhere/secret\""), RUN, LEDGER),
    ("a long chain of ..", || docking(MODEL, "model = \"../../../../../../../../../../etc/passwd\""), RUN, LEDGER),
    ("up and down again", || docking(MODEL, "model = \"x/../../elsewhere/secret\""), RUN, LEDGER),
    ("a model that is a link", || docking("", "").link("model.prism", "../elsewhere/secret"), RUN, LEDGER),
    ("a folder that is a link", || docking(MODEL, "model = \"models/secret\"").link("models", "../elsewhere"), RUN, LEDGER),
    ("a model that is a pipe", || docking("", "").pipe("model.prism"), RUN, LEDGER),
    ("a table in /proc", || docking("\"attempts.csv\"", "\"/proc/self/environ\""), RUN, LEDGER),
    ("a table by a link into /proc", || docking("", "").link("attempts.csv", "/proc/self/environ"), RUN, LEDGER),
    ("a table that is a device", || docking("\"attempts.csv\"", "\"/dev/zero\""), RUN, LEDGER),
    ("a table of failure modes", || docking("\"failure_modes.csv\"", "\"../elsewhere/secret.csv\""), RUN, LEDGER),
    ("a table of requirements", || docking("\"requirements.csv\"", "\"../elsewhere/secret.csv\""), RUN, LEDGER),
    ("a fault tree", || docking("technique = \"model-checking\"\nconditions = \"typical\"\nmodel = \"model.prism\"", "technique = \"fault-tree\"\nconditions = \"typical\"\ntree = \"../elsewhere/secret.xml\"\nevents = { \"1\" = \"top\" }"), RUN, LEDGER),
    ("a folder of JUnit XML", || docking("tables.cohort = \"attempts.csv\"", "tables.junit = \"../elsewhere\""), RUN, LEDGER),
    ("recordings elsewhere", || Hostile::new("recordings").edit("ledger.toml", "recordings = \"recordings\"", "recordings = \"../elsewhere\""), RUN, LEDGER),
    ("a folder of recordings that is a link", || Hostile::new("recordings").link("recordings", "../elsewhere"), RUN, LEDGER),
    ("a recording that is a link", || Hostile::new("recordings").link("recordings/2024-05-13_shift2.csv", "../../elsewhere/secret.csv"), RUN, "2024-05-13"),
    ("requirements that are a link", || docking("", "").link("requirements.toml", "../elsewhere/secret.toml"), RUN, "requirements.toml"),
    ("a vocabulary that is a link", || docking("", "").link("vocabulary.toml", "../elsewhere/secret.toml"), RUN, "vocabulary.toml"),
    ("parameters that are a link", || docking("", "").link("parameters.toml", "../elsewhere/secret.toml"), RUN, "parameters.toml"),
    ("a ledger that is a link", || docking("", "").link("ledger.toml", "../elsewhere/secret.toml"), RUN, "ledger.toml"),
    ("study.toml that is a link", || docking("", "").link("study.toml", "../elsewhere/secret.toml"), RUN, "study.toml"),
    ("a topic map that is a link", || Hostile::new("recordings").link("topics.toml", "../elsewhere/secret.toml"), RUN, "topics.toml"),
    ("a scene elsewhere", || Hostile::new("mobile").edit("ledger.toml", "simulation/scene.toml", "../elsewhere/scene.toml"), RUN, LEDGER),
    ("a scene that is a link", || Hostile::new("mobile").link("simulation/scene.toml", "../../elsewhere/scene.toml"), RUN, LEDGER),
    ("a robot elsewhere", || Hostile::new("mobile").edit("simulation/scene.toml", ROBOT, "file = \"../../elsewhere/secret.xml\""), INSPECT, SCENE),
    ("a robot at an absolute path", || Hostile::new("mobile").edit("simulation/scene.toml", ROBOT, "file = \"/etc/passwd\""), INSPECT, SCENE),
    ("a robot by an address", || Hostile::new("mobile").edit("simulation/scene.toml", ROBOT, "file = \"file:///etc/passwd\""), INSPECT, SCENE),
    ("a mesh by an address", || mesh("file:///etc/passwd"), INSPECT, SCENE),
    ("a mesh that leads up", || mesh("../../elsewhere/secret"), INSPECT, SCENE),
    ("an include of xacro", || robot("a.urdf.xacro", "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include filename=\"../../elsewhere/secret.xml\"/><link name=\"base\"/></robot>"), INSPECT, SCENE),
    ("YAML of xacro", || robot("a.urdf.xacro", "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:property name=\"p\" value=\"${xacro.load_yaml('../../elsewhere/secret.toml')}\"/><link name=\"${p}\"/></robot>"), INSPECT, SCENE),
    ("an include of MJCF", || robot("a.xml", "<mujoco model=\"r\"><include file=\"../../elsewhere/secret.xml\"/><worldbody><body name=\"base\"><geom type=\"box\" size=\"1 1 1\"/></body></worldbody></mujoco>"), INSPECT, SCENE),
    ("an include of SDF", || robot("a.sdf", "<sdf version=\"1.9\"><model name=\"r\"><include><uri>../../elsewhere/secret.sdf</uri></include><link name=\"base\"/></model></sdf>"), INSPECT, SCENE),
    ("a stimulus elsewhere", || Hostile::new("command").edit("ledger.toml", "stimulus = \"stimulus.toml\"", "stimulus = \"../elsewhere/secret.toml\""), RUN, LEDGER),
    ("a file of a command elsewhere", || Hostile::new("policy").edit("ledger.toml", "\"weights.json\"", "\"../elsewhere/secret\""), RUN, LEDGER),
    ("results that are a link", || docking("", "").link("results", "../elsewhere"), RUN, "results"),
    ("evidence that is a link", || docking("", "").link("results/evidence", "../../elsewhere"), RUN, "results/evidence"),
    ("a lock that is a link", || docking("", "").link("results/.lock", "../../elsewhere/made"), RUN, "results/.lock"),
    ("a page that is a link", || docking("", "").link("results/report.html", "../../elsewhere/secret"), RUN, "results/report.html"),
];

#[rustfmt::skip]
const FOUND: &[Case] = &[
    ("a link to a link", || docking("", "").link("near", "../elsewhere/secret").link("model.prism", "near"), RUN, LEDGER),
    ("a table that is a socket's folder", || docking("\"attempts.csv\"", "\"/proc/self/fd/0\""), RUN, LEDGER),
    ("a JUnit file that is a link", || docking("tables.cohort = \"attempts.csv\"", "tables.junit = \"junit\"").link("junit/a.xml", "../../elsewhere/secret.xml"), RUN, "junit/a.xml"),
    ("what is not there, elsewhere", || docking(MODEL, "model = \"../elsewhere/not-there\""), RUN, LEDGER),
    ("a variant that is a link", || Hostile::new("docking").link("variants/a.toml", "../../elsewhere/secret.toml"), &["what-if", "study"], "variants/a.toml"),
    ("a regression that is a link", || Hostile::new("docking").link("regressions/a.toml", "../../elsewhere/secret.toml"), &["replay", "study", "--check"], "regressions/a.toml"),
    ("a deep link in results", || docking("", "").link("results/episodes/E1/a.mcap", "../../../../elsewhere/secret"), RUN, "a.mcap"),
    ("a link in results to what is not there", || docking("", "").link("results/page", "../../elsewhere/made"), RUN, "results/page"),
    ("a finding of a scene elsewhere", || Hostile::new("mobile").write("regressions/a.toml", FINDING), &["replay", "study", "a.toml", "--trust"], "elsewhere"),
    ("a package up there", || mesh("package://elsewhere/secret").edit("simulation/scene.toml", ROBOT, "file = \"../../study/simulation/carrier.urdf\""), INSPECT, SCENE),
    ("requirements asked for alone", || docking("", "").link("requirements.toml", "../elsewhere/secret.toml"), &["requirements", "study"], "requirements.toml"),
    ("a vocabulary for a monitor", || Hostile::new("recordings").link("vocabulary.toml", "../elsewhere/secret.toml"), &["monitor", "study", "study/recordings"], "vocabulary.toml"),
    ("a plan without a run", || docking(MODEL, "model = \"/etc/passwd\""), &["plan", "study"], LEDGER),
    ("a diagnosis", || docking(MODEL, "model = \"/etc/passwd\""), &["diagnose", "study"], LEDGER),
];

const FINDING: &str = "format = \"1.1\"\nfound_by = \"x\"\nprogram = \"0\"\nseed = \"1\"\nexpected = \"fails\"\n\
    [bench]\nevidence = \"none\"\nscene = \"../elsewhere/scene.toml\"\n[shows]\nviolated = \"M1\"\n\
    [test]\nname = \"t\"\nactions = []\n";

fn faults(cases: &[Case]) -> Vec<String> {
    let fault = |(what, make, call, place): &Case| {
        let fault = make().fault(call, place)?;
        Some(format!("{what}: {fault}"))
    };
    cases.iter().filter_map(fault).collect()
}

#[test]
fn a_study_reaches_no_further_than_its_folder() {
    let mut all = Vec::new();
    for (cases, least) in [(NAMED, 40), (FOUND, 14)] {
        assert!(cases.len() >= least, "{}", cases.len());
        let faults = faults(cases);
        let refused = cases.len() - faults.len();
        eprintln!("{refused} of {} are refused", cases.len());
        all.extend(faults);
    }
    assert!(
        all.is_empty(),
        "{} faults:\n{}",
        all.len(),
        all.join("\n\n")
    );
}

#[test]
fn the_templates_need_nothing_elsewhere() {
    for template in ["docking", "formal", "recordings", "command", "policy"] {
        let study = Hostile::new(template);
        let said = study.call(&["run", "study", "--trust"]);
        assert_ne!(said.code, 2, "{template}: {said:?}");
    }
}

#[test]
fn folders_that_the_user_names_are_read() {
    let study = docking(MODEL, "model = \"../shared/model.prism\"");
    let shared = study.0.beside().join("shared");
    std::fs::create_dir_all(&shared).expect("made");
    std::fs::rename(study.0.path("model.prism"), shared.join("model.prism")).expect("moved");
    let refused = study.fault(RUN, LEDGER);
    assert_eq!(refused, None);
    for call in [
        &["run", "study", "--allow", "shared"][..],
        &["plan", "study", "--allow", "elsewhere", "--allow", "shared"],
        &["requirements", "study", "--allow", "shared"],
        &["diagnose", "study", "--allow", "shared"],
        &["verify", "study/results", "--allow", "shared"],
    ] {
        let said = study.call(call);
        assert_ne!(said.code, 2, "{call:?}: {said:?}");
    }
    // What programs of a study may read, the study may, too.
    let mut call = command(study.0.beside(), RUN);
    let said = said(call.env("CORROBORATE_TRUST", study.0.beside()));
    assert_ne!(said.code, 2, "{said:?}");
}

/// What a result names is the result's to say: an assessor's pack must not carry off what a stranger's result asks for.
#[test]
fn a_pack_carries_nothing_off_that_only_a_result_names() {
    let study = docking("", "");
    assert_ne!(study.call(RUN).code, 2);
    let result = study.0.path("results/study.json");
    let text = std::fs::read_to_string(&result).expect("read");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    value["evidence"][0]["assets"][0] = serde_json::json!(
        { "role": "data", "path": "../elsewhere/secret", "hash": "0".repeat(64) }
    );
    std::fs::write(&result, value.to_string()).expect("written");
    let said = study.call(&["pack", "study", "--to", "pack.zip"]);
    assert_ne!(said.code, 0, "{said:?}");
    assert!(!study.0.beside().join("pack.zip").exists(), "{said:?}");
}

/// A result that names a device: reading it would not end.
#[test]
fn a_result_that_names_a_device_ends() {
    let study = docking("", "");
    assert_ne!(study.call(RUN).code, 2);
    let result = study.0.path("results/study.json");
    let text = std::fs::read_to_string(&result).expect("read");
    let changed = text.replacen("\"path\": \"model.prism\"", "\"path\": \"/dev/zero\"", 1);
    assert_ne!(text, changed);
    std::fs::write(&result, changed).expect("written");
    for call in [
        &["compare", "study"][..],
        &["verify", "study/results"],
        &["report", "study"],
    ] {
        let said = study.call(call);
        assert_ne!(said.code, 0, "{call:?}: {said:?}");
    }
}
