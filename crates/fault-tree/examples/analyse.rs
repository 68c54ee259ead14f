//! Analyses the top event of a fault tree in Galileo's (`.dft`) or the Open-PSA (`.xml`) format:
//!
//! ```text
//! cargo run --example analyse -- tree.dft [MISSION_TIME]
//! ```

use diagnostic::{Cancel, Problem, Source};
use fault_tree::{
    Analysis, FaultTree, Guarantee, Options, Probability, Settings, decimal, read_galileo,
    read_open_psa,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("name a file with a fault tree")?;
    let time = arguments
        .next()
        .map(|text| decimal(&text).ok_or("the mission time is not a number"));
    let settings = Settings {
        mission_time: time.transpose()?,
    };
    let source = Source::new(&path, std::fs::read_to_string(&path)?);
    let reading = match path.ends_with(".xml") {
        true => read_open_psa(&source, &settings)?,
        false => read_galileo(&source, &settings)?,
    };
    for warning in &reading.warnings {
        eprintln!("{}", warning.warning_line());
    }
    show(&reading.tree)?;
    Ok(())
}

fn show(tree: &FaultTree) -> Result<(), Problem> {
    let cancel = Cancel::default();
    let Some(top) = tree.top() else {
        return Ok(());
    };
    let analysis = Analysis::new(tree, top, Options::default(), &cancel)?;
    println!(
        "{}: {} events, {} nodes",
        tree.name(top),
        analysis.support().len(),
        analysis.nodes()
    );
    println!("probability: {}", in_words(&analysis.probability(&cancel)?));
    let cut_sets = analysis.cut_sets(10, &cancel)?;
    println!("{} minimal cut sets; the smallest:", cut_sets.count);
    for set in &cut_sets.sets {
        let names: Vec<&str> = set.iter().map(|id| tree.name(*id)).collect();
        println!("  {}", names.join(", "));
    }
    for importance in analysis.importance(&cancel)?.iter().take(10) {
        let name = tree.name(importance.event);
        println!(
            "{name}: Birnbaum importance at most {:e}",
            importance.birnbaum.upper
        );
    }
    Ok(())
}

fn in_words(probability: &Probability) -> String {
    let (lower, upper) = (probability.bounds.lower, probability.bounds.upper);
    match probability.guarantee {
        Guarantee::Exact => format!("{upper:e} (exact, and rounded here)"),
        Guarantee::Rounded => format!("between {lower:e} and {upper:e} (rounding)"),
        Guarantee::Range { .. } => {
            format!("between {lower:e} and {upper:e} (ranges of basic events)")
        }
        Guarantee::Statistical { confidence, .. } => {
            format!(
                "between {lower:e} and {upper:e} ({} % confidence)",
                100.0 * confidence
            )
        }
    }
}
