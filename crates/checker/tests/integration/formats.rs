//! Explicit files: what is written reads back to the same, for every model of the corpus; mistakes have a line.

use std::path::Path;

use checker::explore::explore;
use checker::formats::{Explicit, ExplicitFiles, Written, read_drn, read_explicit};
use checker::state_space::StateSpace;
use prism_lang::resolved::ModelType;
use prism_lang::{Arithmetic, Constants, Rational, parse_model, resolve};

/// All files of a state space: transitions, states, labels, and for each structure state and transition rewards.
fn written<N: Arithmetic + Written>(space: &StateSpace<N>, labels: &[&str]) -> Vec<String> {
    let explicit = Explicit::new(space);
    let mut files = vec![Vec::new(); 3];
    explicit.write_transitions(&mut files[0]).unwrap();
    explicit.write_states(&mut files[1]).unwrap();
    let labels: Vec<_> = (labels.iter())
        .map(|name| ((*name).to_owned(), space.label(name).unwrap()))
        .collect();
    explicit.write_labels(&labels, &mut files[2]).unwrap();
    for index in 0..space.num_rewards() {
        let Ok(rewards) = space.rewards(index) else {
            continue;
        };
        let (mut of_states, mut of_transitions) = (Vec::new(), Vec::new());
        explicit
            .write_state_rewards(index, rewards, &mut of_states)
            .unwrap();
        explicit
            .write_transition_rewards(index, rewards, &mut of_transitions)
            .unwrap();
        files.extend([of_states, of_transitions]);
    }
    files
        .into_iter()
        .map(|f| String::from_utf8(f).unwrap())
        .collect()
}

fn round_trip<N: Arithmetic + Written>(text: &str, name: &str) {
    let tree = parse_model(text).into_result().expect("it parses");
    let Ok(model) = resolve(&tree, &Constants::new()) else {
        return; // Needs constants.
    };
    let Ok(space) = explore::<N>(&model) else {
        return; // Irrational.
    };
    if space.num_states() > 10_000 {
        return;
    }
    let labels: Vec<&str> = model.labels.iter().map(|(name, _)| name.as_str()).collect();
    let files = written(&space, &labels);
    let rewards = files[3..]
        .chunks(2)
        .map(|pair| (pair[0].as_str(), pair[1].as_str()));
    let read = read_explicit::<N>(&ExplicitFiles {
        kind: None,
        transitions: &files[0],
        states: Some(&files[1]),
        labels: Some(&files[2]),
        rewards: rewards.collect(),
    });
    let read = read.unwrap_or_else(|e| panic!("{name}: {e}\n{}", files[e.line.min(1)]));
    assert_eq!(read.kind, space.kind);
    // A deadlock is known by its label only; the files have its self-loop.
    let again: Vec<String> = written(&read, &labels);
    for (before, after) in files.iter().zip(&again) {
        if !before.starts_with("# Labels") {
            assert_eq!(before, after, "{name}");
        }
    }
    let drn = |space: &StateSpace<N>| {
        let labels = labels
            .iter()
            .map(|l| ((*l).to_owned(), space.label(l).unwrap()));
        let mut file = Vec::new();
        Explicit::new(space)
            .write_drn(&labels.collect::<Vec<_>>(), &mut file)
            .unwrap();
        String::from_utf8(file).unwrap()
    };
    let first = drn(&space);
    let read = read_drn::<N>(&first).unwrap_or_else(|e| panic!("{name}: {e}"));
    // A label that holds nowhere is not in the file.
    if labels.iter().all(|l| read.label(l).is_ok()) {
        assert_eq!(drn(&read), first, "{name}");
    }
}

#[test]
fn files_of_the_corpus_read_back_to_the_same() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/models");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the corpus") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|e| e == "prism") {
            let text = std::fs::read_to_string(&path).expect("a text");
            round_trip::<f64>(&text, &path.display().to_string());
            round_trip::<Rational>(&text, &path.display().to_string());
            count += 1;
        }
    }
    assert!(count > 15, "{count}");
    let body = "module m x : [-1..2]; b : bool; [a] x<1 -> (x'=x+1)&(b'=!b); [] x=1 -> (x'=-1); endmodule
        label \"l\" = b; rewards \"r\" b : 1/3; [a] true : x-2; endrewards rewards x>0 : 5; endrewards";
    for kind in ["dtmc", "ctmc", "mdp", ""] {
        round_trip::<Rational>(&format!("{kind} {body}"), kind);
        round_trip::<f64>(&format!("{kind} {body}"), kind);
    }
}

