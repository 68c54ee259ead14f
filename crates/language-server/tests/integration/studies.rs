//! A study's files, named across each other.

use crate::support::{files_below, root, with};
use diagnostic::Problems;
use language_server::diagnostics::{self, Telling};
use language_server::{Alone, Workspace, completion, cursor, hover, kind, rename};
use prism_lang::names::Role;
use std::path::{Path, PathBuf};
use study::Study;

/// A copy of the handover's texts in a folder of its own.
fn handover() -> (tempfile::TempDir, PathBuf, Workspace) {
    let folder = tempfile::tempdir().expect("a folder");
    let to = folder
        .path()
        .canonicalize()
        .expect("a path")
        .join("handover");
    let from = root().join("case-studies/handover");
    for file in files_below(&from) {
        let copy = to.join(file.strip_prefix(&from).expect("below"));
        std::fs::create_dir_all(copy.parent().expect("a folder")).expect("made");
        std::fs::copy(&file, copy).expect("copied");
    }
    (folder, to, Workspace::new(Box::new(Alone)))
}

fn place(file: &Path, needle: &str) -> usize {
    let text = std::fs::read_to_string(file).expect("a text");
    text.find(needle)
        .unwrap_or_else(|| panic!("{needle} in {}", file.display()))
}

#[test]
fn a_sentence_says_what_it_means_and_a_proposition_where_it_is_bound() {
    let (_kept, folder, workspace) = handover();
    let file = folder.join("requirements.toml");
    let said = |needle| {
        hover::at(&workspace, &file, place(&file, needle))
            .expect("said")
            .text
    };
    let sentence = said("The robot shall with probability");
    assert!(
        sentence.contains(
            "The probability that a run meets this, at all its triggers, must be at least 0.95."
        ),
        "{sentence}"
    );
    assert!(
        sentence.contains("property (written by hand): `P=? [ F \"handed_over\" ]`"),
        "{sentence}"
    );
    let proposition = said("grasped\" },");
    assert!(
        proposition.contains("closed its hand")
            && proposition.contains("handover_v1.prism` expresses it"),
        "{proposition}"
    );
    let vocabulary = folder.join("vocabulary.toml");
    let at = place(&vocabulary, "near_distance");
    let parameter = hover::at(&workspace, &vocabulary, at).expect("said").text;
    assert!(parameter.contains("`near_distance` = "), "{parameter}");
    let at = place(&vocabulary, "robotState=GPLOk");
    let variable = hover::at(&workspace, &vocabulary, at).expect("said").text;
    assert!(variable.contains("of module `robot`"), "{variable}");
}

#[test]
fn definitions_are_found_across_files() {
    let (_kept, folder, workspace) = handover();
    let leads = |file: &str, needle: &str, to: &str| {
        let file = folder.join(file);
        let here = cursor::at(&workspace, &file, place(&file, needle));
        let found = cursor::definitions(&workspace, &here[0].thing, &file);
        let files: Vec<String> = found
            .iter()
            .map(|it| {
                it.path
                    .strip_prefix(&folder)
                    .expect("below")
                    .display()
                    .to_string()
            })
            .collect();
        assert!(files.iter().any(|it| it == to), "{needle}: {files:?}");
    };
    leads("requirements.toml", "handed_over.\"", "vocabulary.toml");
    leads("requirements.toml", "handed_over\" ]'", "vocabulary.toml");
    leads(
        "requirements.toml",
        "release_time satisfy",
        "parameters.toml",
    );
    leads(
        "vocabulary.toml",
        "robotState=GPLOk",
        "models/handover_v5.prism",
    );
    leads("vocabulary.toml", "object_reach", "parameters.toml");
    leads("ledger.toml", "typical\"", "study.toml");
    leads(
        "study.toml",
        "objectReleaseTimer",
        "models/handover_v1.prism",
    );
    leads(
        "exploration.toml",
        "GPLWasOk | robotState",
        "models/handover_v4.prism",
    );
}

/// Applies a rename and reads the study again.
fn applied(folder: &Path, places: &rename::Replaced, new: &str) -> Study {
    for (file, spans) in places {
        let text = std::fs::read_to_string(file).expect("a text");
        std::fs::write(file, rename::replaced(&text, spans, new)).expect("written");
    }
    Study::load(folder).expect("the study can be read")
}

#[test]
fn a_proposition_is_renamed_in_all_files_and_the_study_means_the_same() {
    let (_kept, folder, workspace) = handover();
    let before = Study::load(&folder).expect("a study");
    let file = folder.join("vocabulary.toml");
    let places = rename::rename(
        &workspace,
        &file,
        place(&file, "[handed_over]") + 1,
        "given",
    )
    .expect("free");
    assert_eq!(places.len(), 2);
    let after = applied(&folder, &places, "given");
    for (old, new) in before.requirements.iter().zip(&after.requirements) {
        let property = old
            .property
            .clone()
            .map(|it| it.replace("handed_over", "given"));
        assert_eq!(new.property, property);
    }
    let left = std::fs::read_to_string(folder.join("requirements.toml")).expect("a text");
    let in_prose = left.lines().filter(|it| it.contains("handed_over")).count();
    assert_eq!(in_prose, 0);
}

