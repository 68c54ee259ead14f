//! How long a model of 5,000 lines takes from a keystroke to each answer: the median of 40, in milliseconds of a processor where the
//! system tells them (so that what runs beside does not count), and in milliseconds of a clock.

use language_server::diagnostics::{self, Telling};
use language_server::{Alone, Workspace, completion, cursor, hover, rename, symbols};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

fn model() -> String {
    let mut text = String::from("dtmc\nconst int N = 5;\nconst double p = 0.5;\n");
    for i in 0..250 {
        let _ = writeln!(
            text,
            "module m{i}\n  x{i} : [0..N] init 0;\n  y{i} : [0..1];"
        );
        for k in 0..15 {
            let _ = writeln!(
                text,
                "  [a{i}_{k}] x{i}<N & y{i}=0 -> p:(x{i}'=x{i}+1) + (1-p):(y{i}'=1); // {k}"
            );
        }
        text.push_str("endmodule\n\n");
    }
    text + "label \"done\" = x0=N;\n"
}

/// The time that this thread has used of a processor, as Linux tells it.
fn processor_secs() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanos: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanos / 1e9)
}

fn measured(what: &str, work: impl Fn(&mut Workspace, &Path, usize)) {
    let path = Path::new("/models/large.prism");
    let mut workspace = Workspace::new(Box::new(Alone));
    let mut text = model();
    let mut took: Vec<(f64, f64)> = Vec::new();
    for _ in 0..41 {
        let at = text.find("x100<N").expect("a guard");
        text.insert(at, ' ');
        let (began, used) = (Instant::now(), processor_secs());
        workspace.open(path, text.clone());
        work(&mut workspace, path, at + 2);
        let used = processor_secs()
            .zip(used)
            .map_or(f64::NAN, |(now, then)| now - then);
        took.push((used * 1e3, began.elapsed().as_secs_f64() * 1e3));
    }
    // The first reads what all others have.
    took.remove(0);
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let used = median(took.iter().map(|it| it.0).collect());
    let passed = median(took.iter().map(|it| it.1).collect());
    println!("{what:<24} {used:7.1} {passed:7.1}");
}

fn main() {
    println!("{} lines", model().lines().count());
    measured("text alone", |_, _, _| {});
    measured("parsed", |it, path, _| {
        drop(prism_lang::parse_model(
            it.read(path).expect("open").as_str(),
        ))
    });
    measured("read, with names", |it, path, _| drop(it.model(path)));
    measured("diagnostics", |it, path, _| {
        drop(diagnostics::of_file(it, path, &Telling::default()));
    });
    measured("hover", |it, path, at| drop(hover::at(it, path, at)));
    measured("completion", |it, path, at| {
        drop(completion::at(it, path, at))
    });
    measured("definition", |it, path, at| {
        let found = cursor::at(it, path, at);
        drop(cursor::definitions(it, &found[0].thing, path));
    });
    measured("outline", |it, path, _| drop(symbols::of_file(it, path)));
    measured("rename", |it, path, at| {
        drop(rename::rename(it, path, at, "fresh").expect("free"));
    });
}
