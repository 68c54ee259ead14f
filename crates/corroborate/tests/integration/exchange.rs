//! Requirements kept the same in a study and in files of other tools.

use crate::support::Copy;
use corroborate::evidence;
use corroborate::requirements::exchange::{Columns, Field, Take, Verdict};
use corroborate::{
    Ended, ExchangeReport, ExchangeRequest, Outcome, Problem, Study, export_requirements,
    import_requirements,
};

fn host() -> corroborate::Host {
    corroborate::Host::silent(corroborate::build())
}

fn request(study: &Copy, file: &str) -> ExchangeRequest {
    ExchangeRequest::new(study.path(""), study.path(file))
}

fn import(study: &Copy, file: &str) -> ExchangeReport {
    import_requirements(&request(study, file), &host())
        .unwrap_or_else(|problem| panic!("{problem}"))
}

fn export(study: &Copy, file: &str) -> ExchangeReport {
    export_requirements(&request(study, file), &host())
        .unwrap_or_else(|problem| panic!("{problem}"))
}

fn text(study: &Copy, file: &str) -> String {
    std::fs::read_to_string(study.path(file)).expect("a text")
}

fn write(study: &Copy, file: &str, text: &str) {
    std::fs::write(study.path(file), text).expect("written");
}

/// The texts of the study's requirements by id, and of what they were derived.
fn requirements(study: &Copy) -> Vec<(String, String, Vec<String>)> {
    let study = Study::load(&study.path("")).expect("a study");
    let of = |it: &evidence::Requirement| {
        let form = study.forms.by_id(&it.id).expect("its form");
        (
            it.id.clone(),
            it.text.clone(),
            form.background.parents.clone(),
        )
    };
    study.requirements.iter().map(of).collect()
}

#[test]
fn what_is_edited_on_one_side_is_carried_over_and_the_same_call_changes_nothing() {
    let study = Copy::of_template("Model");
    let before = text(&study, "requirements.toml");
    let ids: Vec<String> = requirements(&study).into_iter().map(|it| it.0).collect();
    for file in ["r.csv", "r.reqif", "r.sdoc", "r.json", "r.reqifz"] {
        let made = export(&study, file);
        assert_eq!(made.added, ids, "{file}");
        for _ in 0..2 {
            let again = export(&study, file);
            assert!(
                again.written.is_empty() && again.same == ids.len(),
                "{file}: {again:?}"
            );
            let back = import(&study, file);
            assert!(
                back.written.is_empty() && back.same == ids.len(),
                "{file}: {back:?}"
            );
        }
        assert_eq!(text(&study, "requirements.toml"), before, "{file}");
    }
    // The file is edited, and brings a requirement of its own.
    let csv = text(&study, "r.csv");
    let (first, rest) = csv.split_once('\n').expect("a header");
    let edited = format!(
        "{first}\n{rest}NEW,\"Said \"\"so\"\",\ntwice\",Since,open,{}\n",
        ids[0]
    );
    write(&study, "r.csv", &edited);
    let brought = import(&study, "r.csv");
    assert_eq!(
        (brought.added.as_slice(), brought.changed.len()),
        (&["NEW".to_owned()][..], 0)
    );
    let now = requirements(&study);
    assert_eq!(
        now.last(),
        Some(&(
            "NEW".into(),
            "Said \"so\",\ntwice".into(),
            vec![ids[0].clone()]
        ))
    );
    // All else of the study's text is as it was.
    assert!(text(&study, "requirements.toml").starts_with(before.trim_end()));
    // It has its place in that file, and is not added to the others that exist.
    assert_eq!(export(&study, "r.sdoc").kept_elsewhere, ["NEW"]);
    // The study is edited, and the file follows.
    study.edit("requirements.toml", "\ntwice", "\nthrice");
    assert_eq!(import(&study, "r.csv").waiting.len(), 1);
    assert_eq!(export(&study, "r.csv").changed.len(), 1);
    assert_eq!(text(&study, "r.csv"), edited.replace("\ntwice", "\nthrice"));
}

