//! Exploring random models of every kind, with compositions and rewards, against an interpreter of the language's
//! definition that shares nothing with it but the expressions' own evaluation.

use std::collections::{BTreeMap, BTreeSet};

use checker::explore::{ExploreError, explore};
use checker::state_space::{StateSpace, TransitionRewards};
use prism_lang::resolved::{Command, Composition, Model, ModelType};
use prism_lang::{Constants, Rational, parse_model, resolve};
use proptest::prelude::*;

fn q(above: i64, below: i64) -> Rational {
    Rational::new(above.into(), below.into())
}

/// An action (if any) and the commands that take part.
type Move<'m> = (Option<usize>, Vec<&'m Command>);
/// For each target its probability or rate, and that times the transition's reward.
type Row = BTreeMap<Vec<i64>, (Rational, Rational)>;
/// An action and a row; chains have one, without action.
type Choice = (Option<usize>, Row);

/// What a composition can do in a state, by its operational rules.
fn moves<'m>(of: &Composition, model: &'m Model, state: &[i64]) -> Option<Vec<Move<'m>>> {
    Some(match of {
        Composition::Module(index) => {
            let mut found = Vec::new();
            for command in &model.modules[*index].commands {
                if command.guard.eval_bool(state).ok()? {
                    found.push((command.action, vec![command]));
                }
            }
            found
        }
        Composition::Full(operands) => {
            let mut all = moves(&operands[0], model, state)?;
            let mut alphabet = operands[0].alphabet(&model.modules);
            for operand in &operands[1..] {
                let other = operand.alphabet(&model.modules);
                let shared: BTreeSet<usize> = &alphabet & &other;
                all = joined(all, moves(operand, model, state)?, &shared);
                alphabet = &alphabet | &other;
            }
            all
        }
        Composition::Interleaved(operands) => {
            let each = operands.iter().map(|o| moves(o, model, state));
            each.collect::<Option<Vec<_>>>()?.concat()
        }
        Composition::On(left, actions, right) => joined(
            moves(left, model, state)?,
            moves(right, model, state)?,
            &actions.iter().copied().collect(),
        ),
        Composition::Hide(operand, hidden) => moves(operand, model, state)?
            .into_iter()
            .map(|(action, commands)| (action.filter(|a| !hidden.contains(a)), commands))
            .collect(),
        Composition::Rename(operand, renames) => moves(operand, model, state)?
            .into_iter()
            .map(|(action, commands)| {
                let new = renames.iter().find(|(old, _)| Some(*old) == action);
                (new.map_or(action, |(_, new)| Some(*new)), commands)
            })
            .collect(),
    })
}

fn joined<'m>(left: Vec<Move<'m>>, right: Vec<Move<'m>>, on: &BTreeSet<usize>) -> Vec<Move<'m>> {
    let is_joint = |m: &&Move<'_>| m.0.is_some_and(|a| on.contains(&a));
    let mut all: Vec<Move<'m>> = left.iter().filter(|m| !is_joint(m)).cloned().collect();
    all.extend(right.iter().filter(|m| !is_joint(m)).cloned());
    for (action, commands) in left.iter().filter(is_joint) {
        for (_, others) in right.iter().filter(|(other, _)| other == action) {
            all.push((*action, [&commands[..], others].concat()));
        }
    }
    all
}

/// The outcomes of commands that are taken together; `None` if something has no value or is out of range.
fn outcomes(
    commands: &[&Command],
    model: &Model,
    state: &[i64],
) -> Option<Vec<(Vec<i64>, Rational)>> {
    let mut all = vec![(state.to_vec(), q(1, 1))];
    for command in commands {
        let mut next = Vec::new();
        let mut sum = q(0, 1);
        for update in &command.updates {
            let factor: Rational = update.probability.eval_number(state).ok()?;
            if factor < q(0, 1) {
                return None;
            }
            sum += &factor;
            if factor == q(0, 1) {
                continue;
            }
            for (target, probability) in &all {
                let mut target = target.clone();
                for (variable, value) in &update.assignments {
                    let value = match model.variables[*variable].kind {
                        prism_lang::resolved::VariableKind::Bool => {
                            i64::from(value.eval_bool(state).ok()?)
                        }
                        _ => value.eval_int(state).ok()?,
                    };
                    let (low, high) = model.variables[*variable].kind.bounds();
                    if value < low || value > high {
                        return None;
                    }
                    target[*variable] = value;
                }
                next.push((target, probability * &factor));
            }
        }
        if model.model_type != ModelType::Ctmc && sum != q(1, 1) {
            return None;
        }
        all = next;
    }
    Some(all)
}

/// The reward of the first structure for an action (`Some`), or of the state itself.
fn reward(model: &Model, of: Option<Option<usize>>, state: &[i64]) -> Rational {
    let items = model.rewards[0].items.iter().filter(|i| i.transition == of);
    let earned = items.filter(|i| i.guard.eval_bool(state).unwrap());
    earned
        .map(|i| i.value.eval_number::<Rational>(state).unwrap())
        .sum()
}

