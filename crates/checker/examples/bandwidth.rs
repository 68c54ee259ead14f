//! How far iterating is from what the memory gives: bytes a second of the equations' rows in a round of value iteration and in a
//! step, beside a sum over an array that is as large.
//!
//! A walker in a cube goes one way or another, and a fiftieth of its steps end at home. All other states are one component.
//! Rows count as the equations hold them: 12 bytes an entry (a column and a probability), 16 bytes a choice, 16 bytes a state
//! with its value. Rounds by name, and steps, are those that a higher limit takes more, so that what comes before does not
//! count. The default method's rounds are all that it takes beyond one round by name, so that copying the rows into its order and
//! showing the bounds do count. All are measured in turns; medians of [`TURNS`] are printed.
//!
//! `cargo run --release -p corroborate-checker --example bandwidth -- [N]` (a cube of N by N by N places; 90 if not given)

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use checker::explore::explore;
use checker::state_space::StateSpace;
use checker::{CheckError, Method, Options, check_space};
use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};

/// How often each is measured.
const TURNS: usize = 5;
/// Steps of the question within steps.
const STEPS: [u32; 2] = [20, 60];
/// Rounds by name of the question without a bound.
const ROUNDS: u64 = 20;

const WALKER: &str = "
const int n;
formula away = x+y+z > 0;
formula high = x=n | y=n | z=n;
formula low = x=0 | y=0 | z=0;
module walker
  x : [0..n] init floor(n/2);
  y : [0..n] init floor(n/2);
  z : [0..n] init floor(n/2);
  [] away & !high -> 0.2:(x'=x+1) + 0.4:(y'=y+1) + 0.38:(z'=z+1) + 0.02:(x'=0)&(y'=0)&(z'=0);
  [] away & !low -> 0.3:(x'=x-1) + 0.3:(y'=y-1) + 0.38:(z'=z-1) + 0.02:(x'=0)&(y'=0)&(z'=0);
  [] away & high & low -> 0.5:(x'=floor(n/2))&(y'=floor(n/2))&(z'=floor(n/2)) + 0.5:(x'=0)&(y'=0)&(z'=0);
endmodule
label \"home\" = !away;
rewards true : 1; endrewards";

struct Walk {
    space: StateSpace<f64>,
    questions: Vec<Property>,
}

fn walk(kind: &str, size: &str, questions: &str) -> Result<Walk, Box<dyn Error>> {
    let constants = Constants::parse(&format!("n={size}"))?;
    let parsed = parse_model(&format!("{kind}{WALKER}")).into_result();
    let model = resolve(&parsed.map_err(|found| format!("{found:?}"))?, &constants);
    let model = model.map_err(|found| format!("{found:?}"))?;
    let asked = resolve_properties(&parse_properties(questions).tree, &model, &constants);
    let asked = asked.map_err(|found| format!("{found:?}"))?;
    Ok(Walk {
        space: explore::<f64>(&model)?,
        questions: asked.into_iter().map(|named| named.property).collect(),
    })
}

impl Walk {
    /// Bytes of the rows that a round goes through.
    fn bytes(&self) -> f64 {
        let space = &self.space;
        (12 * space.num_transitions() + 16 * space.num_choices() + 16 * space.num_states()) as f64
    }

    /// Seconds that a question takes within so many rounds, and the rounds where it ends before.
    fn ask(
        &self,
        question: usize,
        method: Method,
        max_iters: u64,
    ) -> Result<(f64, f64), Box<dyn Error>> {
        let options = Options {
            method,
            epsilon: 1e-300,
            max_iters,
            ..Options::default()
        };
        let start = Instant::now();
        let answer = check_space(&self.space, &self.questions[question], &options);
        let seconds = start.elapsed().as_secs_f64();
        match answer {
            Ok(answer) => Ok((seconds, answer.iterations as f64)),
            Err(CheckError::NotConverged { .. }) => Ok((seconds, max_iters as f64)),
            Err(other) => Err(other.into()),
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let size = std::env::args().nth(1).unwrap_or_else(|| "90".into());
    let decisions = walk("mdp", &size, "Rmin=? [ F \"home\" ]")?;
    let steps = STEPS.map(|k| format!("P=? [ F<={k} \"home\" ]")).join("; ");
    let chain = walk("dtmc", &size, &steps)?;
    let array = vec![1.0_f64; (decisions.bytes() / 8.0) as usize];
    let [mut reading, mut jumps, mut in_place, mut default, mut step] = [const { Vec::new() }; 5];
    for _ in 0..TURNS {
        let start = Instant::now();
        black_box(sum(black_box(&array)));
        reading.push(8.0 * array.len() as f64 / start.elapsed().as_secs_f64());
        let (one, _) = decisions.ask(0, Method::GaussSeidel, 1)?;
        for (rates, method) in [
            (&mut jumps, Method::ValueIteration),
            (&mut in_place, Method::GaussSeidel),
        ] {
            let (many, rounds) = decisions.ask(0, method, ROUNDS)?;
            rates.push((rounds - 1.0) * decisions.bytes() / (many - one));
        }
        let (seconds, rounds) = decisions.ask(0, Method::Sound, 1)?;
        default.push(rounds * decisions.bytes() / (seconds - one));
        let [(early, _), (late, _)] = [
            chain.ask(0, Method::Sound, 1)?,
            chain.ask(1, Method::Sound, 1)?,
        ];
        step.push(f64::from(STEPS[1] - STEPS[0]) * chain.bytes() / (late - early));
    }
    let states = decisions.space.num_states();
    println!(
        "{states} states, {:.0} MB of rows; GB/s:",
        decisions.bytes() / 1e6
    );
    for (name, rates) in [
        ("a sum", reading),
        ("value iteration", jumps),
        ("Gauss-Seidel", in_place),
        ("default rounds", default),
        ("steps", step),
    ] {
        println!("{name:15} {:.1}", median(rates) / 1e9);
    }
    Ok(())
}

/// With eight sums at a time, so that additions do not wait for each other.
fn sum(array: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for chunk in array.chunks_exact(8) {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += x;
        }
    }
    sums.iter().sum()
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}
