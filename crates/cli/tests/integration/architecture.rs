//! The architecture as data, held against what cargo and the sources say (ARCHITECTURE.md tells it in prose).

mod tables;

use crate::support;

use cargo_metadata::{DependencyKind, Metadata, Package};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use support::source::{
    lines_with, product_code, silent_matches, with_groups_written_out, without_comments_and_texts,
};
use support::{files_below, metadata, read, root, shown};
use tables::*;

#[test]
fn the_crates_are_those_of_the_table() {
    let known: BTreeSet<&str> = CRATES.iter().map(|(name, ..)| *name).collect();
    let metadata = metadata();
    let packages = metadata.workspace_packages();
    let found: BTreeSet<&str> = packages.iter().map(|p| crate_name(&p.name)).collect();
    assert_eq!(found, known);
}

/// Features that only another package asks for would have everything built twice: once for the tests, once for the program.
#[test]
fn the_program_alone_has_the_features_that_it_has_among_all() {
    let of_the_program = features(&["--package", "corroborate-cli", "--edges", "normal,build"]);
    let among_all = features(&["--workspace", "--edges", "normal,build,dev"]);
    let others: Vec<&String> = of_the_program.difference(&among_all).collect();
    assert!(
        others.is_empty(),
        "other packages have them with more features: {others:#?}"
    );
}

/// Each package with its features, as cargo chooses them for what is asked.
fn features(asked: &[&str]) -> BTreeSet<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let tree = Command::new(cargo)
        .args([
            "tree",
            "--locked",
            "--prefix",
            "none",
            "--format",
            "{p} [{f}]",
        ])
        .args(asked)
        .current_dir(root())
        .output()
        .expect("cargo runs");
    assert!(
        tree.status.success(),
        "{}",
        String::from_utf8_lossy(&tree.stderr)
    );
    let lines = String::from_utf8(tree.stdout).expect("UTF-8");
    (lines.lines())
        .map(|line| line.trim_end_matches(" (*)").replace(" (proc-macro)", ""))
        .collect()
}

/// What a package is called here: packages carry the prefix under which they can be published, crates and folders do not.
fn crate_name(package: &str) -> &str {
    if CRATES.iter().any(|(name, ..)| *name == package) {
        return package;
    }
    package.strip_prefix("corroborate-").unwrap_or(package)
}

/// The fuzz targets are a workspace apart, whose lock file only a slow step of continuous integration would find stale.
#[test]
fn the_fuzz_targets_lock_what_our_crates_depend_on() {
    let lock: toml::Table = toml::from_str(&read(&root().join("fuzz/Cargo.lock"))).expect("TOML");
    let locked: BTreeMap<&str, BTreeSet<&str>> = (lock["package"].as_array().into_iter().flatten())
        .filter_map(|package| {
            let names = package.get("dependencies").and_then(|it| it.as_array());
            // "name", or "name version" where there are several versions.
            let names = names
                .into_iter()
                .flatten()
                .filter_map(|it| it.as_str()?.split(' ').next());
            Some((package.get("name")?.as_str()?, names.collect()))
        })
        .collect();
    for package in metadata().workspace_packages() {
        let Some(locked) = locked.get(package.name.as_str()) else {
            continue;
        };
        let wanted = package.dependencies.iter();
        let wanted = wanted.filter(|it| it.kind != DependencyKind::Development);
        let wanted: BTreeSet<&str> = wanted.map(|it| it.name.as_str()).collect();
        assert_eq!(
            *locked, wanted,
            "{}: run `cargo update --workspace` in fuzz/",
            package.name
        );
    }
}

#[test]
fn each_allowed_edge_leads_to_a_lower_floor_or_to_a_neighbour_before() {
    for (position, (name, floor, uses)) in CRATES.iter().enumerate() {
        for used in *uses {
            let (index, (_, used_floor, _)) = find(used);
            assert!(
                used_floor < *floor
                    || ([2, 4].contains(floor) && used_floor == *floor && index < position),
                "{name} (floor {floor}) may not use {used} (floor {used_floor})"
            );
        }
    }
}

