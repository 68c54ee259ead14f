//! The signals of a study's simulations in words.

use corroborate::inspect::{Quantity, Signal, SimulationSignals, StudySignals, Truth};
use std::fmt::Write;

/// What each recording has, and what more a scene would record.
pub fn text(found: &StudySignals) -> String {
    let mut output = String::new();
    if found.simulations.is_empty() {
        let _ = writeln!(
            output,
            "{} simulates nothing itself: look into a recording",
            found.study
        );
    }
    for simulation in &found.simulations {
        of_simulation(&mut output, simulation);
    }
    output
}

fn of_simulation(output: &mut String, simulation: &SimulationSignals) {
    let ids = simulation.evidence.join(", ");
    let _ = writeln!(
        output,
        "{ids}, in {}: each recording has\n",
        simulation.engine
    );
    let signals = simulation.recorded.iter();
    table(output, signals.map(|it| row(&it.name, it)));
    if let Some(truth) = &simulation.truth {
        of_truth(output, truth);
    }
    for (title, lines) in [
        ("Not simulated as it is described:", &simulation.gaps),
        ("Checked before anything runs:", &simulation.checked),
    ] {
        if !lines.is_empty() {
            let _ = writeln!(output, "\n{title}\n");
        }
        for line in lines {
            let _ = writeln!(output, "  {line}");
        }
    }
    output.push('\n');
}

fn row(name: &str, signal: &Signal) -> [String; 4] {
    let frame = signal.frame.clone().unwrap_or_default();
    [name.to_owned(), signal.unit.clone(), frame, String::new()]
}

fn of_truth(output: &mut String, truth: &Truth) {
    let _ = writeln!(
        output,
        "\nand, once a proposition or requirement names it, any of these topics\n"
    );
    let topics = truth.topics.iter().map(|topic| {
        let joints = match topic.joints.is_empty() {
            true => String::new(),
            false => format!("JOINT: {}", topic.joints.join(", ")),
        };
        [
            topic.topic.clone(),
            topic.kind.clone(),
            String::new(),
            joints,
        ]
    });
    table(output, topics);
    let _ = writeln!(output, "\nwith any of these quantities that it has\n");
    let quantity = |it: &Quantity| {
        let frame = it.frame.clone().unwrap_or_default();
        [it.name.clone(), it.unit.clone(), frame, it.meaning.clone()]
    };
    table(output, truth.quantities.iter().map(quantity));
    let _ = writeln!(output, "\nOTHER:  {}", truth.others.join(", "));
    if !truth.regions.is_empty() {
        let _ = writeln!(output, "REGION: {}", truth.regions.join(", "));
    }
}

/// Rows with columns as wide as what is in them.
fn table(output: &mut String, rows: impl Iterator<Item = [String; 4]>) {
    let rows: Vec<[String; 4]> = rows.collect();
    let width = |column: usize| {
        let lengths = rows.iter().map(|row| row[column].chars().count());
        lengths.max().unwrap_or(0)
    };
    let [first, second, third] = [0, 1, 2].map(width);
    for [a, b, c, d] in &rows {
        let line = format!("  {a:first$}  {b:second$}  {c:third$}  {d}");
        let _ = writeln!(output, "{}", line.trim_end());
    }
}
