//! A study with a simulator of its own: opened, run with progress, explored in ten episodes, and one of them replayed. Needs
//! `python3`, in which the simulator is written.
//!
//! `cargo run -p corroborate --example explore_and_replay`

use corroborate::host::Event;
use corroborate::{Events, ExploreRequest, Host, ReplayRequest, RunRequest, Study};
use std::path::Path;

/// Which bench is explored, where its tests come from, and what varies.
const EXPLORATION: &str = r#"
evidence = "sim"
sources = ["own"]
designs = ["boundary", "random"]

[[parameter]]
name = "speed"
sets = ["cart.speed_cm_per_s"]
uniform = [100.0, 200.0]
nominal = 150.0
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let cart = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/command");
    for entry in std::fs::read_dir(cart)? {
        let entry = entry?;
        std::fs::copy(entry.path(), folder.join(entry.file_name()))?;
    }
    std::fs::write(folder.join("exploration.toml"), EXPLORATION)?;
    let study = Study::load(folder)?;
    println!("{}: {:?}", study.about.title, study.requirements[0].text);

    let host = Host {
        events: Events::new(|event| match event {
            Event::Started { title, total, .. } => println!("  {title}, at most {total} steps"),
            Event::Advanced { done, .. } if done % 10 == 0 => println!("  {done} done"),
            _ => {}
        }),
        // Its simulator is a program that the study names, and here one of our own.
        trust: corroborate::host::Trust {
            is_given: true,
            ..Default::default()
        },
        ..Host::silent(corroborate::build())
    };
    let result = corroborate::run(&RunRequest::new(folder), &host)?.into_study()?;
    for conclusion in &result.conclusions {
        let verdict = conclusion.verdict.words();
        println!("Requirement {}: {verdict}", conclusion.requirement);
    }

    let request = ExploreRequest::new(folder, "exploration.toml").episodes(10);
    let explored = corroborate::explore(&request, &host)?.found;
    for finding in &explored.findings {
        let found = &finding.found;
        println!("{}: in {} episodes", found.in_words, found.episodes);
    }
    // What is replayed: the first finding, or the first episode of the evidence.
    let found = explored.findings.first().map(|it| it.found.file.clone());
    let file = found.map(|file| folder.join("results/exploration").join(file));
    let episode = file.map_or_else(|| "sim:1".to_owned(), |file| file.display().to_string());
    let replayed = corroborate::replay(&ReplayRequest::new(folder, episode), &host)?;
    for verdict in &replayed.verdicts {
        println!(
            "{}: {} {:?}",
            verdict.subject, verdict.verdict, verdict.reasons
        );
    }
    println!("the same bytes: {:?}", replayed.same_bytes);
    Ok(())
}