fn find(name: &str) -> (usize, (&'static str, u8, &'static [&'static str])) {
    let position = CRATES.iter().position(|(known, ..)| *known == name);
    let position = position.unwrap_or_else(|| panic!("no crate {name} in the table"));
    (position, CRATES[position])
}

#[test]
fn crates_use_only_what_the_table_allows() {
    let metadata = metadata();
    for package in metadata.workspace_packages() {
        let (_, (name, _, allowed)) = find(crate_name(&package.name));
        for used in ours(&metadata, package, |kind| {
            kind != DependencyKind::Development
        }) {
            assert!(
                allowed.contains(&used.as_str()),
                "{name} depends on {used}, which the architecture does not allow; allowed: {allowed:?}"
            );
        }
    }
}

#[test]
fn tests_of_a_crate_use_no_floor_above_it() {
    let metadata = metadata();
    for package in metadata.workspace_packages() {
        let (_, (name, floor, _)) = find(crate_name(&package.name));
        for used in ours(&metadata, package, |kind| {
            kind == DependencyKind::Development
        }) {
            let (_, (_, used_floor, _)) = find(&used);
            assert!(
                used_floor <= floor,
                "tests of {name} depend on {used}, a floor above"
            );
        }
    }
}

/// The names of our own crates that `package` depends on.
fn ours(
    metadata: &Metadata,
    package: &Package,
    wanted: impl Fn(DependencyKind) -> bool,
) -> Vec<String> {
    let members: BTreeSet<&str> = metadata
        .workspace_packages()
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    let dependencies = package.dependencies.iter();
    dependencies
        .filter(|d| wanted(d.kind) && members.contains(d.name.as_str()))
        .map(|d| crate_name(&d.name).to_owned())
        .collect()
}

#[test]
fn each_outside_thing_has_one_crate() {
    let metadata = metadata();
    let homes: BTreeMap<&str, &str> = OUTSIDE.into_iter().collect();
    let mut used = BTreeSet::new();
    for package in metadata.workspace_packages() {
        for dependency in &package.dependencies {
            let Some(home) = homes.get(dependency.name.as_str()) else {
                continue;
            };
            used.insert(dependency.name.clone());
            assert_eq!(
                crate_name(&package.name),
                *home,
                "{} names {}, which only {home} may",
                package.name,
                dependency.name
            );
        }
    }
    for name in homes.keys() {
        assert!(
            used.contains(*name),
            "nothing uses {name}: take it out of the table"
        );
    }
}

#[test]
fn floors_0_and_1_neither_print_nor_read_clock_or_environment_nor_hold_global_state() {
    let mut found = Vec::new();
    for (name, floor, _) in CRATES {
        if floor <= 1 || AS_PURE_AS_ENGINES.contains(&name) {
            found.extend(places(name, &ABSENT_BELOW_FLOOR_2));
        }
    }
    assert!(
        found.is_empty(),
        "not allowed on floors 0 and 1 and in {AS_PURE_AS_ENGINES:?}:\n{}",
        found.join("\n")
    );
}

/// What simulates any robot would otherwise come to lean on one case.
#[test]
fn the_test_bench_knows_nothing_of_the_handover() {
    let files = files_below(&root().join("crates/testbench"));
    let names = |path: &&Path| read(path).to_lowercase().contains("handover");
    let paths = files.iter().map(|path| path.as_path());
    let found: Vec<String> = paths.filter(names).map(shown).collect();
    assert!(
        found.is_empty(),
        "what is of the handover belongs to the crate `handover`:\n{}",
        found.join("\n")
    );
}

#[test]
fn only_what_the_table_names_opens_files() {
    let mut found = Vec::new();
    for (name, ..) in CRATES {
        if !MAY_USE_FILES.contains(&name) {
            found.extend(places(
                name,
                &["std::fs", "File::open", "File::create", "OpenOptions"],
            ));
        }
    }
    assert!(
        found.is_empty(),
        "files are opened by {MAY_USE_FILES:?} alone:\n{}",
        found.join("\n")
    );
}

/// A program that a study names is started in one place, which asks for the user's consent.
#[test]
fn programs_are_started_in_few_places() {
    let among = |words: &[&str], allowed: &[&str]| {
        let found = CRATES.iter().flat_map(|(name, ..)| places(name, words));
        let is_allowed = |place: &String| allowed.iter().any(|it| place.starts_with(it));
        found.partition::<Vec<String>, _>(is_allowed)
    };
    for (words, allowed) in [
        (
            &["process::Command", "Command::new"][..],
            &START_PROGRAMS[..],
        ),
        (&["Consent::typed"], &TAKE_AS_TYPED),
    ] {
        let (known, others) = among(words, allowed);
        assert!(
            others.is_empty(),
            "start programs in `rig::start`, which asks for a `Consent`:\n{}",
            others.join("\n")
        );
        for place in allowed {
            let is_used = known.iter().any(|it| it.starts_with(place));
            assert!(
                is_used,
                "{place} starts no program: take it out of the table"
            );
        }
    }
}

/// A path may be a study's, and lead to a pipe.
#[test]
fn files_that_a_study_may_name_are_opened_in_one_place() {
    let mut found = Vec::new();
    for name in ["host", "study", "judging", "rig", "corroborate"] {
        found.extend(places(
            name,
            &["std::fs::read(", "std::fs::read_to_string(", "File::open("],
        ));
    }
    found.retain(|place| !OPEN_BY_THEMSELVES.iter().any(|it| place.starts_with(it)));
    assert!(
        found.is_empty(),
        "read through `host::files`:\n{}",
        found.join("\n")
    );
}

#[test]
fn no_match_over_techniques_work_or_guarantees_takes_the_rest_in_silence() {
    let mut found = Vec::new();
    for (name, ..) in CRATES {
        let folder = root().join("crates").join(name).join("src");
        for path in rust_files(&folder) {
            if path.file_stem().is_some_and(|stem| stem == "tests") {
                continue;
            }
            let lines = silent_matches(&product_code(&read(&path)), &MATCHED_IN_FULL);
            found.extend(lines.iter().map(|line| format!("{}:{line}", shown(&path))));
        }
    }
    assert!(
        found.is_empty(),
        "name every variant, so that the compiler finds these places when there is one more:\n{}",
        found.join("\n")
    );
}

#[test]
fn techniques_and_kinds_of_work_are_told_apart_in_few_places() {
    let apart = |crates: &[&str], words: &[&str], allowed: &[&str]| {
        let found = crates.iter().flat_map(|name| places(name, words));
        let is_allowed = |place: &String| allowed.iter().any(|it| place.starts_with(it));
        let found: Vec<String> = found.filter(|place| !is_allowed(place)).collect();
        assert!(
            found.is_empty(),
            "ask for what it has (`Parts`, `Traits`), not for what it is:\n{}",
            found.join("\n")
        );
    };
    let work = [
        "Work::Check",
        "Work::Simulate",
        "Work::SimulateScene",
        "Work::Command",
        "Work::Read",
        "Work::Judge",
        "Work::Other",
    ];
    apart(&["study", "corroborate", "cli"], &work, &TELL_WORK_APART);
    let techniques = [
        "Technique::ModelChecking",
        "Technique::Simulation",
        "Technique::Experiment",
        "Technique::Operation",
    ];
    let all: Vec<&str> = CRATES.iter().map(|(name, ..)| *name).collect();
    apart(&all, &techniques, &TELL_TECHNIQUES_APART);
}

#[test]
fn libraries_do_not_touch_the_process() {
    let mut found = Vec::new();
    for (name, ..) in CRATES {
        if !PROGRAMS.contains(&name) {
            found.extend(places(name, &ABSENT_IN_LIBRARIES));
        }
    }
    assert!(
        found.is_empty(),
        "a host brings these, a library does not take them:\n{}",
        found.join("\n")
    );
}

#[test]
fn what_only_some_systems_have_is_named_in_few_places() {
    let (mut elsewhere, mut met) = (Vec::new(), BTreeSet::new());
    for (name, ..) in CRATES {
        for place in places(name, &SYSTEMS) {
            let file = MAY_NAME_A_SYSTEM.iter().find(|it| place.starts_with(**it));
            match file {
                Some(file) => drop(met.insert(*file)),
                None => elsewhere.push(place),
            }
        }
    }
    assert!(
        elsewhere.is_empty(),
        "Unix, Linux or Windows outside {MAY_NAME_A_SYSTEM:?}:\n{}",
        elsewhere.join("\n")
    );
    assert_eq!(met, BTreeSet::from(MAY_NAME_A_SYSTEM));
}

/// Where the product code of a crate contains one of the words.
fn places(name: &str, words: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let folder = root().join("crates").join(name).join("src");
    for path in rust_files(&folder) {
        // Files of tests alone are declared `#[cfg(test)] mod tests;` by their parent, or under another name.
        if path
            .file_stem()
            .is_some_and(|stem| stem == "tests" || stem == "promised")
        {
            continue;
        }
        let code = with_groups_written_out(&product_code(&read(&path)));
        for word in words {
            let lines = lines_with(&code, word);
            found.extend(
                lines
                    .iter()
                    .map(|line| format!("{}:{line}: {word}", shown(&path))),
            );
        }
    }
    found
}

fn rust_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = files_below(folder);
    files.retain(|path| path.extension().is_some_and(|e| e == "rs"));
    files
}

/// Whoever reads a definition on which conclusions rest reads beside it what it promises, and under which conditions.
#[test]
fn each_definition_behind_a_conclusion_states_its_guarantee_and_what_it_assumes() {
    let rooms = [
        "stats/src",
        "evidence/src",
        "refinement/src",
        "corroborate/src/technique",
    ];
    let mut defined = 0;
    for room in rooms {
        for path in rust_files(&root().join("crates").join(room)) {
            let text = std::fs::read_to_string(&path).expect("it can be read");
            let head: Vec<&str> = text
                .lines()
                .take_while(|it| it.starts_with("//!"))
                .collect();
            let head = head.join("\n");
            // Short heads are one paragraph, with their guarantee at its end.
            if head.contains("# Definition") || head.contains("Guarantee:") {
                defined += 1;
                for (wanted, what) in [("uarantee", "guarantee"), ("# Assumes\n//! ", "assumption")]
                {
                    assert!(head.contains(wanted), "{} states no {what}", path.display());
                }
            }
        }
    }
    assert!(defined > 100, "only {defined} definitions were found");
}

#[test]
fn unsafe_stands_only_where_it_is_allowed() {
    let mut found = Vec::new();
    for path in rust_files(&root().join("crates")) {
        let name = shown(&path);
        let allowed = MAY_BE_UNSAFE
            .iter()
            .any(|home| name == *home || name.starts_with(&format!("{home}/")));
        if !allowed {
            let code = without_comments_and_texts(&read(&path));
            let lines = lines_with(&code, "unsafe");
            found.extend(lines.iter().map(|line| format!("{name}:{line}")));
        }
    }
    assert!(
        found.is_empty(),
        "unsafe outside {MAY_BE_UNSAFE:?}:\n{}",
        found.join("\n")
    );
}

#[test]
fn the_tables_describe_the_sources_at_hand() {
    for home in MAY_BE_UNSAFE {
        assert!(
            root().join(home).exists(),
            "{home} is gone: take it out of the table"
        );
    }
    for (name, ..) in CRATES {
        let sources = rust_files(&root().join("crates").join(name).join("src"));
        assert!(!sources.is_empty(), "{name} has no sources");
    }
}

#[test]
fn architecture_md_is_short_and_names_every_crate() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let lines = text.lines().count();
    assert!(
        lines <= 200,
        "ARCHITECTURE.md has {lines} lines, 200 are allowed"
    );
    for (name, ..) in CRATES {
        assert!(
            text.contains(&format!("`{name}`")),
            "ARCHITECTURE.md does not mention `{name}`"
        );
    }
}

