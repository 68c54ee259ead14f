//! Each template reads, compiles to every form, and is judged right on traces made by hand: through
//! units, parameters and predicates of `trace`, and the engine of `temporal`.

use std::collections::BTreeSet;

use requirement_lang::compile::coverage::bins;
use requirement_lang::compile::goal::{model_goal, trace_goal};
use requirement_lang::compile::monitor::monitor;
use requirement_lang::compile::property::{Model, property};
use requirement_lang::library::SeparationTerms;
use requirement_lang::library::{
    BODY_REGIONS, Instance, Template, TemplateError, protective_separation_distance_m, template,
    templates,
};
use temporal::formula::{Ending, FormulaMonitor, TimeModel, Verdict};
use trace::{BoundPredicate, Cursor, Field, Trace, Vocabulary};

/// Two traces with a sample every 100 ms: for each need of the template its values, in its unit.
struct Case {
    template: &'static str,
    /// Values for parameters without a default.
    given: &'static [(&'static str, &'static str)],
    satisfying: &'static [&'static [f64]],
    violating: &'static [&'static [f64]],
    /// How often the requirement is triggered in the two traces.
    triggered: [u64; 2],
}

const CASES: &[Case] = &[
    Case {
        template: "separation-constant",
        given: &[("protective_distance", "1.15 m")],
        satisfying: &[&[1.0, 1.0, 0.0], &[2.0, 1.15, 0.3]],
        violating: &[&[1.0, 1.0, 0.0], &[2.0, 1.149, 0.3]],
        triggered: [1, 1],
    },
    Case {
        // 1.6 * 0.4 + 1 * 0.1 + 0.15 + 0.2 + 0.05 + 0.01 = 1.15 at 1 m/s, and 1.05 at rest.
        template: "separation-walking-person",
        given: &[],
        satisfying: &[&[1.0, 1.0], &[1.151, 1.06], &[1.0, 0.0]],
        violating: &[&[1.0, 1.0], &[1.151, 1.06], &[1.0, 0.5]],
        triggered: [1, 1],
    },
    Case {
        template: "separation-measured-person",
        given: &[],
        satisfying: &[&[1.0, 1.0], &[1.151, 0.52], &[1.6, 0.0], &[1.0, 1.0]],
        violating: &[&[1.0, 1.0], &[1.151, 0.5], &[1.6, 0.0], &[1.0, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "reduced-speed-near-person",
        given: &[],
        satisfying: &[&[1.0, 0.4, 0.4, 0.6], &[1.0, 0.25, 0.1, 1.0]],
        violating: &[&[1.0, 0.4, 0.4, 0.6], &[1.0, 0.25, 0.26, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "reduced-speed-in-mode",
        given: &[],
        satisfying: &[&[0.0, 1.0, 1.0, 0.0], &[1.0, 0.2, 0.25, 1.0]],
        violating: &[&[0.0, 1.0, 1.0, 0.0], &[1.0, 0.2, 0.3, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "start-in-reduced-speed",
        given: &[],
        satisfying: &[&[0.0, 0.0, 1.0], &[0.2, 0.2, 1.0]],
        violating: &[&[0.0, 0.0, 1.0], &[0.2, 0.3, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "no-unexpected-start",
        given: &[],
        satisfying: &[&[0.0, 0.0, 1.0], &[0.0, 0.005, 1.0]],
        violating: &[&[0.0, 0.0, 1.0], &[0.0, 0.1, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "restricted-zone",
        given: &[("zone_margin", "10 cm")],
        satisfying: &[&[1.0, 0.1, 0.5]],
        violating: &[&[1.0, 0.09, 0.5]],
        triggered: [1, 1],
    },
    Case {
        template: "hand-closes-away-from-person",
        given: &[],
        satisfying: &[&[0.0, 1.0, 1.0], &[0.01, 0.06, 0.01]],
        violating: &[&[0.0, 1.0, 1.0], &[0.06, 0.05, 0.06]],
        triggered: [1, 1],
    },
    Case {
        template: "holds-until-released",
        given: &[],
        satisfying: &[
            &[0.0, 1.0, 1.0, 1.0],
            &[0.0, 0.0, 0.0, 1.0],
            &[0.0, 1.0, 1.0, 0.0],
        ],
        violating: &[
            &[0.0, 1.0, 1.0, 1.0],
            &[0.0, 0.0, 0.0, 1.0],
            &[0.0, 1.0, 0.0, 0.0],
        ],
        triggered: [1, 1],
    },
    Case {
        template: "release-in-time",
        given: &[("release_time", "200 ms")],
        satisfying: &[&[0.0, 1.0, 1.0, 1.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0]],
        violating: &[&[0.0, 1.0, 1.0, 1.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "stop-within-time",
        given: &[("stopping_time", "0.2 s")],
        satisfying: &[&[0.0, 1.0, 1.0, 1.0], &[1.0, 1.0, 0.5, 0.001]],
        violating: &[&[0.0, 1.0, 1.0, 1.0], &[1.0, 1.0, 0.5, 0.1]],
        triggered: [1, 1],
    },
    Case {
        template: "stop-within-distance",
        given: &[],
        satisfying: &[
            &[0.0, 1.0, 1.0, 0.0],
            &[0.0, 0.0, 0.0, 1.0],
            &[9.0, 0.0, 0.2, 0.5],
        ],
        violating: &[
            &[0.0, 1.0, 1.0, 0.0],
            &[0.0, 0.0, 0.0, 1.0],
            &[9.0, 0.0, 0.3, 0.5],
        ],
        triggered: [1, 1],
    },
    Case {
        template: "no-unexpected-restart",
        given: &[("stopping_time", "0.1 s")],
        satisfying: &[
            &[0.0, 1.0, 0.0, 0.0, 0.0],
            &[0.0, 0.0, 0.0, 0.0, 1.0],
            &[1.0, 1.0, 0.0, 0.0, 1.0],
        ],
        violating: &[
            &[0.0, 1.0, 0.0, 0.0, 0.0],
            &[0.0, 0.0, 0.0, 0.0, 1.0],
            &[1.0, 1.0, 0.0, 0.1, 1.0],
        ],
        triggered: [1, 1],
    },
    Case {
        template: "monitored-stop",
        given: &[("stopping_time", "0.1 s")],
        satisfying: &[
            &[0.0, 1.0, 1.0, 1.0, 0.0, 1.0],
            &[1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
        ],
        violating: &[
            &[0.0, 1.0, 1.0, 1.0, 0.0, 1.0],
            &[1.0, 1.0, 0.0, 1.0, 1.0, 0.0],
        ],
        triggered: [2, 2],
    },
    Case {
        template: "hold-to-run",
        given: &[("stopping_time", "0.1 s")],
        satisfying: &[&[1.0, 0.0, 0.0, 0.0, 1.0], &[1.0, 1.0, 0.0, 0.0, 1.0]],
        violating: &[&[1.0, 0.0, 0.0, 0.0, 1.0], &[1.0, 1.0, 1.0, 0.0, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "stop-on-communication-loss",
        given: &[("stopping_time", "0.1 s")],
        satisfying: &[&[0.2, 0.3, 0.4, 0.5], &[1.0, 1.0, 0.0, 0.0]],
        violating: &[&[0.2, 0.3, 0.4, 0.5], &[1.0, 1.0, 1.0, 0.0]],
        triggered: [1, 1],
    },
    Case {
        template: "transient-force",
        given: &[],
        satisfying: &[&[0.0, 280.0, 0.0]],
        violating: &[&[0.0, 281.0, 0.0]],
        triggered: [1, 1],
    },
    Case {
        template: "quasi-static-force",
        given: &[],
        satisfying: &[&[0.0, 200.0, 200.0, 200.0, 200.0, 200.0, 140.0]],
        violating: &[&[0.0, 200.0, 200.0, 200.0, 200.0, 200.0, 141.0]],
        triggered: [1, 1],
    },
    Case {
        template: "transient-pressure",
        given: &[("transient_pressure", "600 N/cm^2")],
        satisfying: &[&[0.0, 600.0]],
        violating: &[&[0.0, 601.0]],
        triggered: [1, 1],
    },
    Case {
        template: "quasi-static-pressure",
        given: &[
            ("quasi_static_pressure", "3 MPa"),
            ("transient_time", "100 ms"),
        ],
        satisfying: &[&[0.0, 301.0, 300.0]],
        violating: &[&[0.0, 301.0, 301.0]],
        triggered: [1, 1],
    },
    Case {
        template: "contact-released",
        given: &[("freeing_time", "0.1 s")],
        satisfying: &[&[0.0, 30.0, 4.0, 10.0, 10.0], &[0.0, 0.0, 0.0, 0.0, 1.0]],
        violating: &[&[0.0, 30.0, 4.0, 21.0, 4.0], &[0.0, 0.0, 0.0, 0.0, 1.0]],
        triggered: [1, 2],
    },
    Case {
        template: "mobile-speed-near-person",
        given: &[],
        satisfying: &[&[2.0, 1.0, 2.0], &[1.0, 0.3, 1.0]],
        violating: &[&[2.0, 1.0, 2.0], &[1.0, 0.31, 1.0]],
        triggered: [1, 1],
    },
    Case {
        template: "obstacle-clearance",
        given: &[],
        satisfying: &[&[1.0, 1.0, 0.0], &[0.5, 0.1, 0.0]],
        violating: &[&[1.0, 1.0, 0.0], &[0.5, 0.09, 0.0]],
        triggered: [1, 1],
    },
    Case {
        template: "mobile-stops-before-person",
        given: &[("stopping_time", "0.1 s")],
        satisfying: &[&[1.0, 0.4, 0.6, 0.4, 0.4], &[1.0, 1.0, 1.0, 1.0, 0.0]],
        violating: &[&[1.0, 0.4, 0.4, 0.4, 0.4], &[1.0, 1.0, 1.0, 1.0, 0.0]],
        triggered: [2, 1],
    },
];

/// A trace with a signal for each need, and a vocabulary that binds the needs to them.
fn recording(template: &Template, columns: &[&[f64]], instance: &Instance) -> (Trace, Vocabulary) {
    assert_eq!(
        columns.len(),
        template.needs.len(),
        "columns of {}",
        template.id
    );
    let field = |need: &requirement_lang::library::Need| match need.unit {
        Some(unit) => Field::number(need.name, unit),
        None => Field::bool(need.name),
    };
    let mut trace = Trace::new();
    let channel = trace
        .add_channel("/s", template.needs.iter().map(field).collect())
        .unwrap();
    for row in 0..columns[0].len() {
        let values: Vec<f64> = columns.iter().map(|column| column[row]).collect();
        trace.channels[channel]
            .push(row as f64 * 0.1, &values)
            .unwrap();
    }
    let entries = template
        .needs
        .iter()
        .map(|need| (need.name, format!("/s.{}", need.name)));
    let vocabulary = Vocabulary::with_parameters(entries, instance.parameters.clone()).unwrap();
    (trace, vocabulary)
}

/// The verdict at the end of the trace, and the number of triggers.
fn judge(case: &Case, columns: &[&[f64]]) -> (Verdict, u64) {
    let template = template(case.template).unwrap();
    let instance = template.instantiate(case.given).unwrap();
    let (trace, vocabulary) = recording(template, columns, &instance);
    let form = monitor(&instance.sentence).unwrap();
    let bind = |text: &str| vocabulary.predicate(text).unwrap().bind(&trace).unwrap();
    let atoms: Vec<BoundPredicate> = form
        .requirement
        .atoms
        .iter()
        .map(|atom| bind(&atom.text))
        .collect();
    let settings = form.settings(TimeModel::Discrete, Ending::Finite);
    let engine = FormulaMonitor::compile(&form.requirement.formula, &settings).unwrap();
    let mut judge = engine.start();
    let mut cursor = Cursor::new(&trace);
    for row in 0..columns[0].len() {
        let time_secs = row as f64 * 0.1;
        cursor.seek(time_secs);
        let truth: Vec<Option<bool>> = atoms.iter().map(|atom| atom.eval(&cursor)).collect();
        assert!(truth.iter().all(Option::is_some), "{form}");
        judge.step_truth(time_secs, &truth).unwrap();
    }
    let report = judge.finish(true);
    (report.verdict, report.triggered)
}

#[test]
fn templates_are_judged_right_on_traces_made_by_hand() {
    for case in CASES {
        let (verdict, triggered) = judge(case, case.satisfying);
        assert_eq!(
            (verdict, triggered),
            (Verdict::Satisfied, case.triggered[0]),
            "{}",
            case.template
        );
        let (verdict, triggered) = judge(case, case.violating);
        assert_eq!(
            (verdict, triggered),
            (Verdict::Violated, case.triggered[1]),
            "{}",
            case.template
        );
    }
}

#[test]
fn every_template_is_judged_and_no_identifier_is_used_twice() {
    let ids: Vec<&str> = templates().map(|template| template.id).collect();
    let distinct: BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(distinct.len(), ids.len());
    let judged: BTreeSet<&str> = CASES.iter().map(|case| case.template).collect();
    assert_eq!(judged, distinct);
}

#[test]
fn templates_compile_to_every_form_and_name_all_that_they_use() {
    for case in CASES {
        let template = template(case.template).unwrap();
        let instance = template.instantiate(case.given).unwrap();
        let model = Model {
            step_secs: Some(0.01),
            proposition: &|text| Some(format!("\"{text}\"")),
        };
        let property = property(&instance.sentence, &model).unwrap();
        assert!(
            property.requirement().starts_with("P>=1 ["),
            "{}",
            template.id
        );
        assert!(
            model_goal(&instance.sentence, &model)
                .unwrap()
                .witness
                .starts_with("P>0 [")
        );
        assert!(trace_goal(&instance.sentence).is_ok());
        assert!(bins(&instance.sentence).unwrap().len() >= 3);

        // Every name in the text is a parameter or a need, and each of these is used.
        let mut words: BTreeSet<&str> = BTreeSet::new();
        for text in instance.sentence.propositions() {
            let names = text.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
            words.extend(names.filter(|name| name.starts_with(char::is_alphabetic)));
        }
        let durations = instance
            .sentence
            .stages
            .iter()
            .filter_map(|stage| stage.timing.duration());
        words.extend(durations.map(|duration| duration.text.as_str()));
        let declared = template
            .parameters
            .iter()
            .map(|declaration| declaration.name);
        let known: BTreeSet<&str> = declared
            .chain(template.needs.iter().map(|need| need.name))
            .collect();
        assert_eq!(words, known, "{}", template.id);
    }
}

#[test]
fn defaults_are_within_their_ranges_and_values_outside_are_refused() {
    for template in templates() {
        for declaration in template.parameters {
            for text in declaration
                .default
                .into_iter()
                .chain([declaration.least, declaration.most])
            {
                assert_eq!(
                    declaration.check(text),
                    Ok(()),
                    "{} of {}",
                    declaration.name,
                    template.id
                );
            }
        }
    }
    let near = template("reduced-speed-near-person").unwrap();
    let refused = near
        .instantiate(&[("reduced_speed", "0.26 m/s")])
        .unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the parameter reduced_speed cannot be 0.26 m/s; give a value from 1 mm/s to 250 mm/s"
    );
    assert!(near.instantiate(&[("reduced_speed", "0.25 m/s")]).is_ok());
    let unknown = near
        .instantiate(&[("reduced_sped", "0.2 m/s")])
        .unwrap_err();
    assert!(
        unknown.to_string().ends_with("did you mean reduced_speed?"),
        "{unknown}"
    );
    let missing = template("separation-constant")
        .unwrap()
        .instantiate(&[])
        .unwrap_err();
    assert!(matches!(
        missing,
        TemplateError::Missing {
            name: "protective_distance",
            ..
        }
    ));
    let twice = near.instantiate(&[("reduced_speed", "0.2 m/s"), ("reduced_speed", "0.1 m/s")]);
    assert!(matches!(twice, Err(TemplateError::Twice { .. })));
}

#[test]
fn the_speed_dependent_sentence_is_the_formula_of_the_constant_one() {
    // Where the sentence of the walking person changes its truth is the function's value.
    let case = CASES
        .iter()
        .find(|case| case.template == "separation-walking-person")
        .unwrap();
    for speed in [0.0, 0.25, 1.0, 2.0] {
        let distance_m = protective_separation_distance_m(&SeparationTerms {
            person_speed_m_s: 1.6,
            robot_speed_m_s: speed,
            reaction_time_secs: 0.1,
            braking_time_secs: 0.3,
            braking_distance_m: 0.15,
            intrusion_m: 0.2,
            person_uncertainty_m: 0.05,
            robot_uncertainty_m: 0.01,
        });
        let (verdict, _) = judge(case, &[&[1.0], &[distance_m + 1e-9], &[speed]]);
        assert_eq!(verdict, Verdict::Satisfied, "{speed} m/s");
        let (verdict, _) = judge(case, &[&[1.0], &[distance_m - 1e-9], &[speed]]);
        assert_eq!(verdict, Verdict::Violated, "{speed} m/s");
    }
}

#[test]
fn the_defaults_of_contact_forces_are_those_of_the_hand() {
    let hand = BODY_REGIONS
        .iter()
        .find(|region| region.name == "hands and fingers")
        .unwrap();
    let value = |id: &str, name: &str| {
        let instance = template(id).unwrap().instantiate(&[]).unwrap();
        instance.parameters.get(name).unwrap().si_value()
    };
    assert_eq!(
        value("quasi-static-force", "quasi_static_force"),
        hand.quasi_static_force_n
    );
    assert_eq!(
        Some(value("transient-force", "transient_force")),
        hand.transient_force_n()
    );
    // Where the range of the parameters ends, no region of the body permits more.
    let greatest = BODY_REGIONS
        .iter()
        .map(|region| region.quasi_static_force_n)
        .fold(0.0, f64::max);
    assert_eq!(greatest, 220.0);
}