#[test]
fn what_is_edited_on_both_sides_is_a_conflict_until_somebody_decides() {
    let study = Copy::of_template("Model");
    export(&study, "r.csv");
    let (id, old, _) = requirements(&study)[0].clone();
    let (study_text, file_text) = (text(&study, "requirements.toml"), text(&study, "r.csv"));
    write(
        &study,
        "requirements.toml",
        &study_text.replacen(&old, "Mine.", 1),
    );
    write(
        &study,
        "r.csv",
        &file_text
            .replacen(&old, "Theirs.", 1)
            .replacen(",,,", ",Why,,", 1),
    );
    let edited = text(&study, "requirements.toml");
    for report in [
        import(&study, "r.csv"),
        import(&study, "r.csv"),
        export(&study, "r.csv"),
    ] {
        assert_eq!(report.conflicts.len(), 1, "{report:?}");
        let found = &report.conflicts[0];
        assert_eq!(
            (found.id.as_str(), found.field.as_str()),
            (id.as_str(), "text")
        );
        assert_eq!(
            (found.in_study.as_str(), found.in_file.as_str()),
            ("Mine.", "Theirs.")
        );
        assert_eq!(report.outcome(), Outcome::Inconclusive);
    }
    // What is not in conflict was carried over.
    assert_eq!(
        text(&study, "requirements.toml")
            .matches("rationale = \"Why\"")
            .count(),
        1
    );
    assert!(edited.contains("Mine.") && text(&study, "r.csv").contains("Theirs."));
    let mut decided = request(&study, "r.csv");
    decided.take = Some(Take::File);
    decided.dry_run = true;
    let would = import_requirements(&decided, &host()).expect("tried");
    assert_eq!(would.changed.len(), 1);
    assert!(text(&study, "requirements.toml").contains("Mine."));
    decided.dry_run = false;
    let done = import_requirements(&decided, &host()).expect("done");
    assert_eq!((done.changed.len(), done.outcome()), (1, Outcome::Holds));
    assert!(text(&study, "requirements.toml").contains("Theirs."));
    assert!(import(&study, "r.csv").written.is_empty());
}

#[test]
fn whose_value_counts_may_be_decided_for_the_other_direction() {
    let study = Copy::of_template("Model");
    export(&study, "r.csv");
    let (_, old, _) = requirements(&study)[0].clone();
    for (file, new) in [("requirements.toml", "Mine."), ("r.csv", "Theirs.")] {
        write(&study, file, &text(&study, file).replacen(&old, new, 1));
    }
    let mut decided = request(&study, "r.csv");
    decided.take = Some(Take::Study);
    let report = import_requirements(&decided, &host()).expect("decided");
    assert_eq!((report.conflicts.len(), report.waiting.len()), (0, 1));
    assert_eq!(export(&study, "r.csv").changed.len(), 1);
    assert!(text(&study, "r.csv").contains("Mine."));
}

#[test]
fn what_is_removed_on_one_side_is_said_and_stays_on_the_other() {
    let study = Copy::of_template("Model");
    write(&study, "r.csv", "id,text\nA,One.\nB,Two.\n");
    assert_eq!(import(&study, "r.csv").added, ["A", "B"]);
    write(&study, "r.csv", "id,text\nA,One.\n");
    let report = import(&study, "r.csv");
    assert_eq!(report.removed_from_file, ["B"]);
    assert!(requirements(&study).iter().any(|it| it.0 == "B"));
    let toml = text(&study, "requirements.toml");
    write(
        &study,
        "requirements.toml",
        &toml.replace("[[requirement]]\nid = \"A\"\ntext = \"One.\"\n", ""),
    );
    let report = import(&study, "r.csv");
    assert_eq!(
        (report.removed_from_study.as_slice(), report.added.len()),
        (&["A".to_owned()][..], 0)
    );
    let report = export(&study, "r.csv");
    assert_eq!(report.removed_from_file, ["B"]);
    assert_eq!(
        text(&study, "r.csv"),
        "id,text\nA,One.\n".to_owned() + &text(&study, "r.csv")["id,text\nA,One.\n".len()..]
    );
}

#[test]
fn both_sides_that_never_met_and_differ_are_a_conflict() {
    let study = Copy::of_template("Model");
    let id = requirements(&study)[0].0.clone();
    write(
        &study,
        "r.csv",
        &format!("id,text,rationale\n{id},Another.,Since\n"),
    );
    let report = import(&study, "r.csv");
    assert_eq!(
        (report.conflicts.len(), report.changed.len()),
        (1, 1),
        "{report:?}"
    );
}

