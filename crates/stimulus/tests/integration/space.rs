//! Spaces and stimuli as a user writes them.

use proptest::prelude::*;
use stimulus::{
    AbstractTest, Action, Distribution, Setting, Settings, Space, Stimulus, StimulusError,
};

const SPACE: &str = r#"
[[parameter]]
name = "pull"
sets = ["human.pull_newtons", "sensor.expected_newtons"]
unit = "N"
uniform = [1.0, 15.0]
nominal = 8

[[parameter]]
name = "helper"
sets = ["human.helper"]
boolean = 0.25

[[parameter]]
name = "surface"
sets = ["hand.surface"]
choice = ["clean", "dusty"]
weights = [3, 1]

[[parameter]]
name = "tries"
sets = ["robot.tries"]
integer = [1, 3]

[[constraint]]
sum = { pull = 1.0, tries = -5.0 }
at_most = 5.0
"#;

#[test]
fn a_point_becomes_settings() {
    let space = Space::from_toml(SPACE).unwrap();
    let point = space.at(&[0.5, 0.8, 0.9, 0.1]);
    assert_eq!(point.0, [8.0, 1.0, 1.0, 1.0]);
    let settings = space.settings(&point).unwrap();
    let expected = [
        ("hand.surface", Setting::from("dusty")),
        ("human.helper", Setting::from(true)),
        ("human.pull_newtons", Setting::from(8.0)),
        ("robot.tries", Setting::from(1.0)),
        ("sensor.expected_newtons", Setting::from(8.0)),
    ];
    let expected = expected.map(|(key, value)| (key.to_owned(), value));
    assert_eq!(settings, expected.into());
    assert_eq!(space.nominal().0, [8.0, 0.0, 0.0, 2.0]);
    assert_eq!(space.point_of(&settings), Some(point));
    assert_eq!(space.point_of(&Settings::new()), Some(space.nominal()));
    let wrong = [
        ("human.helper", Setting::from(1.0)),
        ("human.pull_newtons", Setting::from(1.0)),
    ];
    for (key, value) in wrong {
        let mut settings = settings.clone();
        settings.insert(key.to_owned(), value);
        assert_eq!(space.point_of(&settings), None, "{key}");
    }
    assert_eq!(space.parameters[0].shown(8.0), "8 N");
    assert_eq!(space.parameters[2].shown(1.0), "dusty");
}

#[test]
fn constraints_and_supports_are_kept_apart_from_the_rest() {
    let space = Space::from_toml(SPACE).unwrap();
    let point = |pull: f64, tries: f64| stimulus::Point(vec![pull, 0.0, 0.0, tries]);
    assert!(space.allows(&point(10.0, 1.0)));
    assert!(!space.allows(&point(10.1, 1.0)));
    assert!(space.allows(&point(10.1, 2.0)));
    assert!(!space.allows(&point(16.0, 3.0)) && !space.allows(&point(8.0, 1.5)));
    assert!(!space.allows(&stimulus::Point(vec![8.0])));
}

#[test]
fn a_space_is_written_as_it_is_read() {
    let space = Space::from_toml(SPACE).unwrap();
    let text = toml::to_string(&space).unwrap();
    assert_eq!(Space::from_toml(&text).unwrap(), space);
    let json = serde_json::to_string(&space).unwrap();
    assert_eq!(serde_json::from_str::<Space>(&json).unwrap(), space);
}

