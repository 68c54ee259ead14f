//! Words of a prefix and a cycle, judged by machines and by the definition.

use super::*;

fn set(number: usize) -> Formula {
    Formula::Set(number, true)
}

fn eventually(of: Formula) -> Formula {
    Formula::Until(Box::new(Formula::True), Box::new(of), 0, None)
}

fn always(of: Formula) -> Formula {
    Formula::Release(Box::new(Formula::False), Box::new(of), 0, None)
}

/// Whether the word of a prefix and a cycle for ever is accepted.
fn accepts(formula: &Formula, prefix: &[u64], cycle: &[u64]) -> bool {
    let mut machines = Vec::new();
    let condition = Condition::read(formula, &mut machines).unwrap();
    let mut place = vec![0; machines.len()];
    let mut marked = vec![false; machines.len()];
    let rounds = std::iter::repeat_n(cycle, 40).flatten();
    for (at, letter) in prefix.iter().chain(rounds).enumerate() {
        for (machine, place) in machines.iter_mut().zip(&mut place) {
            *place = machine.step(*place, *letter).unwrap();
        }
        for (machine, marked) in marked.iter_mut().enumerate() {
            // What happens in the last half happens again and again.
            *marked |=
                at > prefix.len() + 20 * cycle.len() && machines[machine].is_marked(place[machine]);
        }
    }
    let holds = |clause: &Clause| {
        clause.again.iter().all(|m| marked[*m]) && !clause.not_again.iter().any(|m| marked[*m])
    };
    condition.clauses().iter().any(holds)
}

#[test]
fn words_are_accepted_as_the_formulas_mean() {
    let answered = always(Formula::Or(vec![
        Formula::Set(0, false),
        eventually(set(1)),
    ]));
    assert!(accepts(&answered, &[1, 1], &[1, 0, 2]));
    assert!(!accepts(&answered, &[2, 1], &[0]));
    assert!(accepts(&answered, &[3], &[0]));
    let within = always(Formula::Or(vec![
        Formula::Set(0, false),
        Formula::Until(Box::new(Formula::True), Box::new(set(1)), 1, Some(2)),
    ]));
    assert!(accepts(&within, &[], &[1, 0, 2]));
    assert!(!accepts(&within, &[], &[1, 0, 0, 2]));
    assert!(!accepts(&within, &[], &[3, 0, 0]));
    let persists = eventually(always(set(0)));
    assert!(accepts(&persists, &[0, 0], &[1]) && !accepts(&persists, &[], &[1, 1, 0]));
    let both = Formula::And(vec![always(eventually(set(0))), persists.negated()]);
    assert!(accepts(&both, &[], &[0, 1]) && !accepts(&both, &[], &[1]));
}

/// Whether a word satisfies a formula from a place on, by the definition: each suffix is that of a place before the end of
/// the first cycle.
fn satisfies(formula: &Formula, prefix: &[u64], cycle: &[u64], from: usize) -> bool {
    let length = prefix.len() + cycle.len();
    let place = |at: usize| match at < length {
        true => at,
        false => prefix.len() + (at - prefix.len()) % cycle.len(),
    };
    let holds = |f: &Formula, at: usize| satisfies(f, prefix, cycle, place(at));
    match formula {
        Formula::True => true,
        Formula::False => false,
        Formula::Set(set, inside) => {
            let letter = prefix.iter().chain(cycle).nth(from).unwrap();
            (letter >> set & 1 == 1) == *inside
        }
        Formula::And(of) => of.iter().all(|f| holds(f, from)),
        Formula::Or(of) => of.iter().any(|f| holds(f, from)),
        Formula::Next(of) => holds(of, from + 1),
        Formula::Until(l, r, first, last) => {
            let (first, horizon) = (*first as usize, *first as usize + 2 * length);
            let last = last.map_or(horizon, |last| (last as usize).min(horizon));
            (first..=last)
                .any(|k| holds(r, from + k) && (0..k).all(|before| holds(l, from + before)))
        }
        Formula::Release(..) => !holds(&formula.negated(), from),
    }
}

/// A formula drawn with this seed.
fn drawn(seed: &mut u64, depth: u32) -> Formula {
    let mut draw = |below: u64| {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 33) % below
    };
    let kind = if depth == 0 { 0 } else { draw(7) };
    let (first, last) = match draw(5) {
        0 => (draw(3), None),
        1 => (draw(2), Some(1 + draw(3))),
        _ => (0, None),
    };
    let atom = Formula::Set(draw(2) as usize, draw(3) > 0);
    let mut operand = || drawn(seed, depth - 1);
    match kind {
        1 => Formula::And(vec![operand(), operand()]),
        2 => Formula::Or(vec![operand(), operand()]),
        3 => Formula::Next(Box::new(operand())),
        4 => Formula::Until(Box::new(operand()), Box::new(operand()), first, last),
        5 => Formula::Release(Box::new(operand()), Box::new(operand()), first, last),
        6 => Formula::Release(Box::new(Formula::False), Box::new(operand()), 0, None),
        _ => atom,
    }
}

#[test]
fn any_formula_is_judged_as_it_is_defined() {
    let words: [(&[u64], &[u64]); 7] = [
        (&[], &[1]),
        (&[1, 1], &[2]),
        (&[1, 3, 0], &[1, 2]),
        (&[2], &[0, 3, 1]),
        (&[0, 1, 2], &[3]),
        (&[3, 1], &[1, 0, 0]),
        (&[], &[2, 2, 1]),
    ];
    let mut seed = 7;
    let (mut judged, mut guessed) = (0, 0);
    while judged < 250 {
        let formula = drawn(&mut seed, 3);
        let mut machines = Vec::new();
        if Condition::read(&formula, &mut machines).is_err() {
            continue;
        }
        let is_guess = |machine: &Machine| matches!(machine.watched, Watched::Rest(..));
        guessed += u32::from(machines.iter().any(is_guess));
        for (prefix, cycle) in words {
            let expected = satisfies(&formula, prefix, cycle, 0);
            let found = accepts(&formula, prefix, cycle);
            assert_eq!(found, expected, "{formula:?} on {prefix:?} {cycle:?}");
        }
        judged += 1;
    }
    assert!(
        guessed >= 15,
        "only {guessed} formulas were outside the fragment"
    );
}
