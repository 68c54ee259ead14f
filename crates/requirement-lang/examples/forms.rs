//! Prints the property of every combination of scope, condition and timing, one to a line: its key
//! in the manner of FRET, its duration in steps, and the path formula. `tests/peers/fret.py` compares
//! them with the formulas that FRET publishes.

use requirement_lang::compile::property::{Model, label_of_name, property};
use requirement_lang::{Context, parse};

const SCOPES: [(&str, &str); 8] = [
    ("null", ""),
    ("in", "In m, "),
    ("notin", "When not in m, "),
    ("before", "Before m, "),
    ("after", "After m, "),
    ("onlyIn", "Only in m, "),
    ("onlyBefore", "Only before m, "),
    ("onlyAfter", "Only after m, "),
];

const CONDITIONS: [(&str, &str); 3] = [
    ("null", ""),
    ("regular", "when c, "),
    ("holding", "whenever c, "),
];

const TIMINGS: [(&str, &str); 11] = [
    ("immediately", "immediately"),
    ("next", "at the next step"),
    ("eventually", "eventually"),
    ("null", ""),
    ("always", "always"),
    ("never", "never"),
    ("until", "until q"),
    ("before", "before q"),
    ("within", "within N steps"),
    ("for", "for N steps"),
    ("after", "after N steps"),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model {
        step_secs: None,
        proposition: &label_of_name,
    };
    for (scope, scope_text) in SCOPES {
        for (condition, condition_text) in CONDITIONS {
            for (timing, timing_text) in TIMINGS {
                for steps in 1..=3 {
                    let text = format!(
                        "{scope_text}{condition_text}the robot shall {timing_text} satisfy r"
                    );
                    let text = text.replace('N', &steps.to_string());
                    let sentence = parse(&text, &Context::default()).into_result();
                    let sentence = sentence.map_err(|mistakes| mistakes[0].clone())?;
                    let path = property(&sentence, &model)?.path;
                    println!("{scope},{condition},{timing}\t{steps}\t{path}");
                    if !timing_text.contains('N') {
                        break;
                    }
                }
            }
        }
    }
    Ok(())
}
