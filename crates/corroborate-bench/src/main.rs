//! The benchmark as a command.
//!
//! `corroborate-bench [--small] [--seed NUMBER] [--without-case-studies] [--only FAMILY] [--to FOLDER]
//! [--misses]` prints the tables, and writes each as CSV to the folder; with `--misses`, to standard error a line for each
//! study whose fault was not found, not the first suspect, or not repaired.

use corroborate_bench::bench::{Line, Plan, run};
use corroborate_bench::family::Family;
use corroborate_bench::table::tables;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "usage: corroborate-bench [--small] [--seed NUMBER] [--without-case-studies] [--only FAMILY] [--to FOLDER] [--misses]";

fn seed(text: Option<String>) -> Result<u64, String> {
    let seed = text.and_then(|text| text.parse().ok());
    seed.ok_or_else(|| format!("`--seed` needs a whole number; {USAGE}"))
}

fn family(name: Option<String>) -> Result<Family, String> {
    let mut all = Family::ALL.into_iter();
    let found = all.find(|family| name.as_deref() == Some(family.name()));
    found.ok_or_else(|| format!("`--only` needs toy, serial, handover or corridor; {USAGE}"))
}

fn main() -> ExitCode {
    match benchmark() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn benchmark() -> Result<(), String> {
    let mut plan = Plan::FULL;
    let (mut folder, mut misses) = (None, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--small" => plan = Plan::SMALL,
            "--seed" => plan.seed = seed(arguments.next())?,
            "--without-case-studies" => (plan.handover, plan.corridor) = (0, 0),
            "--only" => plan.only = Some(family(arguments.next())?),
            "--misses" => misses = true,
            "--to" => folder = Some(arguments.next().ok_or(USAGE)?),
            other => return Err(format!("unknown argument `{other}`; {USAGE}")),
        }
    }
    // Tried before the work, which would be lost for want of a folder.
    if let Some(folder) = &folder {
        let path = Path::new(folder).join("targets.csv");
        trace::write_file(&path, b"").map_err(|error| error.to_string())?;
    }
    // Talk goes to standard error: a line for each study of a case study, whose models take long, else for each tenth.
    let lines = run(&plan, &|done, all| {
        if all < 200 || done % (all / 10) == 0 || done == all {
            eprintln!("{done} of {all} studies");
        }
    })?;
    for missed in lines.iter().filter(|_| misses).filter_map(Line::missed) {
        eprintln!("{missed}");
    }
    let mut page = format!("{} studies, seed {}.\n", lines.len(), plan.seed);
    for table in tables(&lines) {
        page.push_str(&format!("\n{}", table.markdown()));
        if let Some(folder) = &folder {
            let path = Path::new(folder).join(format!("{}.csv", table.name));
            trace::write_file(&path, table.csv().as_bytes()).map_err(|error| error.to_string())?;
        }
    }
    println!("{page}");
    Ok(())
}