#[test]
fn a_variable_of_the_models_is_renamed_in_all_of_them_and_in_the_studys_texts() {
    let (_kept, folder, workspace) = handover();
    let file = folder.join("models/handover_v1.prism");
    let places = rename::rename(
        &workspace,
        &file,
        place(&file, "robotState :"),
        "robot_state",
    )
    .expect("free");
    let names: Vec<String> = places
        .keys()
        .map(|it| it.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    for name in [
        "vocabulary.toml",
        "exploration.toml",
        "handover_v1.prism",
        "handover_v5.prism",
    ] {
        assert!(names.iter().any(|it| it == name), "{name} in {names:?}");
    }
    applied(&folder, &places, "robot_state");
    for file in files_below(&folder) {
        let is_known = !matches!(kind::Kind::of(&file, None), kind::Kind::Other);
        if let Ok(text) = std::fs::read_to_string(&file)
            && is_known
        {
            let code: String = text
                .lines()
                .map(|it| it.split("//").next().unwrap_or(""))
                .collect();
            assert!(!code.contains("robotState="), "{}", file.display());
        }
    }
}

#[test]
fn identifiers_and_names_that_the_library_needs_are_not_renamed() {
    let (_kept, folder, workspace) = handover();
    let file = folder.join("requirements.toml");
    let refused = |needle: &str, new: &str| {
        rename::rename(&workspace, &file, place(&file, needle), new).expect_err("refused")
    };
    assert!(refused("1a\"", "x").contains("change it by hand"));
    assert!(refused("handed_over.\"", "released").contains("already a name"));
    assert!(refused("handed_over.\"", "a b").contains("cannot be a name"));
    // A parameter in a predicate would be taken for the proposition, though no text that names it has both.
    assert!(
        refused("release_time satisfy", "resetting").contains("already a name in vocabulary.toml")
    );
}

#[test]
fn mistakes_of_texts_that_are_not_saved_are_those_of_the_command_line() {
    let (_kept, folder, mut workspace) = handover();
    let file = folder.join("requirements.toml");
    let text = std::fs::read_to_string(&file).expect("a text");
    let wrong = text
        .replacen("satisfy handed_over", "satisfy handed_ovr", 1)
        .replacen("margin = 0.10", "margin = 2", 1);
    workspace.open(&file, &wrong);
    let told = diagnostics::of_file(&workspace, &file, &Telling::default());
    let told = &told[&file];
    // The same texts, saved.
    std::fs::write(&file, &wrong).expect("written");
    let mut found = Problems::new();
    Study::read_for(&folder, &host::Trust::default(), &mut found).expect("a study");
    let known = found.into_problem().expect("mistakes").into_each();
    assert_eq!(told.len(), known.len());
    for (told, known) in told.iter().zip(&known) {
        let place = known.place().expect("a place");
        assert!(told.message.starts_with(known.message()));
        assert_eq!(told.range.start.line as usize + 1, place.line);
        assert_eq!(told.range.start.character as usize + 1, place.column);
    }
    workspace.open(&file, &text);
    assert!(diagnostics::of_file(&workspace, &file, &Telling::default())[&file].is_empty());
}

#[test]
fn completion_knows_propositions_parameters_and_identifiers() {
    let (_kept, folder, workspace) = handover();
    let labels = |file: &str, needle: &str| -> Vec<String> {
        let file = folder.join(file);
        let at = place(&file, needle);
        let found = completion::at(&workspace, &file, at);
        found.into_iter().map(|it| it.label).collect()
    };
    let in_sentence = labels("requirements.toml", "handed_over.\"");
    assert!(
        in_sentence.contains(&"released".into()) && in_sentence.contains(&"release_time".into())
    );
    assert!(labels("ledger.toml", "typical\"").contains(&"typical".into()));
    assert!(labels("vocabulary.toml", "GPLWasOk |").contains(&"robotState".into()));
}

#[test]
fn a_file_without_a_study_is_no_study() {
    let workspace = with("/nowhere/vocabulary.toml", "[a]\nmeaning = \"x\"\n");
    let path = Path::new("/nowhere/vocabulary.toml");
    assert!(cursor::in_file(&workspace, path).is_empty());
    assert!(diagnostics::of_file(&workspace, path, &Telling::default()).is_empty());
}

/// The places of a whole study are where its names are.
#[test]
fn every_mention_of_every_study_is_its_name() {
    let mut mentions = 0;
    for study in [
        "handover",
        "cell",
        "corridor",
        "cloakroom",
        "four-physics",
        "pendulum",
    ] {
        let folder = root().join("case-studies").join(study);
        let workspace = Workspace::new(Box::new(Alone));
        let view = workspace.study(&folder).expect("a study");
        for it in view.mentions(&workspace) {
            let text = workspace.read(&it.path).expect("a text");
            assert_eq!(&text.as_str()[it.span.clone()], it.thing.name());
            let defined = cursor::definitions(&workspace, &it.thing, &it.path);
            assert!(!defined.is_empty(), "{study}: {it:?}");
            assert!(defined.iter().all(|it| it.role == Role::Definition));
            mentions += 1;
        }
    }
    println!("{mentions} mentions");
    assert!(mentions > 500, "only {mentions}");
}

/// Of a text with a mistake only what stands before it may be found, so that a rename would be one of a part.
#[test]
fn nothing_is_renamed_while_a_file_of_the_study_has_a_mistake() {
    for broken in [
        "ledger.toml",
        "requirements.toml",
        "exploration.toml",
        "vocabulary.toml",
    ] {
        let (_kept, folder, _) = handover();
        let file = folder.join(broken);
        let text = std::fs::read_to_string(&file).expect("a text");
        std::fs::write(&file, format!("[not\n{text}")).expect("written");
        let mut workspace = Workspace::new(Box::new(Alone));
        let model = folder.join("models/handover_v1.prism");
        workspace.open(&model, std::fs::read_to_string(&model).expect("a text"));
        let at = place(&model, "robotState :");
        let refused = rename::rename(&workspace, &model, at, "robot_state").expect_err(broken);
        assert!(
            refused.contains(broken) && refused.contains("syntax errors (line 1)"),
            "{refused}"
        );
    }
}
