//! `init`: every template runs as its README says; drafts of robots and recordings run; what cannot be drafted leaves nothing.

use crate::support::program::{Said, command, corroborate, said};
use crate::support::simulation::library;
use crate::support::{files_below, read};
use std::path::Path;
use tempfile::TempDir;

fn place() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

/// As an installed program runs: with a physics library, and without the repository's client.
fn installed(library: &Path, folder: &Path, arguments: &[&str]) -> Said {
    let mut command = command(folder, arguments);
    command
        .env("CORROBORATE_MUJOCO", library)
        .env_remove("CORROBORATE_CLIENTS");
    said(&mut command)
}

/// Makes a study of a template, runs it, and looks into it.
fn template(name: &str, code: i32, simulates: bool) {
    let library = match simulates {
        true => library(),
        false => Some("".into()),
    };
    let Some(library) = library else { return };
    let place = place();
    let made = corroborate(place.path(), &["init", "study", "--template", name]);
    assert_eq!(made.code, 0, "{made:?}");
    let folder = place.path().join("study");
    for file in files_below(&folder) {
        if file.extension().is_some_and(|ending| ending == "toml") {
            let text = read(&file);
            assert!(text.contains("# "), "{} has no comment", file.display());
            let schema = text
                .lines()
                .next()
                .and_then(|line| line.strip_prefix("#:schema "));
            if let Some(schema) = schema {
                let beside = file.parent().expect("a folder").join(schema);
                assert!(beside.is_file(), "{}: no {schema}", file.display());
            }
        }
    }
    let run = installed(&library, place.path(), &["run", "study"]);
    assert_eq!(run.code, code, "{run:?}");
    assert!(!run.talk.contains("warning"), "{}", run.talk);
    assert!(
        !run.talk.contains("not simulated as described"),
        "{}",
        run.talk
    );
    let readme = folder.join("README.md");
    if readme.is_file() {
        assert!(
            read(&readme).contains(&format!("ends with code {code}")),
            "{name}"
        );
    }
    let inspected = installed(&library, place.path(), &["inspect", "study"]);
    assert_eq!(
        (inspected.code, inspected.talk.as_str()),
        (0, ""),
        "{inspected:?}"
    );
}

#[test]
fn the_template_docking_runs() {
    template("docking", 0, false);
}

#[test]
fn the_template_formal_runs() {
    template("formal", 0, false);
}

#[test]
fn the_template_recordings_runs() {
    template("recordings", 1, false);
}

#[test]
fn the_template_command_runs() {
    template("command", 1, false);
}

#[test]
fn the_template_policy_runs() {
    template("policy", 1, false);
}

#[test]
fn the_template_cobot_runs() {
    template("cobot", 1, true);
}

#[test]
fn the_template_mobile_runs() {
    template("mobile", 1, true);
}

#[test]
fn the_template_gripper_runs() {
    template("gripper", 0, true);
}

#[test]
fn help_lists_every_template_as_the_library_has_it() {
    let place = place();
    let help = corroborate(place.path(), &["init", "--help"]).out;
    for template in corroborate::Template::ALL {
        let line = help
            .lines()
            .find(|line| line.trim_start().starts_with(template.name()));
        let line = line.unwrap_or_else(|| panic!("{help}"));
        let (meaning, _) = template
            .meaning()
            .split_once(';')
            .unwrap_or((template.meaning(), ""));
        assert!(line.contains(meaning), "{line}");
    }
}

/// One message with this code and a remedy, and nothing made.
fn refused(place: &Path, arguments: &[&str], code: &str) -> String {
    let said = corroborate(place, &[&["init", "new"], arguments].concat());
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains(&format!("[{code}]")), "{}", said.talk);
    assert!(!place.join("new").exists(), "{}", said.talk);
    said.talk
}

#[test]
fn what_cannot_be_made_leaves_nothing() {
    let place = place();
    let said = refused(
        place.path(),
        &["--template", "mobil"],
        "unknown-study-template",
    );
    assert!(said.contains("did you mean `mobile`?"), "{said}");
    refused(place.path(), &["--from", "nowhere.urdf"], "cannot-read");
    refused(place.path(), &["--from", "nowhere.mcap"], "bad-recording");
    let write =
        |name: &str, text: &[u8]| std::fs::write(place.path().join(name), text).expect("written");
    write("empty.mcap", b"");
    refused(place.path(), &["--from", "empty.mcap"], "bad-recording");
    write("bad.urdf", b"<robot name=\"a\"><link name=\"b\"></robot>");
    refused(place.path(), &["--from", "bad.urdf"], "bad-description");
    write("still.csv", b"time_s,state,speed\n0,a,1\n1,b,1\n2,a,1\n");
    refused(place.path(), &["--from", "still.csv"], "nothing-to-draft");
    write("part.xml", b"<mujoco><default/></mujoco>");
    refused(place.path(), &["--from", "part.xml"], "description-refused");
    write("massless.urdf", MASSLESS.as_bytes());
    refused(
        place.path(),
        &["--from", "massless.urdf"],
        "description-refused",
    );
    let made = corroborate(place.path(), &["init", "old"]);
    assert_eq!(made.code, 0, "{made:?}");
    let again = corroborate(place.path(), &["init", "old", "--template", "formal"]);
    assert!(
        again.code == 2 && again.talk.contains("folder-not-empty"),
        "{again:?}"
    );
    let both = corroborate(
        place.path(),
        &["init", "new", "--template", "formal", "--from", "still.csv"],
    );
    assert_eq!(both.code, 2, "{both:?}");
}

