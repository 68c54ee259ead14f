//! A study from its folder to verdicts that are checked: planned, run, read, compared, verified.
//!
//! `cargo run -p corroborate --example first_study`

use corroborate::host::Event;
use corroborate::{CompareRequest, Events, Host, RunRequest, VerifyRequest};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let study = folder.path().join("docking");
    corroborate::new_study(&study)?;

    let host = Host {
        events: Events::new(|event| match event {
            Event::Note { text } => println!("  {text}"),
            Event::Started { title, total, .. } => println!("  {title}, at most {total} steps"),
            _ => {}
        }),
        ..Host::silent(corroborate::build())
    };
    let request = RunRequest::new(&study);
    for planned in corroborate::plan(&request, &host)?.evidence {
        println!(
            "{} ({}): {:?}",
            planned.id, planned.title, planned.freshness
        );
    }
    let result = corroborate::run(&request, &host)?.into_study()?;
    for conclusion in &result.conclusions {
        println!(
            "Requirement {}: {}",
            conclusion.requirement,
            conclusion.verdict.words()
        );
    }
    // What an earlier run kept is fresh until a file, a setting or the engine changes.
    assert!(corroborate::plan(&request, &host)?.is_fresh());

    for pair in corroborate::compare(&CompareRequest::new(&study))?.comparisons {
        println!(
            "{}: {} and {}: {}",
            pair.subject.id(),
            pair.left,
            pair.right,
            pair.reason
        );
    }
    let verified = corroborate::verify(&VerifyRequest::new(request.results()), &host, None)?;
    println!("{} faults", verified.faults.len());
    Ok(())
}
