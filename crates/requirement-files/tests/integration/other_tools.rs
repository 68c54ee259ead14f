//! Files that are written here, read by the tools whose formats they have.

use crate::support::item;
use requirement_files::{Change, Document, Format};
use std::process::Command;

/// Needs Python with the packages `reqif`, `strictdoc` and `doorstop` (`CORROBORATE_PYTHON` names it); without them it says so.
#[test]
#[ignore = "asks other tools: pip install reqif strictdoc doorstop"]
fn other_tools_read_what_is_written() {
    let python = std::env::var("CORROBORATE_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/read.py");
    let folder = std::env::temp_dir().join(format!("requirement-files-{}", std::process::id()));
    let items = [
        item("REQ001", "The arm shall stop.\n\nAt <once> & \"now\".", &[]),
        item("REQ002", "It's slow: # near", &["REQ001"]),
    ];
    for (format, name) in [
        (Format::ReqIf, "a.reqif"),
        (Format::ReqIfArchive, "b.reqifz"),
        (Format::StrictDoc, "c.sdoc"),
        (Format::Doorstop, "doorstop"),
        (Format::Csv, "d.csv"),
    ] {
        let document = Document::empty(format, name, "Arm", "REQ001").expect("empty");
        let changes: Vec<Change> = items.iter().cloned().map(Change::Add).collect();
        for file in document.with(&changes).expect("written") {
            let path = match format {
                Format::Doorstop => folder.join(name).join(&file.name),
                _ => folder.join(&file.name),
            };
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, file.bytes).expect("written");
        }
    }
    let ran = Command::new(python)
        .arg(script)
        .arg(&folder)
        .output()
        .expect("Python");
    std::fs::remove_dir_all(&folder).expect("removed");
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    println!("{said}");
    assert!(
        ran.status.success(),
        "{said}\n{}",
        String::from_utf8_lossy(&ran.stderr)
    );
}