#[test]
fn names_of_columns_are_remembered() {
    let study = Copy::of_template("Model");
    write(&study, "r.csv", "Number,What\nA,One.\n");
    let missing = import_requirements(&request(&study, "r.csv"), &host()).expect_err("no columns");
    assert_eq!(missing.code, "bad-requirement-file");
    let mut named = request(&study, "r.csv");
    named.columns = Columns {
        id: Some("Number".into()),
        fields: vec![(Field::Text, "What".into())],
    };
    assert_eq!(
        import_requirements(&named, &host()).expect("read").added,
        ["A"]
    );
    write(&study, "r.csv", "Number,What\nA,Other.\n");
    assert_eq!(import(&study, "r.csv").changed.len(), 1);
}

/// Written by hand in the form of FRET's exports.
fn fret(formula: &str) -> String {
    format!(
        r#"[{{"reqid": "F1", "fulltext": "Whenever docked the robot shall immediately satisfy docked", "semantics": {{"ftExpanded": "{formula}"}}}},
            {{"reqid": "F2", "fulltext": "As fast as possible", "semantics": {{}}}}]"#
    )
}

#[test]
fn frets_sentences_are_proposed_and_held_against_its_formulas() {
    let study = Copy::of_template("Model");
    let name = {
        let loaded = Study::load(&study.path("")).expect("a study");
        loaded
            .vocabulary
            .propositions
            .keys()
            .next()
            .expect("a name")
            .clone()
    };
    let file = |formula: &str| fret(formula).replace("docked", &name);
    write(&study, "r.json", &file("(LAST V (docked -> docked))"));
    let mut asked = request(&study, "r.json");
    asked.dry_run = true;
    let report = import_requirements(&asked, &host()).expect("tried");
    assert_eq!(
        report.sentences[0].runs.as_ref().map(|it| it.verdict),
        Some(Verdict::Same)
    );
    assert!(report.sentences[1].not_translated.is_some());
    asked.sentences = true;
    asked.dry_run = false;
    import_requirements(&asked, &host()).expect("done");
    let loaded = Study::load(&study.path("")).expect("a study");
    assert!(
        loaded
            .forms
            .by_id("F1")
            .is_some_and(|it| it.sentence.is_some())
    );
    // FRET's formula changes: the study's sentence no longer means what it does.
    write(&study, "r.json", &file("(LAST V (X docked))"));
    let report = import(&study, "r.json");
    assert_eq!(
        report.sentences[0].own_runs.as_ref().map(|it| it.verdict),
        Some(Verdict::Differs)
    );
    assert_eq!(report.outcome(), Outcome::Violated);
}

/// FRET reads the text: one that no longer says what the study's sentence does is told whenever it is exported.
#[test]
fn a_text_that_the_sentence_has_left_behind_is_said_on_export() {
    let study = Copy::of_template("Model");
    let loaded = Study::load(&study.path("")).expect("a study");
    let names: Vec<String> = loaded.vocabulary.propositions.keys().cloned().collect();
    let [first, second] = &names[..2] else {
        panic!("{names:?}")
    };
    let before = text(&study, "requirements.toml");
    let with = |sentence: &str| {
        let added = format!(
            "\n[[requirement]]\nid = \"F7\"\ntext = \"Whenever {first} the robot shall within 2 ticks satisfy {second}\"\n\
             shall = \"{sentence}\"\n"
        );
        write(&study, "requirements.toml", &format!("{before}{added}"));
    };
    let about = |report: &ExchangeReport| -> Vec<String> {
        let notes = report
            .notes
            .iter()
            .filter(|it| it.contains("the study's sentence"));
        notes.cloned().collect()
    };
    // The same in other words; the other requirements have texts for people.
    with(&format!(
        "Whenever {first}, the robot shall within 2 steps satisfy {second}"
    ));
    assert_eq!(about(&export(&study, "r.json")), Vec::<String>::new());
    with(&format!(
        "Whenever {first}, the robot shall within 3 steps satisfy {second}"
    ));
    for file in ["r.json", "new.json", "new.json"] {
        let notes = about(&export(&study, file));
        let [note] = &notes[..] else {
            panic!("{file}: {notes:?}")
        };
        for said in [
            "F7: ",
            "within 3 steps",
            "within 2 ticks",
            "FRET's text does not hold",
        ] {
            assert!(note.contains(said), "{said}: {note}");
        }
    }
    with(&format!("The robot shall always satisfy {first}"));
    assert_eq!(about(&export(&study, "r.json")).len(), 1);
    // Other formats have no sentences.
    assert_eq!(about(&export(&study, "r.csv")), Vec::<String>::new());
}