fn choices(model: &Model, state: &[i64]) -> Option<Vec<Choice>> {
    let all = (0..model.modules.len()).map(Composition::Module).collect();
    let composition = model.composition.clone().unwrap_or(Composition::Full(all));
    let moves = moves(&composition, model, state)?;
    let loop_back = || (None, Row::from([(state.to_vec(), (q(1, 1), q(0, 1)))]));
    if moves.is_empty() {
        return Some(vec![loop_back()]);
    }
    let weight = match model.model_type {
        ModelType::Dtmc => q(1, moves.len() as i64),
        _ => q(1, 1),
    };
    let mut found: Vec<Choice> = Vec::new();
    for (action, commands) in &moves {
        let earned = reward(model, Some(*action), state);
        let mut row = Row::new();
        for (target, probability) in outcomes(commands, model, state)? {
            let entry = row.entry(target).or_insert_with(|| (q(0, 1), q(0, 1)));
            entry.0 += &probability * &weight;
            entry.1 += probability * &weight * &earned;
        }
        found.push((*action, row));
    }
    if model.model_type.has_choices() {
        found.sort();
        return Some(found);
    }
    let mut merged = Row::new();
    for (target, (p, r)) in found.into_iter().flat_map(|(_, row)| row) {
        let entry = merged.entry(target).or_insert_with(|| (q(0, 1), q(0, 1)));
        entry.0 += p;
        entry.1 += r;
    }
    // All rates may be 0.
    Some(if merged.is_empty() {
        vec![loop_back()]
    } else {
        vec![(None, merged)]
    })
}

/// All reachable states; `None` if one of them is wrong.
fn reachable(model: &Model, initial: Vec<i64>) -> Option<BTreeMap<Vec<i64>, Vec<Choice>>> {
    let mut found = BTreeMap::new();
    let mut open = vec![initial];
    while let Some(state) = open.pop() {
        if found.contains_key(&state) {
            continue;
        }
        let choices = choices(model, &state)?;
        open.extend(choices.iter().flat_map(|(_, row)| row.keys().cloned()));
        found.insert(state, choices);
    }
    Some(found)
}

/// The same of a state space.
fn read(space: &StateSpace<Rational>) -> BTreeMap<Vec<i64>, Vec<Choice>> {
    let rewards = space.rewards(0).unwrap();
    let choice = |row: usize| {
        let entries = space.matrix.row_start[row]..space.matrix.row_start[row + 1];
        let entry = |at: usize| {
            let p = space.matrix.value[at].clone();
            let r = rewards
                .transition
                .of(row, at)
                .cloned()
                .unwrap_or_else(|| q(0, 1));
            let target = space.state(space.matrix.column[at] as usize);
            (target, (p.clone(), p * r))
        };
        (space.action(row), entries.map(entry).collect())
    };
    let of_state = |s: usize| {
        let mut all: Vec<Choice> = space.choices(s).map(choice).collect();
        all.sort();
        (space.state(s), all)
    };
    (0..space.num_states()).map(of_state).collect()
}

fn guard() -> impl Strategy<Value = String> {
    let atom = (
        0..3,
        prop::sample::select(vec!["=", "!=", "<", "<=", ">", ">="]),
        0..4,
    )
        .prop_map(|(v, op, c)| format!("x{v}{op}{c}"));
    let other = prop::sample::select(vec![
        "true",
        "mod(x0+x1,2)=0",
        "x0*0.5<x1/3",
        "b0",
        "!b1 | x2>1",
        "x0=x1",
        "w2>5 | w0<x1",
        "floor(x0/2)=0",
        "b0=b1",
        "x1>0 & mod(x0,x1)=0",
        "pow(x0,2)>x2",
        "x0+x1+x2<6",
        "round(x1*0.4)=1",
    ])
    .prop_map(str::to_owned);
    prop_oneof![2 => atom, 1 => other].prop_recursive(2, 6, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} & {b})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} | {b})")),
            inner.prop_map(|a| format!("!({a})")),
        ]
    })
}