/// A file of tests that no program declares would be lost in silence.
#[test]
fn every_file_of_tests_is_declared() {
    let packages = metadata();
    for package in packages.workspace_packages() {
        let folder = root()
            .join("crates")
            .join(crate_name(&package.name))
            .join("tests");
        let programs = package.targets.iter().filter(|target| target.is_test());
        let expected = usize::from(folder.join("integration").exists());
        assert_eq!(programs.count(), expected, "{}", package.name);
    }
    for (name, ..) in CRATES {
        let folder = root().join("crates").join(name).join("tests");
        let Ok(entries) = std::fs::read_dir(folder.join("integration")) else {
            continue;
        };
        let main = read(&folder.join("integration/main.rs"));
        let declared: BTreeSet<&str> = main
            .lines()
            .filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'))
            .collect();
        for entry in entries.flatten() {
            let file = entry.file_name().to_string_lossy().into_owned();
            let stem = file.strip_suffix(".rs").unwrap_or(&file);
            let is_module = entry.path().is_dir() || file.ends_with(".rs") && stem != "main";
            assert!(
                !is_module || declared.contains(stem),
                "{name}: tests/integration/main.rs does not declare {file}"
            );
        }
        let beside = std::fs::read_dir(&folder).expect("its parent").flatten();
        let lost: Vec<_> = beside
            .filter(|entry| entry.path().extension().is_some_and(|e| e == "rs"))
            .map(|entry| entry.path())
            .collect();
        assert!(lost.is_empty(), "no program runs the tests of {lost:?}");
    }
}

