//! Printing is the inverse of parsing, on random trees; and no text makes the parser panic.

use prism_lang::ast::{
    BinaryOp, Coalition, Command, Comparison, Expr, ExprKind, Filter, Model, Module, ModuleBody,
    Name, Observables, Optimum, Property, PropertyFile, Quantifier, Reward, RewardIndex,
    RewardObjective, StateFilter, StepBound, Strategy as Players, System, SystemExpr, SystemKind,
    TemporalOp, UnaryOp, Update, Variable, VariableRange,
};
use prism_lang::{Constants, Span, parse_model, parse_properties, resolve, resolve_properties};
use proptest::prelude::*;

fn expr(kind: ExprKind) -> Expr {
    Expr {
        kind,
        span: Span::default(),
    }
}

fn name(text: &str) -> Name {
    Name {
        text: text.to_owned(),
        span: Span::default(),
    }
}

fn leaf() -> impl Strategy<Value = Expr> {
    prop_oneof![
        any::<bool>().prop_map(ExprKind::Bool),
        (0i64..5).prop_map(ExprKind::Int),
        prop_oneof!["0\\.5", "1e-3", "2\\.0"].prop_map(ExprKind::Double),
        "[xyz]".prop_map(ExprKind::Name),
    ]
    .prop_map(expr)
}

fn binary() -> impl Strategy<Value = BinaryOp> {
    use BinaryOp::*;
    prop::sample::select(vec![
        Implies,
        Iff,
        Or,
        And,
        Equal,
        NotEqual,
        Less,
        LessEqual,
        Greater,
        GreaterEqual,
        Plus,
        Minus,
        Times,
        Divide,
        Power,
    ])
}

/// Operators over any expressions: types do not matter to the syntax.
fn operators(inner: BoxedStrategy<Expr>) -> BoxedStrategy<Expr> {
    let boxed = || inner.clone().prop_map(Box::new);
    prop_oneof![
        (
            prop::sample::select(vec![UnaryOp::Not, UnaryOp::Minus]),
            boxed()
        )
            .prop_map(|(op, a)| ExprKind::Unary(op, a)),
        (binary(), boxed(), boxed()).prop_map(|(op, a, b)| ExprKind::Binary(op, a, b)),
        (boxed(), boxed(), boxed()).prop_map(|(a, b, c)| ExprKind::IfThenElse(a, b, c)),
        (
            prop::sample::select(vec!["min", "floor", "pow"]),
            prop::collection::vec(inner.clone(), 1..3)
        )
            .prop_map(|(f, arguments)| ExprKind::Call(name(f), arguments)),
    ]
    .prop_map(expr)
    .boxed()
}

fn model_expr() -> BoxedStrategy<Expr> {
    leaf()
        .prop_recursive(5, 40, 3, |inner| operators(inner.boxed()))
        .boxed()
}

fn comparison() -> impl Strategy<Value = Comparison> {
    use Comparison::*;
    prop::sample::select(vec![Less, LessEqual, Greater, GreaterEqual])
}

fn step_bound() -> impl Strategy<Value = StepBound> {
    prop_oneof![
        (comparison(), model_expr()).prop_map(|(c, e)| StepBound::Compare(c, e)),
        model_expr().prop_map(StepBound::Exactly),
        (model_expr(), model_expr()).prop_map(|(a, b)| StepBound::Between(a, b)),
    ]
}

fn temporal(inner: BoxedStrategy<Expr>) -> BoxedStrategy<Expr> {
    use TemporalOp::*;
    let bound = || prop::option::of(step_bound().prop_map(Box::new));
    let prefix = prop::sample::select(vec![Next, Finally, Globally]);
    let infix = prop::sample::select(vec![Until, WeakUntil, Release]);
    prop_oneof![
        (prefix, bound(), inner.clone()).prop_map(|(operator, bound, right)| ExprKind::Temporal {
            operator,
            bound,
            left: None,
            right: Box::new(right),
        }),
        (infix, bound(), inner.clone(), inner.clone()).prop_map(
            |(operator, bound, left, right)| {
                ExprKind::Temporal {
                    operator,
                    bound,
                    left: Some(Box::new(left)),
                    right: Box::new(right),
                }
            }
        ),
        (
            prop::option::of((comparison(), model_expr().prop_map(Box::new))),
            inner
        )
            .prop_map(|(bound, path)| ExprKind::Probability {
                optimum: None,
                bound,
                path: Box::new(path),
                condition: None,
                filter: None,
            }),
    ]
    .prop_map(expr)
    .boxed()
}