fn command(module: usize, kind: &'static str) -> impl Strategy<Value = String> {
    let x = format!("x{module}");
    let assignments: Vec<String> = [
        "(X'=0)",
        "(X'=3)",
        "(X'=min(X+1,3))",
        "(X'=max(X-1,0))",
        "(X'=3-x1)",
        "(X'=x2>1 ? 0 : x2)",
        "(X'=mod(X+1,4))",
        "true",
        "(B'=!B)",
        "(B'=x1>1)&(X'=1)",
        "(W'=1000000007*x1)",
        "(W'=-X)&(B'=true)",
        "(X'=ceil(X/2))",
        "(X'=X>2 ? X : X+1)&(W'=W>0 ? W : 7)",
    ]
    .iter()
    .map(|a| {
        a.replace('X', &x)
            .replace('B', &format!("b{module}"))
            .replace('W', &format!("w{module}"))
    })
    .chain(["FREE".to_owned()])
    .collect();
    // Now and then, a step that may leave the range.
    let risky = format!("({x}'={x}+1)");
    let assignment = (prop::sample::select(assignments), 0..40).prop_map(move |(a, n)| {
        if a == "FREE" && n > 3 {
            risky.clone()
        } else {
            a.replace("FREE", "true")
        }
    });
    let weights = match kind {
        "ctmc" => vec![
            vec!["2"],
            vec!["0.5", "x0"],
            vec!["1/3", "x1+1", "0.1"],
            vec!["x2*0.7"],
        ],
        "lts" => vec![vec![""]],
        _ => vec![
            vec!["1"],
            vec!["0.5", "0.5"],
            vec!["x0/3", "1-x0/3"],
            vec!["0.1", "0", "0.9"],
            vec!["1/(1+x1)", "x1/(x1+1)"],
        ],
    };
    let action = prop::sample::select(vec!["", "a", "b", "c"]);
    (
        action,
        guard(),
        prop::sample::select(weights),
        prop::collection::vec(assignment, 3),
    )
        .prop_map(|(action, guard, weights, assigned)| {
            let update = |(w, a): (&&str, &String)| match *w {
                "" => a.clone(),
                w => format!("{w}:{a}"),
            };
            let updates: Vec<String> = weights.iter().zip(&assigned).map(update).collect();
            format!("[{action}] {guard} -> {};", updates.join(" + "))
        })
}

fn random_model() -> impl Strategy<Value = String> {
    let kind = prop::sample::select(vec!["dtmc", "ctmc", "mdp", "lts"]);
    let systems = vec![
        "",
        "",
        "system m0 || m1 || m2 endsystem",
        "system m0 ||| m1 ||| m2 endsystem",
        "system (m0 |[a]| m1) ||| m2 endsystem",
        "system ((m0 || m1) / {a}) || m2 endsystem",
        "system (m0 {a<-b} || m1) |[b,c]| m2 endsystem",
        "system (m0 ||| m1) || m2 {b<-a,a<-c} endsystem",
        "system (m0 ||| m1) |[a]| m2 endsystem",
    ];
    kind.prop_flat_map(move |kind| {
        let module = move |i: usize| {
            prop::collection::vec(command(i, kind), 0..5).prop_map(move |commands| {
                format!(
                    "module m{i} x{i} : [0..3]; b{i} : bool; w{i} : [-5..100000000000]; {} endmodule ",
                    commands.join(" ")
                )
            })
        };
        let system = prop::sample::select(systems.clone());
        (module(0), module(1), module(2), system).prop_map(move |(a, b, c, system)| {
            let keyword = if kind == "lts" { "" } else { kind };
            let mut items = String::from("x0>1 : x0/3; true : w1-2; [] b0 : 2;");
            let text = format!("{a}{b}{c}{system}");
            for action in ["a", "b", "c"] {
                if text.contains(&format!("[{action}]")) {
                    items += &format!("[{action}] x1<2 : 1/3; [{action}] true : x2;");
                }
            }
            format!("{keyword} {text} rewards {items} endrewards")
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exploring_agrees_with_the_definition(text in random_model()) {
        let parsed = parse_model(&text).into_result();
        prop_assert!(parsed.is_ok(), "{}\n{:?}", text, parsed.err());
        // Some texts are refused before: a probability that is none in the initial state, say.
        let Ok(model) = resolve(&parsed.unwrap(), &Constants::new()) else { return Ok(()) };
        let initial = model.variables.iter().map(|v| v.init).collect();
        match (explore::<Rational>(&model), reachable(&model, initial)) {
            (Ok(space), Some(expected)) => {
                prop_assert_eq!(read(&space), expected, "{}", text);
                for state in 0..space.num_states() {
                    let earned = reward(&model, None, &space.state(state));
                    prop_assert_eq!(&space.rewards(0).unwrap().state[state], &earned);
                }
                let rows = !model.model_type.has_choices();
                let kept = &space.rewards(0).unwrap().transition;
                prop_assert!(!matches!(kept, TransitionRewards::Row(_)) || !rows);
                let rounded = explore::<f64>(&model).unwrap();
                prop_assert_eq!(&rounded.matrix.column, &space.matrix.column);
                prop_assert_eq!(&rounded.matrix.row_start, &space.matrix.row_start);
                for (found, exact) in rounded.matrix.value.iter().zip(&space.matrix.value) {
                    let found = Rational::from_float(*found).unwrap();
                    let error = Rational::from_float(rounded.relative_error()).unwrap();
                    let distance = if found > *exact { &found - exact } else { exact - &found };
                    prop_assert!(distance <= error * exact);
                }
            }
            (Err(_), None) => {}
            (Ok(_), None) => prop_assert!(false, "nothing was found wrong in\n{}", text),
            (Err(error), Some(_)) => {
                let exotic = matches!(error, ExploreError::TooManyStates { .. });
                prop_assert!(exotic, "{}\n{}", error, text);
            }
        }
    }
}
