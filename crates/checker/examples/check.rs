//! Answers properties of a model in the PRISM language, each with its guarantee.
//!
//! `cargo run --release -p corroborate-checker --example check -- MODEL 'P=? [ F x=1 ]' [name=value,...]`

use checker::explore::explore;
use checker::{Options, check};
use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, property, rest @ ..] = arguments.as_slice() else {
        return Err("usage: check MODEL PROPERTY [name=value,...]".into());
    };
    let constants = Constants::parse(rest.first().map_or("", |given| given))?;
    let model = parse_model(&std::fs::read_to_string(path)?).into_result()?;
    let model = resolve(&model, &constants)?;
    let properties = parse_properties(property).into_result()?;
    let properties = resolve_properties(&properties, &model, &constants)?;

    let space = explore::<f64>(&model)?;
    println!("{} states", space.num_states());
    for asked in &properties {
        let answer = check(&space, &model, &asked.property, &Options::default())?;
        println!("{:?} ({:?})", answer.value, answer.guarantee);
    }
    Ok(())
}
