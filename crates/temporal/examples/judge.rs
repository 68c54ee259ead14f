//! Judges formulas on traces given on standard input, one case in each line, for comparisons with
//! other monitors (`conformance/peers/formulas.py`).
//!
//! A case has fields separated by tabs: `discrete` or `dense`; the ending (`inconclusive`, `weak`,
//! `strong` or `finite`); the names of the atoms, separated by commas; the formula; and one field for
//! each sample, with its time and the robustness of each atom, separated by commas. For each
//! case a line says the verdict and the bounds of the robustness, separated by tabs:
//!
//! ```text
//! discrete    finite  p,q     always (p => eventually[0, 2 samples] q)        0,1,-1  1,-1,2
//! Satisfied   1       1
//! ```

use std::error::Error;
use std::io::{self, BufRead, Write};

use temporal::formula::{Ending, FormulaMonitor, Settings, TimeModel, parse};

fn main() -> Result<(), Box<dyn Error>> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    for (number, line) in io::stdin().lock().lines().enumerate() {
        let answer = judge(&line?).map_err(|error| format!("line {}: {error}", number + 1))?;
        writeln!(out, "{answer}")?;
    }
    Ok(out.flush()?)
}

fn judge(case: &str) -> Result<String, Box<dyn Error>> {
    let mut fields = case.split('\t');
    let mut field = || fields.next().ok_or("a field is missing");
    let time = match field()? {
        "discrete" => TimeModel::Discrete,
        "dense" => TimeModel::Dense,
        other => return Err(format!("no model of time is called '{other}'").into()),
    };
    let ending = match field()? {
        "inconclusive" => Ending::Inconclusive,
        "weak" => Ending::Weak,
        "strong" => Ending::Strong,
        "finite" => Ending::Finite,
        other => return Err(format!("no ending is called '{other}'").into()),
    };
    let names: Vec<&str> = field()?.split(',').collect();
    let parsed = parse(field()?, &|_| None)?;
    let positions = (parsed.atoms.iter())
        .map(|atom| names.iter().position(|name| *name == atom.text))
        .collect::<Option<Vec<usize>>>()
        .ok_or("the formula has an atom that is not named")?;
    let settings = Settings {
        time,
        ending,
        robustness: true,
        ..Settings::default()
    };
    let mut judge = FormulaMonitor::compile(&parsed.formula, &settings)?.start();
    for sample in fields {
        let numbers = sample
            .split(',')
            .map(str::parse)
            .collect::<Result<Vec<f64>, _>>()?;
        let (time_secs, values) = numbers.split_first().ok_or("a sample has no time")?;
        let atoms = (positions.iter())
            .map(|&position| values.get(position).copied())
            .collect::<Option<Vec<f64>>>()
            .ok_or("a sample has too few values")?;
        judge.step(*time_secs, &atoms)?;
    }
    let report = judge.finish(true);
    let bounds = report.robustness.ok_or("there is no sample")?;
    Ok(format!(
        "{:?}\t{}\t{}",
        report.verdict, bounds.low, bounds.high
    ))
}
