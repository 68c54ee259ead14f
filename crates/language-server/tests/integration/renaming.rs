//! Another name everywhere, and nothing else changed.

use crate::support::{files_below, root, with};
use checker::explore::{ExploreOptions, explore, explore_with};
use checker::{Guarantee, Options, check};
use language_server::mentions::Thing;
use language_server::{Alone, Workspace, cursor, kind, rename};
use prism_lang::names::Role;
use prism_lang::{Constants, parse_model, resolve, resolve_properties};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const MODEL: &str = "/models/m.prism";

fn renamed(text: &str, needle: &str, new: &str) -> Result<String, String> {
    let workspace = with(MODEL, text);
    let at = text.find(needle).expect("the place");
    let places = rename::rename(&workspace, Path::new(MODEL), at, new)?;
    Ok(rename::replaced(text, &places[Path::new(MODEL)], new))
}

#[test]
fn a_name_is_changed_where_it_is_meant_and_nowhere_else() {
    let text = "mdp // x stays
module a
  x : [0..1]; // x
  [x] x=0 -> (x'=1);
endmodule
label \"x\" = x=1;
rewards \"x\" [x] x=0 : 1; endrewards";
    let expected = "mdp // x stays
module a
  y : [0..1]; // x
  [x] y=0 -> (y'=1);
endmodule
label \"x\" = y=1;
rewards \"x\" [x] y=0 : 1; endrewards";
    assert_eq!(renamed(text, "x : [", "y").as_deref(), Ok(expected));
    let of_action = renamed(text, "x] x=0 ->", "y").expect("free");
    assert_eq!(of_action.matches("[y]").count(), 2);
    assert!(of_action.contains("x : [0..1]"));
}

#[test]
fn what_would_collide_or_be_caught_is_refused_with_the_reason() {
    let text = "mdp
const int n = 1;
module a x : [0..1]; [go] x=0 -> (x'=n); [x] true -> true; endmodule
module b = a [x=y, go=stop] endmodule";
    for (needle, new, reason) in [
        ("n = 1", "y", "already a name in m.prism, line 4"),
        ("n = 1", "module", "cannot be a name"),
        ("n = 1", "1n", "cannot be a name"),
        ("n = 1", "a b", "cannot be a name"),
        ("go]", "stop", "already a name"),
        ("go]", "y", "already a name"),
        ("n = 1", "go", "which would catch it"),
        ("x : [", "z", "as a value and as an action"),
        ("x=y", "z", "both a value and an action"),
        ("mdp", "z", "no name here"),
    ] {
        let refused = renamed(text, needle, new).expect_err(needle);
        assert!(refused.contains(reason), "{needle} -> {new}: {refused}");
    }
    let broken = renamed("dtmc const int n = 1; const int m = ;", "n = 1", "k");
    assert!(broken.expect_err("broken").contains("syntax errors"));
    let builtin = renamed("dtmc label \"a\" = true;", "a\"", "init");
    assert!(builtin.expect_err("built in").contains("cannot be a name"));
}

/// As in published models: a module with the name of a constant that its copy replaces, and entries that change nothing.
#[test]
fn what_copies_do_not_catch_can_be_renamed() {
    let text =
        "mdp const int e1 = 1; const int d1 = 2; module e1 x : [0..e1]; [] x=0 -> (x'=1); endmodule
module f1 = e1 [x=y, y=x, e1=d1] endmodule";
    let of_module = renamed(text, "e1 x", "g1").expect("free");
    assert!(
        of_module.contains("module g1 x : [0..e1]") && of_module.contains("= g1 [x=y, y=x, e1=d1]")
    );
    let of_variable = renamed(text, "x : [", "z").expect("free");
    assert!(of_variable.contains("[z=y, y=z, e1=d1]"), "{of_variable}");
    assert_eq!(renamed(&of_variable, "z : [", "x").as_deref(), Ok(text));
}

#[test]
fn property_files_are_renamed_with_their_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a path");
    let (model, file) = (folder.join("m.prism"), folder.join("m.props"));
    let mut workspace = Workspace::new(Box::new(Alone));
    let text = "dtmc const int n; module m x : bool; endmodule // é".to_owned();
    workspace.open(&model, &(text.clone() + "\nlabel \"up\" = x;"));
    let asked = "const int k; // é\n\"a\": P=? [ F<=k+n \"up\" & x ]; \"a\" ; label \"down\" = !x;";
    workspace.open(&file, asked);
    let at = asked.find("x ]").unwrap();
    let places = rename::rename(&workspace, &file, at, "y").expect("free");
    assert_eq!((places[&model].len(), places[&file].len()), (2, 2));
    let at = asked.find("up").unwrap();
    let places = rename::rename(&workspace, &file, at, "above").expect("free");
    assert_eq!((places[&model].len(), places[&file].len()), (1, 1));
    // A name of its own is known in the file alone, but may not be one of the model.
    let at = asked.find("k;").unwrap();
    let places = rename::rename(&workspace, &file, at, "steps").expect("free");
    assert_eq!(places.keys().collect::<Vec<_>>(), [&file]);
    let at = asked.find("down").unwrap();
    assert!(rename::rename(&workspace, &file, at, "a").is_err());
    let at = text.find("n;").unwrap();
    assert!(
        rename::rename(&workspace, &model, at, "k")
            .unwrap_err()
            .contains("m.props")
    );
}

/// The models of the project that can be read.
fn models() -> Vec<(PathBuf, String)> {
    let folders = [
        "conformance/models",
        "case-studies",
        "crates/corroborate/templates",
    ];
    let files = folders.iter().flat_map(|it| files_below(&root().join(it)));
    let files = files.filter(|it| kind::Kind::of(it, None) == kind::Kind::Model);
    let read = files.filter_map(|it| Some((it.clone(), host::files::read_prism(&it).ok()?.0.text)));
    read.filter(|(_, text)| !parse_model(text).has_errors())
        .collect()
}

/// States, number of transitions, and in which states each label holds.
type Meaning = (Vec<Vec<i64>>, usize, Vec<Vec<bool>>);

/// A model's states, number of transitions and labels; `None` where it has too many states for a test, or has no meaning.
fn meaning(text: &str) -> Option<Meaning> {
    let model = resolve(&parse_model(text).tree, &Constants::new()).ok()?;
    let options = ExploreOptions {
        max_states: 3_000,
        ..ExploreOptions::default()
    };
    let space = explore_with::<f64>(&model, options, &|_| true).ok()?;
    let states = (0..space.num_states()).map(|it| space.state(it)).collect();
    let labels = model.labels.iter();
    let labels = labels.map(|(_, it)| space.evaluate(it).expect("a label"));
    Some((states, space.num_transitions(), labels.collect()))
}

/// Every name of every model of the project: renamed, read again, built again, renamed back.
#[test]
fn every_name_of_every_model_can_be_changed_and_changed_back() {
    let (mut names, mut refused) = (0, Vec::new());
    for (path, text) in models() {
        let workspace = alone(&text);
        let document = Path::new(MODEL);
        let mentions = cursor::in_file(&workspace, document);
        let things: BTreeSet<&Thing> = mentions.iter().map(|it| &it.thing).collect();
        let defined = |thing: &Thing| {
            mentions
                .iter()
                .any(|it| it.thing == *thing && it.role == Role::Definition)
        };
        let before = meaning(&text);
        for thing in things.into_iter().filter(|it| defined(it)) {
            let first = mentions
                .iter()
                .find(|it| it.thing == *thing)
                .expect("a place");
            names += 1;
            let new = "fresh_name_0";
            let places = match rename::rename(&workspace, document, first.span.start, new) {
                Ok(places) => places,
                Err(why) => {
                    refused.push(format!("{}: {thing:?}: {why}", path.display()));
                    continue;
                }
            };
            let changed = rename::replaced(&text, &places[document], new);
            assert_ne!(changed, text);
            // Each name once: building all of them would be another test of the checker.
            if names % 25 == 0 {
                assert_eq!(meaning(&changed), before, "{}: {thing:?}", path.display());
            }
            let resolves = |text: &str| resolve(&parse_model(text).tree, &Constants::new()).is_ok();
            assert_eq!(
                resolves(&changed),
                resolves(&text),
                "{}: {thing:?}",
                path.display()
            );
            let again = alone(&changed);
            let at = changed.find(new).expect("the new name");
            let back = rename::rename(&again, document, at, thing.name()).expect("back");
            assert_eq!(
                rename::replaced(&changed, &back[document], thing.name()),
                text
            );
        }
    }
    println!(
        "{names} names changed and changed back, {} refused",
        refused.len()
    );
    refused.iter().for_each(|it| println!("refused: {it}"));
    assert!(names > 300, "only {names} names");
    assert!(refused.is_empty(), "{refused:#?}");
}

/// A model by itself: nothing in its folder, no study above.
fn alone(text: &str) -> Workspace {
    with(MODEL, text)
}

#[test]
fn properties_answer_the_same_after_a_rename() {
    let model = "dtmc const double p = 0.25; module m s : [0..2]; [] s=0 -> p:(s'=1) + 1-p:(s'=2); endmodule";
    let asked = "P=? [ F s=1 ]";
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a path");
    let (of_model, of_file) = (folder.join("a.prism"), folder.join("a.props"));
    let mut workspace = Workspace::new(Box::new(Alone));
    workspace.open(&of_model, model);
    workspace.open(&of_file, asked);
    let at = model.find("s :").unwrap();
    let places = rename::rename(&workspace, &of_model, at, "state").expect("free");
    let (model, asked) = (
        rename::replaced(model, &places[&of_model], "state"),
        rename::replaced(asked, &places[&of_file], "state"),
    );
    let model = resolve(&parse_model(&model).tree, &Constants::new()).expect("a model");
    let file = prism_lang::parse_properties(&asked).tree;
    let properties = resolve_properties(&file, &model, &Constants::new()).expect("a property");
    let space = explore::<f64>(&model).expect("built");
    let options = Options::default();
    let answer = check(&space, &model, &properties[0].property, &options).expect("an answer");
    let Guarantee::Bounded { low, high } = answer.guarantee else {
        panic!("{answer:?}");
    };
    assert!(low <= 0.25 && 0.25 <= high && high - low < 1e-9);
}