type Bound = Option<(Comparison, Box<Expr>)>;

/// What follows the letter of an operator: an optimum is only asked for, never compared.
fn query() -> impl Strategy<Value = (Option<Optimum>, Bound)> {
    let optimum = prop::option::of(prop::sample::select(Optimum::ALL.to_vec()));
    let bound = (comparison(), model_expr().prop_map(Box::new));
    prop_oneof![
        optimum.prop_map(|o| (o, None)),
        bound.prop_map(|b| (None, Some(b))),
    ]
}

/// Formulas of a state: no temporal operator outside of another operator.
fn state_filter() -> impl Strategy<Value = Option<(Expr, bool, bool)>> {
    prop::option::of((model_expr(), any::<bool>(), any::<bool>()))
}

/// The old form of a filter; `min` and `max` only where there is no bound.
fn old_filter(bound: &Bound, filter: Option<(Expr, bool, bool)>) -> Option<StateFilter> {
    let open = bound.is_none();
    filter.map(|(states, min, max)| StateFilter {
        states,
        min: min && open,
        max: max && open,
    })
}

fn reward(inner: BoxedStrategy<Expr>) -> BoxedStrategy<Expr> {
    let index = || {
        prop::option::of(prop_oneof![
            "[ab]".prop_map(|n| RewardIndex::Name(name(&n))),
            model_expr().prop_map(RewardIndex::Index),
        ])
    };
    let objective = prop_oneof![
        Just(RewardObjective::Total),
        Just(RewardObjective::LongRun),
        model_expr().prop_map(RewardObjective::Cumulative),
        model_expr().prop_map(RewardObjective::Instantaneous),
        inner.prop_map(RewardObjective::Path),
    ];
    (index(), index(), query(), objective, state_filter())
        .prop_map(
            |(structure, divisor, (optimum, bound), objective, filter)| {
                let filter = old_filter(&bound, filter);
                let divisor = divisor.filter(|_| structure.is_some());
                expr(ExprKind::Reward(Box::new(Reward {
                    structure,
                    divisor,
                    optimum,
                    bound,
                    objective,
                    filter,
                })))
            },
        )
        .boxed()
}

fn probability(inner: BoxedStrategy<Expr>) -> BoxedStrategy<Expr> {
    (query(), inner, state_filter())
        .prop_map(|((optimum, bound), path, filter)| {
            let filter = old_filter(&bound, filter).map(Box::new);
            let path = Box::new(path);
            expr(ExprKind::Probability {
                optimum,
                bound,
                path,
                condition: None,
                filter,
            })
        })
        .boxed()
}

fn coalition() -> impl Strategy<Value = Coalition> {
    let players = prop::collection::vec("[abc]", 0..3);
    let named = players.prop_map(|p| Coalition::Players(p.iter().map(|n| name(n)).collect()));
    prop_oneof![Just(Coalition::All), named]
}

/// The operators that hold path formulas and are formulas of a state.
fn quantified(inner: BoxedStrategy<Expr>) -> BoxedStrategy<Expr> {
    let quantifier = || prop::sample::select(vec![Quantifier::ForAll, Quantifier::Exists]);
    let operand = prop_oneof![probability(inner.clone()), reward(inner.clone())];
    let strategy =
        (quantifier(), coalition(), operand).prop_map(|(quantifier, coalition, operand)| {
            expr(ExprKind::Strategy(Players {
                quantifier,
                coalition,
                operand: Box::new(operand),
            }))
        });
    let long_run = (query(), leaf(), state_filter()).prop_map(|((_, bound), states, filter)| {
        let filter = old_filter(&bound, filter).map(Box::new);
        let states = Box::new(states);
        expr(ExprKind::LongRun {
            bound,
            states,
            filter,
        })
    });
    let words = prop::sample::select(vec!["min", "max", "+", "&", "|", "forall", "avg"]);
    let operand = prop_oneof![probability(inner.clone()), model_expr()];
    let filter =
        (words, operand, prop::option::of(model_expr())).prop_map(|(operator, operand, states)| {
            expr(ExprKind::Filter(Filter {
                operator: name(operator),
                operand: Box::new(operand),
                states: states.map(Box::new),
            }))
        });
    let path = (quantifier(), inner.clone())
        .prop_map(|(q, path)| expr(ExprKind::Quantified(q, Box::new(path))));
    prop_oneof![
        probability(inner.clone()),
        reward(inner),
        long_run,
        strategy,
        filter,
        path
    ]
    .boxed()
}