#[test]
fn design_md_gives_a_reason_for_every_dependency() {
    let text = read(&root().join("DESIGN.md"));
    let metadata = metadata();
    let members: Vec<&str> = CRATES.iter().map(|(name, ..)| *name).collect();
    let mut missing = BTreeSet::new();
    for package in metadata.workspace_packages() {
        for dependency in &package.dependencies {
            let name = crate_name(&dependency.name);
            if !members.contains(&name) && !text.contains(&format!("`{name}`")) {
                missing.insert(name.to_owned());
            }
        }
    }
    assert!(
        missing.is_empty(),
        "DESIGN.md gives no reason for {missing:?}"
    );
}

/// Absolute folders of somebody's machine and addresses of package registries have no place in the project.
#[test]
fn no_file_names_a_machine_or_a_registry() {
    let unwanted: Vec<String> = [
        ("/wo", "rk/"),
        ("/ro", "ot/"),
        ("/ho", "me/"),
        ("pypi", ".org"),
        ("crates", ".io"),
        ("npmjs", ".org"),
        ("npmjs", ".com"),
        ("pythonhosted", ".org"),
        ("docker", ".io"),
        ("ghcr", ".io"),
        ("127.0", ".0.1"),
    ]
    .map(|(a, b)| format!("{a}{b}"))
    .into();
    let mut found = Vec::new();
    for path in files_below(&root()) {
        // The lock file is cargo's own.
        if path.file_name().is_some_and(|name| name == "Cargo.lock") {
            continue;
        }
        let Ok(text) = std::fs::read_to_string(&path) else {
            continue;
        };
        for word in unwanted.iter().filter(|word| text.contains(word.as_str())) {
            found.push(format!("{}: {word}", shown(&path)));
        }
    }
    assert!(
        found.is_empty(),
        "named where they should not be:\n{}",
        found.join("\n")
    );
}

#[test]
fn the_scanner_sees_code_and_nothing_else() {
    let source = r##"
use std::{env, io::{self, Read}, fs::File};
// println!("in a comment")
/* unsafe /* nested */ std::fs */
fn f<'a>(x: &'a str) -> char { let _ = "unsafe \" std::fs"; let _ = r#"print!"#; let _ = '"'; '\'' }
fn g() { println!("{}", 1); }
#[cfg(test)]
mod tests { fn h() { std::fs::read("x"); } }
fn after() { eprintln!("x") }
"##;
    let code = with_groups_written_out(&product_code(source));
    assert_eq!(lines_with(&code, "std::env"), [2]);
    assert_eq!(lines_with(&code, "std::fs"), [2]);
    assert_eq!(lines_with(&code, "println!"), [6]);
    assert_eq!(lines_with(&code, "eprintln!"), [9]);
    assert!(lines_with(&code, "unsafe").is_empty());
    assert!(lines_with(&code, "print!").is_empty());
    assert_eq!(code.lines().count(), source.lines().count());
}
