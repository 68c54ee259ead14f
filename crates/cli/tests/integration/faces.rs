//! What a face may do: translate arguments, call the library, render. One command does not do another's work.

use crate::support::source::{lines_with, product_code, with_groups_of};
use crate::support::{files_below, read, root, shown};
use std::path::Path;

/// A command: its module, and the type of its arguments.
type Command = (String, String);

/// The commands, as `args.rs` declares them.
fn commands() -> Vec<Command> {
    let code = product_code(&read(&root().join("crates/cli/src/args.rs")));
    let (_, variants) = code.split_once("pub enum Command {").expect("the commands");
    let (variants, _) = variants.split_once("\n}").expect("its end");
    let variants = variants.lines().filter_map(|line| {
        let (variant, arguments) = line.trim().strip_suffix("),")?.split_once('(')?;
        let arguments = arguments.trim_start_matches("Box<").trim_end_matches('>');
        Some((snake_case(variant), arguments.to_owned()))
    });
    variants.collect()
}

fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for (at, character) in name.char_indices() {
        if character.is_uppercase() && at > 0 {
            snake.push('_');
        }
        snake.extend(character.to_lowercase());
    }
    snake
}

/// The command whose file this is, or that of the folder in which it lies, and how deep.
fn of_command(path: &Path) -> (String, usize) {
    let below = path.strip_prefix(root().join("crates/cli/src/command"));
    let below = below.expect("a file of a command");
    let parts: Vec<_> = below.components().collect();
    let first = Path::new(parts.first().expect("a name").as_os_str());
    let name = first.file_stem().expect("a name").to_string_lossy();
    (name.into_owned(), parts.len())
}

/// The lines of a command's file that name the module of another command, or its arguments.
fn names_another(code: &str, own: &str, depth: usize, commands: &[Command]) -> Vec<usize> {
    let above = "super::".repeat(depth);
    let mut code = code.to_owned();
    for path in [above.as_str(), "crate::command::", "crate::args::"] {
        code = with_groups_of(&code, path);
    }
    let others = commands.iter().filter(|(module, _)| module != own);
    let ways = others.flat_map(|(module, arguments)| {
        [
            format!("{above}{module}"),
            format!("crate::command::{module}"),
            format!("crate::args::{arguments}"),
        ]
    });
    ways.flat_map(|way| lines_with(&code, &way)).collect()
}

#[test]
fn no_command_uses_another_command_or_makes_up_its_arguments() {
    let commands = commands();
    assert!(commands.len() > 20, "only {commands:?} were found");
    let mut found = Vec::new();
    for path in files_below(&root().join("crates/cli/src/command")) {
        let (own, depth) = of_command(&path);
        let is_known = commands.iter().any(|(module, _)| *module == own);
        assert!(is_known, "{} is of no command", shown(&path));
        let code = product_code(&read(&path));
        let lines = names_another(&code, &own, depth, &commands);
        found.extend(lines.iter().map(|line| format!("{}:{line}", shown(&path))));
    }
    assert!(
        found.is_empty(),
        "call the library, or move what both need into it:\n{}",
        found.join("\n")
    );
}

#[test]
fn the_search_sees_other_commands_and_nothing_else() {
    let commands = [
        ("run", "Run"),
        ("report", "Report"),
        ("format", "FormatFiles"),
    ];
    let commands = commands.map(|(module, arguments)| (module.into(), arguments.into()));
    let source = "
use super::{Done, run};
use crate::args::{Format, FormatFiles, Report};
fn f() { crate::command::run::whole() }
use report::html;
use super::json;
";
    assert_eq!(names_another(source, "report", 1, &commands), [2, 4, 3]);
    assert_eq!(names_another(source, "run", 1, &commands), [3, 3]);
    let deeper = "use super::run;\nuse super::super::{Done, run};\n";
    assert_eq!(names_another(deeper, "report", 2, &commands), [2]);
}
