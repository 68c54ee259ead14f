//! Our reader of SQLite against the SQLite library, on random databases that the library wrote.

use std::path::Path;
use std::process::Command;

use recording::{OpenOptions, open};

/// Databases that are compared.
const DATABASES: usize = 200;

#[test]
#[ignore = "needs python3, whose standard library has SQLite"]
fn random_databases_are_read_as_the_library_reads_them() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/random_databases.py");
    let status = Command::new("python3")
        .arg(script)
        .arg(folder.path())
        .args([&DATABASES.to_string(), "1"])
        .status()
        .unwrap();
    assert!(status.success());
    let mut messages = 0;
    for number in 0..DATABASES {
        let path = folder.path().join(format!("{number}.db3"));
        let expected = std::fs::read_to_string(path.with_extension("txt")).unwrap();
        let mut reader = open(&path, &OpenOptions::default()).unwrap();
        let names: Vec<String> = reader
            .topics()
            .iter()
            .map(|topic| topic.name.clone())
            .collect();
        let mut found = String::new();
        while let Some(message) = reader.next().unwrap() {
            let hex: String = message
                .data
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect();
            let name = &names[message.topic.index()];
            found.push_str(&format!("{name} {} {hex}\n", message.log_nanos));
            messages += 1;
        }
        assert!(found == expected, "database {number} is read differently");
        assert!(
            reader.complete(),
            "database {number}: {:?}",
            reader.losses()
        );
    }
    assert!(messages > 10_000, "only {messages} messages were compared");
}
