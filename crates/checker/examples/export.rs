//! Writes a model's state space as PRISM's explicit files and as a graph: PREFIX.tra, .sta, .lab, .drn, .dot, and
//! PREFIX1.srew, PREFIX1.trew and so on for reward structures.
//!
//! `cargo run --release -p corroborate-checker --example export -- MODEL PREFIX [name=value,...] [exact]`

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use checker::explore::explore;
use checker::formats::{Explicit, Written};
use prism_lang::resolved::Model;
use prism_lang::{Arithmetic, Constants, Rational, parse_model, resolve};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, prefix, rest @ ..] = &arguments[..] else {
        return Err("give a model and the beginning of the files' names".into());
    };
    let constants = Constants::parse(rest.first().map_or("", |c| c))?;
    let parsed = parse_model(&std::fs::read_to_string(path)?).into_result();
    let tree = parsed.map_err(|found| format!("{found:?}"))?;
    let model = resolve(&tree, &constants).map_err(|found| format!("{found:?}"))?;
    match rest.get(1) {
        Some(_) => export::<Rational>(&model, prefix),
        None => export::<f64>(&model, prefix),
    }
}

fn export<N: Arithmetic + Written>(model: &Model, prefix: &str) -> Result<(), Box<dyn Error>> {
    let space = explore::<N>(model)?;
    let explicit = Explicit::new(&space);
    let file = |ending: String| File::create(format!("{prefix}{ending}")).map(BufWriter::new);
    explicit.write_transitions(&mut file(".tra".to_owned())?)?;
    explicit.write_states(&mut file(".sta".to_owned())?)?;
    let mut labels = Vec::new();
    for (name, _) in &model.labels {
        labels.push((name.clone(), space.label(name)?));
    }
    explicit.write_labels(&labels, &mut file(".lab".to_owned())?)?;
    explicit.write_drn(&labels, &mut file(".drn".to_owned())?)?;
    explicit.write_dot(true, &mut file(".dot".to_owned())?)?;
    for index in 0..space.num_rewards() {
        let rewards = space.rewards(index).map_err(Clone::clone)?;
        let ending = |of: &str| format!("{}.{of}", index + 1);
        explicit.write_state_rewards(index, rewards, &mut file(ending("srew"))?)?;
        explicit.write_transition_rewards(index, rewards, &mut file(ending("trew"))?)?;
    }
    Ok(())
}