#[test]
fn a_proposal_that_the_study_cannot_have_stands_in_a_comment() {
    let study = Copy::of_template("Model");
    write(
        &study,
        "r.json",
        &fret("(LAST V (docked -> docked))").replace("docked", "unheard_of"),
    );
    let mut asked = request(&study, "r.json");
    asked.sentences = true;
    import_requirements(&asked, &host()).expect("done");
    let toml = text(&study, "requirements.toml");
    assert!(
        toml.contains(
            "# shall = \"Whenever unheard_of, the robot shall immediately satisfy unheard_of\""
        ),
        "{toml}"
    );
}

#[test]
fn calls_that_cannot_be_carried_out_say_why() {
    let study = Copy::of_template("Model");
    let code = |result: Result<ExchangeReport, Problem>| result.expect_err("refused").code;
    assert_eq!(
        code(import_requirements(&request(&study, "none.csv"), &host())),
        "cannot-read"
    );
    assert_eq!(
        code(import_requirements(&request(&study, "r.docx"), &host())),
        "bad-requirement-file"
    );
    let mut unknown = request(&study, "r.csv");
    unknown.only = vec!["R99".into()];
    assert_eq!(
        code(export_requirements(&unknown, &host())),
        "unknown-requirement"
    );
    std::fs::create_dir(study.path("folder")).expect("made");
    assert_eq!(
        code(import_requirements(&request(&study, "folder"), &host())),
        "bad-requirement-file"
    );
    write(&study, "requirements-sync.toml", "[[file]]\npath = 1\n");
    assert_eq!(
        code(import_requirements(&request(&study, "r.csv"), &host())),
        "bad-study-file"
    );
}

#[test]
fn what_a_replaced_text_loses_in_the_file_is_said() {
    let study = Copy::of_template("Model");
    let (id, old, _) = requirements(&study)[0].clone();
    write(
        &study,
        "r.json",
        &fret("(LAST V docked)").replace("F1", &id),
    );
    export(&study, "r.reqif");
    let mut taken = request(&study, "r.json");
    taken.take = Some(Take::Study);
    import_requirements(&taken, &host()).expect("decided");
    study.edit("requirements.toml", &old, "Another text.");
    for (file, said) in [
        ("r.reqif", "the new text is plain"),
        ("r.json", "FRET's formulas were those of the old"),
    ] {
        let report = export(&study, file);
        let notes = report
            .notes
            .iter()
            .filter(|it| it.starts_with(&format!("{id}: ")) && it.contains(said));
        assert_eq!(notes.count(), 1, "{file}: {:?}", report.notes);
    }
    assert!(!text(&study, "r.json").contains("LAST"));
}

/// Threads that import and export at the same time lose nothing: one works, the others are told to come again.
#[test]
fn a_study_is_worked_on_by_one_import_or_export_at_a_time() {
    const FILES: usize = 6;
    let study = Copy::of_template("Model");
    let before = requirements(&study).len();
    for number in 0..FILES {
        let rows: String = (0..20)
            .map(|row| format!("N{number}-{row},Text {row}.\n"))
            .collect();
        write(
            &study,
            &format!("r{number}.csv"),
            &format!("id,text\n{rows}"),
        );
    }
    let refused = std::sync::atomic::AtomicUsize::new(0);
    let until_done = |carry: &dyn Fn() -> Result<ExchangeReport, Problem>| {
        while let Err(problem) = carry() {
            assert_eq!(problem.code, "requirements-in-use", "{problem}");
            refused.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            std::thread::yield_now();
        }
    };
    std::thread::scope(|scope| {
        for number in 0..FILES {
            let (study, until_done) = (&study, &until_done);
            scope.spawn(move || {
                let own = request(study, &format!("r{number}.csv"));
                until_done(&|| import_requirements(&own, &host()));
                let other = request(study, &format!("out{number}.sdoc"));
                until_done(&|| export_requirements(&other, &host()));
            });
        }
    });
    assert_eq!(requirements(&study).len(), before + 20 * FILES);
    // The record knows all files, and nothing is left of the lock.
    let record = text(&study, "requirements-sync.toml");
    for number in 0..FILES {
        assert!(
            record.contains(&format!("path = \"r{number}.csv\"")),
            "{record}"
        );
        assert!(record.contains(&format!("path = \"out{number}.sdoc\"")));
    }
    #[cfg(unix)]
    assert!(!study.path(".requirements-sync.lock").exists());
}
