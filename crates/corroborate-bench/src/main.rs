//! The benchmark as a command.
//!
//! `corroborate-bench [--small] [--seed NUMBER] [--without-case-studies] [--only FAMILY] [--to FOLDER]
//! [--misses]` prints the tables of the families made by hand, and writes each as CSV to the folder; with `--misses`, to
//! standard error a line for each study whose fault was not found, not the first suspect, or not repaired.
//!
//! `corroborate-bench write --to FOLDER` writes studies of the grammar as folders that `corroborate run` takes, and
//! `answers.csv` beside them. `corroborate-bench judge --program PATH --to FOLDER` runs the program on such studies and
//! prints how it did, on tuned and on held-out families apart.

mod arguments;

use arguments::{Arguments, USAGE};
use corroborate_bench::bench::{Line, Plan, run};
use corroborate_bench::grammar::catalogue::Catalogue;
use corroborate_bench::grammar::{judge, report, write};
use corroborate_bench::table::{page, tables};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::read(std::env::args().skip(1));
    let done = arguments.and_then(|arguments| match arguments.verb.as_deref() {
        Some("write") => written(&arguments),
        Some("judge") => judged(&arguments),
        _ => benchmark(&arguments),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn catalogue(arguments: &Arguments, each: usize, held_out: bool) -> Result<Catalogue, String> {
    Ok(Catalogue {
        seed: arguments.seed.unwrap_or(1),
        each: arguments.each.unwrap_or(each),
        sound: if arguments.small { 1 } else { 3 },
        is_thin: arguments.small,
        held_out,
        only: arguments.kind()?,
        fault: arguments.fault,
    })
}

fn written(arguments: &Arguments) -> Result<(), String> {
    let folder = arguments.to.as_deref().ok_or(USAGE)?;
    let catalogue = catalogue(arguments, 2, arguments.show_held_out)?;
    trace::create_folder(folder).map_err(|error| error.to_string())?;
    let count = write::write_all(&catalogue, folder)?;
    eprintln!("{count} studies, and {} beside them", write::ANSWERS);
    Ok(())
}

fn judged(arguments: &Arguments) -> Result<(), String> {
    let folder = arguments.to.as_deref().ok_or(USAGE)?;
    let program = arguments.program.as_deref().ok_or(USAGE)?;
    let catalogue = catalogue(arguments, if arguments.small { 1 } else { 6 }, true)?;
    let studies = catalogue.studies();
    let outcomes = judge::all(&studies, program, folder, &|done, all| {
        if done % 20 == 0 || done == all {
            eprintln!("{done} of {all} studies");
        }
    })?;
    for (study, outcome) in studies.iter().zip(&outcomes) {
        let may_show = arguments.show_held_out || !study.draft.family.is_held_out();
        if let Some(missed) = outcome
            .missed(study)
            .filter(|_| arguments.misses && may_show)
        {
            eprintln!("{missed}");
        }
    }
    println!("{}", report::page(&catalogue, &studies, &outcomes));
    Ok(())
}

fn benchmark(arguments: &Arguments) -> Result<(), String> {
    let mut plan = if arguments.small {
        Plan::SMALL
    } else {
        Plan::FULL
    };
    plan.seed = arguments.seed.unwrap_or(plan.seed);
    plan.only = arguments.family()?;
    if arguments.without_case_studies {
        (plan.handover, plan.corridor) = (0, 0);
    }
    let folder = arguments.to.as_deref();
    // Tried before the work, which would be lost for want of a folder.
    if let Some(folder) = folder {
        let path = folder.join("targets.csv");
        trace::write_file(&path, b"").map_err(|error| error.to_string())?;
    }
    // Talk goes to standard error: a line for each study of a case study, whose models take long, else for each tenth.
    let lines = run(&plan, &|done, all| {
        if all < 200 || done % (all / 10) == 0 || done == all {
            eprintln!("{done} of {all} studies");
        }
    })?;
    for missed in lines
        .iter()
        .filter(|_| arguments.misses)
        .filter_map(Line::missed)
    {
        eprintln!("{missed}");
    }
    if let Some(folder) = folder {
        for table in tables(&lines) {
            let path = folder.join(format!("{}.csv", table.name));
            trace::write_file(&path, table.csv().as_bytes()).map_err(|error| error.to_string())?;
        }
    }
    println!("{}", page(&lines, plan.seed));
    Ok(())
}
