//! A property's value as a function of constants that stay open: how large it is, and what it takes.
//!
//! ```text
//! cargo run --release -p corroborate-checker --example parametric -- MODEL.prism 'p=0:1,q' 'P=? [ F "done" ]' [N=5]
//! ```

use std::time::Instant;

use checker::Options;
use checker::explore::{ExploreOptions, explore_with};
use checker::parametric::{ParametricValue, RationalFunction, Region, solve};
use prism_lang::{Constants, parse_model, parse_properties, resolve_open, resolve_properties};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, region, property, given @ ..] = &arguments[..] else {
        return Err(
            "give a model, ranges of open constants, a property, and values of constants".into(),
        );
    };
    let text = std::fs::read_to_string(model)?;
    let none = Constants::new();
    let given = Constants::parse(&given.join(","))?;
    let model = resolve_open(
        &parse_model(&text).tree,
        &given,
        &none,
        &Region::names(region),
    )
    .map_err(|found| found[0].to_string())?;
    let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
    let region = Region::parse(region, &model.parameters)?;
    let asked = resolve_properties(&parse_properties(property).tree, &model, &none)
        .map_err(|found| found[0].to_string())?;
    let began = Instant::now();
    let options = ExploreOptions::for_properties(asked.iter().map(|p| &p.property));
    let space = explore_with::<RationalFunction>(&model, options, &|_| true)?;
    println!(
        "{} states, {} transitions",
        space.num_states(),
        space.num_transitions()
    );
    println!("explored in {:.2} s", began.elapsed().as_secs_f64());
    for property in asked {
        let began = Instant::now();
        let answer = solve(&space, &property.property, &region, &Options::default())?;
        println!(
            "{}: solved in {:.2} s",
            property.text,
            began.elapsed().as_secs_f64()
        );
        for part in &answer.parts {
            for value in &part.values {
                let ParametricValue::Function(function) = value else {
                    println!("{}: {value:?}", part.region);
                    continue;
                };
                let shown: String = function.text(&names).chars().take(300).collect();
                println!("{}: {} terms, {shown}", part.region, function.size());
                let centre = part.region.centre();
                let at = function
                    .at(&centre)
                    .map(|v| prism_lang::rational_to_f64(&v));
                println!("in the middle: {at:?}");
            }
        }
        println!("conditions hold: {}", answer.conditions.hold());
    }
    Ok(())
}
