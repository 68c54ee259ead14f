//! What is said of models and property files.

use crate::support::{files_below, root, with};
use language_server::diagnostics::{self, Telling};
use language_server::{Alone, Text, Workspace, completion, cursor, format, hover, kind, symbols};
use ls_types::{DiagnosticSeverity, NumberOrString};
use prism_lang::names::Role;
use std::path::{Path, PathBuf};

const MODEL: &str = "/models/m.prism";

fn said(text: &str, needle: &str) -> String {
    let workspace = with(MODEL, text);
    let at = text.find(needle).expect("the place");
    let shown = hover::at(&workspace, Path::new(MODEL), at);
    shown.map_or_else(String::new, |it| it.text)
}

#[test]
fn hover_says_definitions_values_ranges_and_who_synchronises() {
    let text = "mdp // é𝄞
const int n = 2 * k; const int k = 2;
formula busy = x > 0 | y; formula idle = !busy;
global y : bool init true;
module a x : [0..n]; [go] x<n -> (x'=x+1); endmodule
module b = a [x=z] endmodule
label \"done\" = idle;
rewards \"time\" true : 1; [go] y : 2; endrewards";
    for (needle, expected) in [
        ("n = 2", "value: 4"),
        ("k; const", "value: 2"),
        ("idle =", "written out:\n```prism\n!(x>0 | y)"),
        (
            "y : bool",
            "global: every module may change it; false or true; initially true",
        ),
        ("x : [", "of module `a`; 0 to 4 (5 values); initially 0"),
        ("z]", "copied from there as `z`\n\nof module `b`"),
        ("go]", "`a` (1 command), `b` (1 command) synchronise on it"),
        ("a x :", "module `a`: 1 variable, 1 command; actions go"),
        ("b = a", "a copy of `a`"),
        ("done", "label \"done\" = idle;"),
        ("time", "1 item of states, 1 of transitions"),
        ("endrewards", "ends a reward structure"),
    ] {
        let said = said(text, needle);
        assert!(said.contains(expected), "{needle}: {said}");
    }
    assert_eq!(said(text, "é"), "");
    // Also where something else is wrong.
    let said = said(
        "dtmc const int n = 2*k; const int k = 3; const int m = -true; module a [] z -> true; endmodule",
        "n =",
    );
    assert!(said.contains("value: 6"), "{said}");
}

#[test]
fn a_constant_without_a_value_is_a_remark_and_stands_in_no_way() {
    let text = "dtmc const int n; const double p; module m x : [0..n]; [] x<n -> p:(x'=x+1) + 1-p:true; [] y -> true; endmodule";
    let found = told(text);
    let codes: Vec<_> = found.iter().map(|it| (it.0.as_str(), it.1)).collect();
    // `y` is not declared: a mistake, beside the remarks.
    assert!(
        codes.contains(&("unknown-name", DiagnosticSeverity::ERROR)),
        "{codes:?}"
    );
    assert!(
        codes.contains(&("undefined-constant", DiagnosticSeverity::INFORMATION)),
        "{codes:?}"
    );
    let text = text.replace("[] y -> true; ", "");
    assert!(
        told(&text)
            .iter()
            .all(|it| it.1 == DiagnosticSeverity::INFORMATION)
    );
    let said = said(&text, "n; const");
    assert!(said.contains("--const n=..."), "{said}");
}

fn told(text: &str) -> Vec<(String, DiagnosticSeverity, String)> {
    let workspace = with(MODEL, text);
    let all = diagnostics::of_file(&workspace, Path::new(MODEL), &Telling::default());
    let found = all.into_values().flatten().map(|it| {
        let Some(NumberOrString::String(code)) = it.code else {
            panic!("no code");
        };
        (code, it.severity.expect("a severity"), it.message)
    });
    found.collect()
}

#[test]
fn diagnostics_are_those_of_the_library_at_utf_16_places() {
    let text = "dtmc\nmodule m /* */ x : bool;\n// 𝄞é\n[] 𝄞 z=0 -> true; endmodule";
    let workspace = with(MODEL, text);
    let all = diagnostics::of_file(
        &workspace,
        Path::new(MODEL),
        &Telling {
            explain_scheme: Some("explain".into()),
        },
    );
    let found = &all[Path::new(MODEL)];
    let parsed = prism_lang::parse_model(text);
    assert_eq!(found.len(), parsed.diagnostics.len());
    for (told, known) in found.iter().zip(&parsed.diagnostics) {
        assert!(told.message.starts_with(&known.message), "{told:?}");
        assert_eq!(told.message.lines().nth(1), known.remedy.as_deref());
        let lines = Text::new(text.into());
        assert_eq!(told.range, lines.range(known.span.start..known.span.end));
        let link = told
            .code_description
            .as_ref()
            .expect("a link")
            .href
            .as_str()
            .to_owned();
        assert_eq!(link, format!("explain:{}.txt", known.code));
    }
    let clef = found
        .iter()
        .find(|it| it.message.contains('𝄞'))
        .expect("the clef");
    assert_eq!(
        (clef.range.start.character, clef.range.end.character),
        (3, 5)
    );
}

#[test]
fn related_places_are_told() {
    let workspace = with(MODEL, "dtmc const int n = 1; const int n = 2;");
    let all = diagnostics::of_file(&workspace, Path::new(MODEL), &Telling::default());
    let related = all[Path::new(MODEL)][0]
        .related_information
        .as_ref()
        .expect("related");
    assert_eq!(related[0].message, "first declared here");
    assert_eq!(related[0].location.uri.as_str(), "file:///models/m.prism");
}

#[test]
fn properties_are_judged_with_the_model_of_their_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a path");
    let mut workspace = Workspace::new(Box::new(Alone));
    let file = folder.join("b.props");
    let text = "const int k; P=? [ F<=k \"up\" & y ]; P=? [ F \"down\" ]; R{\"r\"}=? [ F x ];";
    workspace.open(&file, text);
    let judged = |workspace: &Workspace| {
        workspace
            .properties(&file)
            .expect("read")
            .judged_with
            .clone()
    };
    assert!(judged(&workspace).contains("this folder has none"));
    workspace.open(
        &folder.join("a.prism"),
        "dtmc module m x : bool; endmodule label \"up\" = x;",
    );
    assert!(judged(&workspace).contains("a.prism (the only model in this folder)"));
    workspace.open(&folder.join("c.prism"), "dtmc");
    assert!(judged(&workspace).contains("this folder has 2"));
    workspace.open(
        &folder.join("b.prism"),
        "dtmc const int n; module m x : [0..n]; endmodule label \"up\" = x=n;",
    );
    assert!(judged(&workspace).contains("b.prism (it has this file's name)"));
    let all = diagnostics::of_file(&workspace, &file, &Telling::default());
    let mut codes: Vec<String> = all[&file]
        .iter()
        .map(|it| format!("{:?}", it.code))
        .collect();
    codes.sort();
    let shown = codes.join(" ");
    for code in ["undefined-constant", "unknown-label", "unknown-name"] {
        assert!(shown.contains(code), "{code} in {shown}");
    }
    let hover = hover::at(&workspace, &file, text.find("up").unwrap())
        .expect("a label")
        .text;
    assert!(
        hover.contains("x=n") && hover.contains("judged with b.prism"),
        "{hover}"
    );
    let defined = cursor::at(&workspace, &file, text.find("up").unwrap());
    let defined = cursor::definitions(&workspace, &defined[0].thing, &file);
    assert_eq!(
        defined.iter().map(|it| it.path.clone()).collect::<Vec<_>>(),
        [folder.join("b.prism")]
    );
}