/// A formula for within `P`.
fn path_expr() -> BoxedStrategy<Expr> {
    let label = "[ab]".prop_map(|l| expr(ExprKind::Label(l)));
    prop_oneof![leaf(), label]
        .prop_recursive(5, 40, 3, |inner| {
            prop_oneof![
                operators(inner.clone().boxed()),
                temporal(inner.clone().boxed()),
                quantified(inner.boxed())
            ]
        })
        .boxed()
}

fn system() -> BoxedStrategy<SystemExpr> {
    let node = |kind| SystemExpr {
        kind,
        span: Span::default(),
    };
    let leaf = prop_oneof![
        "[mn]".prop_map(|m| SystemKind::Module(name(&m))),
        "[st]".prop_map(|s| SystemKind::Reference(name(&s))),
    ];
    leaf.prop_map(node)
        .prop_recursive(4, 16, 3, move |inner| {
            let names = || prop::collection::vec("[ab]".prop_map(|a| name(&a)), 1..3);
            let pairs = ("[ab]", "[cd]").prop_map(|(a, b)| (name(&a), name(&b)));
            let several = || prop::collection::vec(inner.clone(), 2..4);
            let boxed = || inner.clone().prop_map(Box::new);
            prop_oneof![
                several().prop_map(SystemKind::Full),
                several().prop_map(SystemKind::Interleaved),
                (boxed(), names(), boxed()).prop_map(|(a, n, b)| SystemKind::On(a, n, b)),
                (boxed(), names()).prop_map(|(a, n)| SystemKind::Hide(a, n)),
                (boxed(), prop::collection::vec(pairs, 1..3))
                    .prop_map(|(a, r)| SystemKind::Rename(a, r)),
            ]
            .prop_map(node)
        })
        .boxed()
}

/// What models have besides modules.
fn surroundings() -> impl Strategy<Value = (Vec<System>, Vec<Observables>)> {
    let system = (prop::option::of("[st]"), system()).prop_map(|(n, body)| System {
        name: n.map(|n| name(&n)),
        body,
        span: Span::default(),
    });
    let observables = prop_oneof![
        prop::collection::vec("[xyz]".prop_map(|n| name(&n)), 1..3).prop_map(|names| {
            Observables::Variables {
                names,
                span: Span::default(),
            }
        }),
        ("[ab]", model_expr()).prop_map(|(n, body)| Observables::Defined {
            name: name(&n),
            body,
            span: Span::default(),
        }),
    ];
    (
        prop::collection::vec(system, 0..2),
        prop::collection::vec(observables, 0..2),
    )
}

fn property() -> impl Strategy<Value = Property> {
    let operator = quantified(path_expr());
    let arithmetic = (binary(), operator.clone(), operator.clone())
        .prop_map(|(op, a, b)| expr(ExprKind::Binary(op, Box::new(a), Box::new(b))));
    (
        prop::option::of("[pq]"),
        prop_oneof![3 => operator, 1 => arithmetic],
    )
        .prop_map(|(property_name, formula)| Property {
            name: property_name.map(|n| name(&n)),
            formula,
            text: String::new(),
            span: Span::default(),
        })
}

fn command() -> impl Strategy<Value = Command> {
    let assignment = (model_expr(), "[xyz]").prop_map(|(value, v)| prism_lang::ast::Assignment {
        variable: name(&v),
        value,
        span: Span::default(),
    });
    let assignments = || prop::collection::vec(assignment.clone(), 0..3);
    let update = |(probability, assignments)| Update {
        probability,
        assignments,
        span: Span::default(),
    };
    let single = assignments().prop_map(move |a| vec![update((None, a))]);
    let interval = (model_expr(), model_expr())
        .prop_map(|(low, high)| expr(ExprKind::Interval(Box::new(low), Box::new(high))));
    let probability = prop_oneof![4 => model_expr(), 1 => interval];
    let several = prop::collection::vec(
        (probability.prop_map(Some), assignments()).prop_map(update),
        1..4,
    );
    (
        prop::option::of("[st]"),
        model_expr(),
        prop_oneof![single, several],
    )
        .prop_map(|(action, guard, updates)| Command {
            action: action.map(|a| name(&a)),
            guard,
            updates,
            span: Span::default(),
        })
}