#[test]
fn mistakes_in_a_space_are_named() {
    for (from, to, expected) in [
        (
            "nominal = 8",
            "nominal = 80",
            "`pull`: its nominal value 80 cannot come",
        ),
        (
            "unit = \"N\"",
            "unti = \"N\"",
            "unknown key `unti`; did you mean `unit`?",
        ),
        (
            "uniform = [1.0, 15.0]",
            "",
            "parameter `pull`: give one of constant, uniform",
        ),
        (
            "name = \"helper\"",
            "name = \"pull\"",
            "`pull`: the name is given to two",
        ),
        (
            "\"robot.tries\"",
            "\"hand.surface\"",
            "`surface` sets already",
        ),
        ("\"robot.tries\"", "", "`sets` names no key"),
        (
            "\"robot.tries\"",
            "\"robot..tries\"",
            "is not a valid dotted key",
        ),
        ("tries = -5.0", "tires = -5.0", "no such parameter"),
        ("at_most = 5.0", "", "at_least or at_most"),
        ("at_most = 5.0", "at_most = 5.0\nat_least = 6", "lies above"),
        ("boolean = 0.25", "boolean = yes", "line 12, column 11"),
    ] {
        assert!(SPACE.contains(from), "{from}");
        let error = Space::from_toml(&SPACE.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
}

fn test() -> AbstractTest {
    AbstractTest::new(
        "typical",
        vec![
            Action::send("activate").after(Distribution::Uniform {
                low: 0.5,
                high: 6.5,
            }),
            Action::receive("announcement"),
            Action::set("gaze", true),
        ],
    )
}

#[test]
fn delays_are_parameters_too() {
    let space = Space::default().with_delays_of(&test());
    assert_eq!(space.dimensions(), 1);
    assert_eq!(
        space.parameters[0].name,
        "delay before action 0 (send activate)"
    );
    let stimulus = space.stimulus(&test(), &space.at(&[0.25])).unwrap();
    assert_eq!(
        stimulus.test.actions[0].after_secs,
        Distribution::Constant(2.0)
    );
    assert!(stimulus.settings.is_empty());
    assert_eq!(space.with_delays_of(&test()), space);
}

#[test]
fn a_parameter_can_set_a_value_of_the_test() {
    let parameter = |key: &str| {
        let text = format!("[[parameter]]\nname = \"p\"\nsets = [\"{key}\"]\nboolean = 0.5");
        let space = Space::from_toml(&text).unwrap();
        space.stimulus(&test(), &space.at(&[0.1]))
    };
    let stimulus = parameter("test.actions.2.set_param.gaze").unwrap();
    assert_eq!(stimulus.test.actions[2], Action::set("gaze", false));
    for wrong in [
        "test.actions.2.set_param.location",
        "test.actions.1.set_param.gaze",
        "test.actions.3.set_param.gaze",
        "test.name",
    ] {
        let error = parameter(wrong).unwrap_err();
        assert!(
            matches!(error, StimulusError::UnknownKey { .. }),
            "{wrong}: {error}"
        );
    }
    let error = parameter("test.actions.0.after_secs").unwrap_err();
    assert!(matches!(error, StimulusError::Unsettable { .. }));
}

#[test]
fn actions_are_checked_where_they_are_read() {
    for (action, expected) in [
        (
            "{ send_signal = \"a\", receive_signal = \"b\" }",
            "exactly one of",
        ),
        ("{ after_secs = 1.0 }", "exactly one of"),
        (
            "{ send_signal = \"a\", after_secs = -1.0 }",
            "a delay starts at 0",
        ),
        ("{ send_signal = \"\" }", "without a name"),
        ("{ set_param = {} }", "without a name"),
        ("{ set_param = { a = nan } }", "finite"),
        ("{ send = \"a\" }", "unknown field `send`"),
    ] {
        let text = format!("[test]\nname = \"t\"\nactions = [{action}]");
        let error = Stimulus::from_toml(&text).unwrap_err().to_string();
        assert!(
            error.contains(expected) && error.contains("line 3"),
            "{action}: {error}"
        );
    }
    assert!(
        Stimulus::from_json("{\"test\": 1}")
            .unwrap_err()
            .to_string()
            .contains("line 1")
    );
}

#[test]
fn names_do_not_count_as_content() {
    let one = Stimulus::of(test());
    let mut other = one.clone();
    other.test.name = "other".to_owned();
    assert_ne!(one.hash(), other.hash());
    assert_eq!(one.content_hash(), other.content_hash());
    other.test.actions.pop();
    assert_ne!(one.content_hash(), other.content_hash());
}

fn any_setting() -> impl Strategy<Value = Setting> {
    prop_oneof![
        any::<bool>().prop_map(Setting::Bool),
        prop::num::f64::NORMAL.prop_map(Setting::Number),
        (-1000_i32..1000).prop_map(|n| Setting::Number(f64::from(n))),
        "\\PC*".prop_map(Setting::Text),
    ]
}

fn any_action() -> impl Strategy<Value = Action> {
    let verb = prop_oneof![
        "\\PC+".prop_map(|signal| Action::send(&signal)),
        "\\PC+".prop_map(|signal| Action::receive(&signal)),
        ("\\PC+", any_setting()).prop_map(|(name, value)| Action::set(&name, value)),
    ];
    (verb, 0.0..9.0).prop_map(|(action, high)| match high {
        high if high < 3.0 => action,
        high if high < 6.0 => action.after(Distribution::Constant(high)),
        high => action.after(Distribution::Uniform { low: 0.0, high }),
    })
}

proptest! {
    #[test]
    fn stimuli_are_read_back_from_both_forms(
        name in "\\PC*",
        actions in prop::collection::vec(any_action(), 0..5),
        settings in prop::collection::btree_map("\\PC*", any_setting(), 0..4),
    ) {
        let stimulus = Stimulus { test: AbstractTest::new(name, actions), settings };
        prop_assert_eq!(&Stimulus::from_toml(&stimulus.to_toml()).unwrap(), &stimulus);
        prop_assert_eq!(&Stimulus::from_json(&stimulus.to_json()).unwrap(), &stimulus);
    }
}
