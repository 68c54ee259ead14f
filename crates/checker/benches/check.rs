//! How long exploring and checking take on models of about ten thousand states.
//!
//! Run with `cargo bench -p corroborate-checker`.

use checker::explore::explore;
use checker::{Method, Options, check_space};
use divan::Bencher;
use prism_lang::resolved::Model;
use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};

fn main() {
    divan::main();
}

/// Two walkers on a line of 100 places that synchronise now and then: one large component.
const WALKERS: &str = "dtmc
const int n = 99;
module left
  a : [0..n] init 50;
  [] a>0 & a<n -> 0.4:(a'=a-1) + 0.6:(a'=a+1);
  [meet] a=b -> (a'=50);
endmodule
module right
  b : [0..n] init 20;
  [] b>0 & b<n -> 0.6:(b'=b-1) + 0.4:(b'=b+1);
  [meet] a=b -> (b'=20);
endmodule";

/// A counter with retries: ten thousand small components in a row.
const COUNTER: &str = "dtmc
const int n = 5000;
module counter
  k : [0..n] init 0;
  tries : [0..1] init 0;
  [] k<n & tries=0 -> 0.9:(k'=k+1) + 0.1:(tries'=1);
  [] k<n & tries=1 -> 0.5:(k'=k+1)&(tries'=0) + 0.4:(tries'=0) + 0.1:(k'=0);
  [] k=n -> true;
endmodule";

const MODELS: [(&str, &str); 2] = [("walkers", WALKERS), ("counter", COUNTER)];

const PROPERTIES: [&str; 3] = [
    "P=? [ F a=0 ]; P=? [ F k=n ]",
    "P=? [ F<=500 a=0 ]; P=? [ F<=500 k=40 ]",
    "P=? [ (G F b=0) | (F (a=0 U b=0)) ]; P=? [ G (k=7 => F (tries=1 & X k=9)) ]",
];

fn model(name: &str) -> Model {
    let (_, text) = MODELS
        .iter()
        .find(|(known, _)| *known == name)
        .expect("a model of this file");
    resolve(&parse_model(text).tree, &Constants::new()).expect("a correct model")
}

/// The property of each list in `PROPERTIES` that is about this model.
fn property(model: &Model, kind: usize) -> Property {
    let position = usize::from(model.variable("k").is_some());
    let text = PROPERTIES[kind]
        .split("; ")
        .nth(position)
        .expect("one for each model");
    let properties = resolve_properties(&parse_properties(text).tree, model, &Constants::new());
    properties.expect("a correct property").remove(0).property
}

#[divan::bench(args = ["walkers", "counter"])]
fn exploring(bencher: Bencher, name: &str) {
    let model = model(name);
    bencher.bench(|| explore::<f64>(&model).expect("explorable"));
}

#[divan::bench(args = ["walkers", "counter"], consts = [0, 1, 2])]
fn sound<const KIND: usize>(bencher: Bencher, name: &str) {
    let model = model(name);
    let space = explore::<f64>(&model).expect("explorable");
    let property = property(&model, KIND);
    bencher.bench(|| check_space(&space, &property, &Options::default()).expect("an answer"));
}

#[divan::bench(args = ["walkers"])]
fn as_prism_does(bencher: Bencher, name: &str) {
    let model = model(name);
    let space = explore::<f64>(&model).expect("explorable");
    let property = property(&model, 0);
    let options = Options::with_method(Method::PrismDefault);
    bencher.bench(|| check_space(&space, &property, &options).expect("an answer"));
}