fn model() -> impl Strategy<Value = Model> {
    let variable = (model_expr(), model_expr(), prop::option::of(model_expr())).prop_map(
        |(low, high, init)| Variable {
            name: name("x"),
            range: VariableRange::Int {
                low: Box::new(low),
                high: Box::new(high),
            },
            init,
            span: Span::default(),
        },
    );
    let unbounded = prop::sample::select(vec![VariableRange::Unbounded, VariableRange::Clock])
        .prop_map(|range| Variable {
            name: name("y"),
            range,
            init: None,
            span: Span::default(),
        });
    let variables = prop::collection::vec(prop_oneof![variable, unbounded], 0..2);
    let commands = prop::collection::vec(command(), 0..4);
    (
        variables,
        prop::option::of(model_expr()),
        commands,
        prop::option::of(model_expr()),
        surroundings(),
    )
        .prop_map(
            |(variables, invariant, commands, init, (systems, observables))| Model {
                modules: vec![Module {
                    name: name("m"),
                    body: ModuleBody::Written {
                        variables,
                        invariant,
                        commands,
                    },
                    span: Span::default(),
                }],
                init,
                systems,
                observables,
                ..Model::default()
            },
        )
}

/// A tree without places, and without the verbatim texts of properties.
fn shape(tree: &impl std::fmt::Debug) -> String {
    let text = format!("{tree:?}");
    let (mut shape, mut rest) = (String::new(), text.as_str());
    while let Some(at) = rest.find("Span {") {
        shape.push_str(&rest[..at]);
        let end = rest[at..].find('}').map_or(rest.len(), |e| at + e + 1);
        rest = &rest[end..];
    }
    shape + rest
}

/// Pieces of the language, to be strung together at random.
fn fragment() -> impl Strategy<Value = String> {
    let words = "dtmc module endmodule const int double bool formula label init endinit rewards endrewards global \
        system x y m \"a\" x' ( ) [ ] { } ; : -> .. = != <= >= < > & | ! => <=> ? + - * / ^ , 0 1 0.5 1e400 \
        99999999999999999999 true false P P=? F G X U W R S min max func filter E A C I Pmax Rmin multi << >> [[ ]] || ||| <- =? forall \
        system endsystem mdp ctmc pta clock invariant endinvariant observables endobservables ' @ #x# \" //";
    prop::sample::select(
        words
            .split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn printed_models_parse_to_the_same_tree(tree in model()) {
        let printed = tree.to_string();
        let parsed = parse_model(&printed);
        prop_assert!(parsed.diagnostics.is_empty(), "{}\n{:?}", printed, parsed.diagnostics);
        prop_assert_eq!(shape(&parsed.tree), shape(&tree), "{}", printed);
    }

    #[test]
    fn printed_properties_parse_to_the_same_tree(properties in prop::collection::vec(property(), 1..3)) {
        let tree = PropertyFile { properties, ..PropertyFile::default() };
        let printed = tree.to_string();
        let mut parsed = parse_properties(&printed);
        prop_assert!(parsed.diagnostics.is_empty(), "{}\n{:?}", printed, parsed.diagnostics);
        for property in &mut parsed.tree.properties {
            property.text.clear();
        }
        prop_assert_eq!(shape(&parsed.tree), shape(&tree), "{}", printed);
    }

    /// Whatever the text, reading ends, spans lie in the text, and what has no errors has no unreadable part.
    #[test]
    fn no_text_makes_the_reader_panic(words in prop::collection::vec(fragment(), 0..40)) {
        let text = words.join(" ");
        let parsed = parse_model(&text);
        for d in &parsed.diagnostics {
            prop_assert!(d.span.start <= d.span.end && d.span.end <= text.len(), "{:?}", d);
        }
        let clean = !parsed.has_errors();
        if let Err(diagnostics) = resolve(&parsed.tree, &Constants::new()) {
            prop_assert!(!clean || diagnostics.iter().all(|d| d.code != "unreadable"), "{}", text);
        }
        let model = resolve(&parse_model("dtmc module m x : [0..3]; y : bool; endmodule").tree, &Constants::new()).unwrap();
        let parsed = parse_properties(&text);
        let clean = !parsed.has_errors();
        if let Err(diagnostics) = resolve_properties(&parsed.tree, &model, &Constants::new()) {
            prop_assert!(!clean || diagnostics.iter().all(|d| d.code != "unreadable"), "{}", text);
        }
    }

    #[test]
    fn no_characters_make_the_reader_panic(text in "\\PC{0,60}") {
        parse_model(&text);
        parse_properties(&text);
    }
}