#[test]
fn kinds_deadlocks_and_initial_states_are_read() {
    let files = ExplicitFiles {
        kind: Some(ModelType::Ctmc),
        transitions: "3 3\n0 1 2.5\n1 0 1/3\n1 2 4",
        labels: Some("0=\"init\" 1=\"goal\"\n1: 0\n2: 1"),
        ..ExplicitFiles::default()
    };
    let space = read_explicit::<Rational>(&files).unwrap();
    assert_eq!(
        (space.initial_states(), space.deadlocks()),
        (&[1][..], &[2][..])
    );
    assert_eq!(space.matrix.row(2).count(), 1);
    assert_eq!(space.label("goal"), Ok(vec![false, false, true]));
}

#[test]
fn mistakes_are_told_with_file_and_line() {
    let refused = |files: ExplicitFiles<'_>| {
        let error = read_explicit::<f64>(&files).unwrap_err();
        (error.file, error.line, error.message)
    };
    let tra = |transitions| ExplicitFiles {
        transitions,
        ..ExplicitFiles::default()
    };
    let good = "2 2\n0 1 1\n1 1 1";
    for (files, file, line, word) in [
        (tra(""), "tra", 1, "first line"),
        (tra("900000000000 1\n0 0 1"), "tra", 1, "not enough lines"),
        (tra("two states"), "tra", 1, "numbers"),
        (tra("2 2\n0 2 1"), "tra", 2, "state must be"),
        (tra("2 2\n0 1 p"), "tra", 2, "expected a number"),
        (tra("2 2\n# here\n0 1 -1"), "tra", 3, "negative"),
        (tra("2 2\n0 1 0.5\n1 1 1"), "tra", 1, "sum to 0.5"),
        (tra("2 3\n0 1 0.5\n0 1 0.5\n1 1 1"), "tra", 1, "add them up"),
        (tra("2 2 2\n0 5 1 1\n1 0 1 1"), "tra", 2, "choice must be"),
        (
            ExplicitFiles {
                states: Some("(x)\n0:(1)\n7:(2)"),
                ..tra(good)
            },
            "sta",
            3,
            "below 2",
        ),
        (
            ExplicitFiles {
                states: Some("(x)\n0:(1)"),
                ..tra(good)
            },
            "sta",
            1,
            "no line",
        ),
        (
            ExplicitFiles {
                states: Some("(x,y)\n0:(1)"),
                ..tra(good)
            },
            "sta",
            2,
            "2 values",
        ),
        (
            ExplicitFiles {
                labels: Some("0=init"),
                ..tra(good)
            },
            "lab",
            1,
            "is not like",
        ),
        (
            ExplicitFiles {
                labels: Some("0=\"init\"\n0: 3"),
                ..tra(good)
            },
            "lab",
            2,
            "no label",
        ),
        (
            ExplicitFiles {
                rewards: vec![("2 1\n0 x", "")],
                ..tra(good)
            },
            "srew",
            2,
            "expected a number",
        ),
        (
            ExplicitFiles {
                rewards: vec![("", "2 1\n0 0 1")],
                ..tra(good)
            },
            "trew",
            2,
            "no such",
        ),
    ] {
        let found = refused(files);
        assert_eq!((found.0, found.1), (file, line), "{}", found.2);
        assert!(found.2.contains(word), "{}", found.2);
    }
}

#[test]
fn mistakes_in_drn_files_have_a_line() {
    let head =
        "@type: MDP\n@parameters\n\n@reward_models\nr\n@nr_states\n2\n@nr_choices\n2\n@model\n";
    let good = "state 0 [1] init\naction a [0]\n1 : 1\nstate 1 [0]\naction 0 [2]\n1 : 1";
    assert!(read_drn::<f64>(&format!("{head}{good}")).is_ok());
    for (from, to, line, word) in [
        ("0 [1] init", "0 [1, 2] init", 11, "expected 1 rewards"),
        ("0 [1] init", "0 [1] start", 16, "`init`"),
        ("1 : 1", "1 : 0.5", 16, "sum to 0.5"),
        ("1 : 1", "7 : 1", 13, "number of a state"),
        ("1 : 1", "1 : -1", 13, "negative"),
        ("1 : 1", "1 : x", 13, "expected a number"),
        ("state 1", "state 2", 14, "not the next"),
        ("[2]", "[2", 15, "without `]`"),
        ("action a", "act a", 12, "unknown line"),
    ] {
        let error = read_drn::<f64>(&format!("{head}{}", good.replacen(from, to, 1))).unwrap_err();
        assert_eq!((error.file, error.line), ("drn", line), "{error}");
        assert!(error.message.contains(word), "{error}");
    }
    assert!(
        read_drn::<f64>("@type: POMDP\n")
            .unwrap_err()
            .message
            .contains("pomdp")
    );
}