#[test]
fn completion_offers_what_is_in_scope() {
    let text = "dtmc const int n = 3; formula f = x>0;\nmodule m x : [0..n]; [go] f -> (x'=0); endmodule\nlabel \"up\" = x=n;\n";
    let workspace = with(MODEL, text);
    let labels = |at: usize| -> Vec<String> {
        let found = completion::at(&workspace, Path::new(MODEL), at);
        found.into_iter().map(|it| it.label).collect()
    };
    let in_guard = labels(text.find("f -> ").unwrap());
    for name in ["n", "f", "x", "floor"] {
        assert!(
            in_guard.contains(&name.to_owned()),
            "{name} in {in_guard:?}"
        );
    }
    assert!(labels(text.len()).contains(&"module".to_owned()));
    assert_eq!(labels(text.find("go]").unwrap()), ["go"]);
    let mut workspace = with(MODEL, text);
    let file = Path::new("/models/m.props");
    let asked = "P=? [ F \"u";
    workspace.open(file, asked);
    let found = completion::at(&workspace, file, asked.len());
    // Nothing is on the disk there, so the open model is not a sibling by its folder alone.
    let names: Vec<&str> = found.iter().map(|it| it.label.as_str()).collect();
    assert!(
        names.contains(&"up") && names.contains(&"deadlock"),
        "{names:?}"
    );
}