/// A link that moves and has no mass: no simulation takes it.
const MASSLESS: &str = r#"<robot name="a">
  <link name="base"/>
  <link name="arm"/>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="arm"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"#;

/// An arm of one joint whose names would end strings, lines and tables.
const HOSTILE: &str = r#"<robot name="x&quot;]&#10;[a">
  <link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="up&quot;&#10;[[robot]] @END@ '''">
    <inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision>
  </link>
  <joint name="turn &quot; it&#10;" type="revolute">
    <parent link="base"/><child link="up&quot;&#10;[[robot]] @END@ '''"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="20" velocity="1"/>
  </joint>
</robot>"#;

#[test]
fn a_robot_with_hostile_names_is_drafted_and_runs() {
    let Some(library) = library() else { return };
    let place = place();
    let name = "arm \"new\n[x].urdf";
    std::fs::write(place.path().join(name), HOSTILE).expect("written");
    let made = corroborate(place.path(), &["init", "study", "--from", name]);
    assert_eq!(made.code, 0, "{made:?}");
    let run = installed(&library, place.path(), &["run", "study"]);
    assert!(matches!(run.code, 0 | 1 | 3), "{run:?}");
}

#[test]
fn a_robot_is_drafted_with_its_limits_and_runs() {
    let Some(library) = library() else { return };
    let place = place();
    let robot =
        crate::support::root().join("crates/corroborate/templates/cobot/simulation/arm.urdf");
    let robot = robot.to_str().expect("text");
    let made = corroborate(place.path(), &["init", "study", "--from", robot]);
    assert_eq!(made.code, 0, "{made:?}");
    assert!(made.out.contains("stay where they are"), "{}", made.out);
    let scene = read(&place.path().join("study/simulation/scene.toml"));
    // The efforts of the description; an arm whose joints all have limits is fixed.
    for line in [
        "limit = 60",
        "limit = 80",
        "limit = 40",
        "fixed = true",
        "joints = [\"turn\", \"lift\", \"elbow\"]",
    ] {
        assert!(scene.contains(line), "{line}: {scene}");
    }
    let parameters = read(&place.path().join("study/parameters.toml"));
    // 2.0 rad/s at 0.4 m from the vertical axis, and 2.0 rad/s at 0.4 m from the shoulder's; the elbow's is at the end itself.
    assert!(parameters.contains("value = \"1.6 m/s\""), "{parameters}");
    let run = installed(&library, place.path(), &["run", "study"]);
    assert_eq!(run.code, 3, "{run:?}");
    let inspected = installed(&library, place.path(), &["inspect", "study"]);
    assert_eq!(
        (inspected.code, inspected.talk.as_str()),
        (0, ""),
        "{inspected:?}"
    );
}

#[test]
fn a_recording_is_drafted_and_decides_nothing() {
    let place = place();
    let rows: String = (0..50)
        .map(|at| format!("{},{},go\n", 20 * at, at as f64 / 40.0))
        .collect();
    let name = "run \"a\"\n.csv";
    std::fs::write(
        place.path().join(name),
        format!("time_ms,speed \"[\"],mode\n{rows}"),
    )
    .expect("written");
    let made = corroborate(place.path(), &["init", "study", "--from", name]);
    assert_eq!(made.code, 0, "{made:?}");
    let parameters = read(&place.path().join("study/parameters.toml"));
    assert!(
        parameters.contains("Seen in the recording: 0 to 1.23"),
        "{parameters}"
    );
    let ledger = read(&place.path().join("study/ledger.toml"));
    assert!(ledger.contains("intermediate = true"), "{ledger}");
    let run = corroborate(place.path(), &["run", "study"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(!run.out.contains("Satisfied"), "{}", run.out);
    let judged = corroborate(place.path(), &["monitor", "study", "study/recordings"]);
    assert_eq!(judged.code, 0, "{judged:?}");
}