#[test]
fn the_outline_has_what_is_declared() {
    let text = "dtmc const int n = 1; module a x : bool; endmodule module b = a [x=y] endmodule label \"l\" = x; rewards true : 1; endrewards";
    let outline = symbols::of_file(&with(MODEL, text), Path::new(MODEL));
    let names: Vec<&str> = outline.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["n", "a", "b", "l", "rewards"]);
    let children = outline[1].children.as_ref().expect("a variable");
    assert_eq!(children[0].name, "x");
    for it in &outline {
        assert!(
            it.range.start <= it.selection_range.start && it.selection_range.end <= it.range.end
        );
    }
}

/// The texts in the PRISM language that the project has.
fn texts() -> Vec<(PathBuf, String)> {
    let folders = [
        "conformance",
        "case-studies",
        "crates/corroborate/templates",
    ];
    let files = folders.iter().flat_map(|it| files_below(&root().join(it)));
    let of_prism = |path: &PathBuf| {
        matches!(
            kind::Kind::of(path, None),
            kind::Kind::Model | kind::Kind::Properties
        )
    };
    let files = files.filter(of_prism);
    files
        .filter_map(|it| Some((it.clone(), host::files::read_prism(&it).ok()?.0.text)))
        .collect()
}

/// Every comment of every text stays, and the laid out text means the same.
#[test]
fn what_is_laid_out_has_all_comments_and_means_the_same() {
    let comments = |text: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.split_once("//"));
        lines
            .map(|(_, comment)| comment.trim_end().to_owned())
            .collect()
    };
    let mut laid_out = 0;
    for (path, text) in texts() {
        let name = if kind::Kind::of(&path, None) == kind::Kind::Model {
            MODEL
        } else {
            "/m.props"
        };
        let workspace = with(name, &text);
        let Ok(edits) = format::edits(&workspace, Path::new(name)) else {
            continue;
        };
        laid_out += 1;
        let after = edits.first().map_or(text.clone(), |it| it.new_text.clone());
        assert_eq!(comments(&after), comments(&text), "{}", path.display());
        let again = with(name, &after);
        assert!(
            format::edits(&again, Path::new(name))
                .expect("it parses")
                .is_empty()
        );
        match name == MODEL {
            true => {
                let tree = |text: &str| prism_lang::parse_model(text).tree.to_string();
                assert_eq!(tree(&after), tree(&text));
            }
            false => {
                let tree = |text: &str| prism_lang::parse_properties(text).tree.to_string();
                assert_eq!(tree(&after), tree(&text));
            }
        }
    }
    assert!(laid_out > 50, "only {laid_out}");
}

/// Wherever a name of a model stands, its definition is found, and it has that name.
#[test]
fn every_name_leads_to_its_definition() {
    let mut found = 0;
    for (path, text) in texts() {
        let parsed = prism_lang::parse_model(&text);
        let is_model = kind::Kind::of(&path, None) == kind::Kind::Model;
        let resolves = || prism_lang::resolve(&parsed.tree, &prism_lang::Constants::new()).is_ok();
        if !is_model || parsed.has_errors() || !resolves() {
            continue;
        }
        let workspace = with(MODEL, &text);
        for mention in cursor::in_file(&workspace, Path::new(MODEL)) {
            let defined = cursor::definitions(&workspace, &mention.thing, Path::new(MODEL));
            let is_action = matches!(
                mention.thing,
                language_server::mentions::Thing::Prism(prism_lang::names::Space::Action, _)
            );
            assert!(
                !defined.is_empty() || is_action,
                "{}: {mention:?}",
                path.display()
            );
            for it in defined {
                assert_eq!(
                    (&text[it.span.clone()], it.role),
                    (mention.thing.name(), Role::Definition)
                );
            }
            let shown = hover::at(&workspace, Path::new(MODEL), mention.span.start);
            assert!(
                shown.is_some_and(|it| !it.text.is_empty()) || is_action,
                "{}: {mention:?}",
                path.display()
            );
            found += 1;
        }
    }
    assert!(found > 1_000, "only {found}");
}
