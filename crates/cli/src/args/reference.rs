//! The reference of all commands (`docs/reference/commands.md`), made of the definitions by which arguments are parsed.

use clap::{Arg, Command, CommandFactory};
use std::fmt::Write as _;

const HEAD: &str = "\
# Commands

Made of the definitions by which arguments are parsed; `corroborate COMMAND --help` prints the same. Options in bold are
required. The forms of JSON that `--format json` prints are in [`schemas/`](../../schemas). A `TIME` is a number of seconds, or a
number and a unit: `ns`, `us`, `ms`, `s`, `min` or `m`, `h`, `d`, `w` (`300`, `300s`, `5m` and `5 min` are the same); so are durations
in `topics.toml`. In sentences and requirements `m` is the metre.

";

/// All commands, in Markdown.
fn reference() -> String {
    let mut all = super::Arguments::command();
    all.build();
    let mut output = String::from(HEAD);
    let _ = writeln!(output, "| command | does |\n|---|---|");
    for command in shown(&all) {
        let name = command.get_name();
        let _ = writeln!(output, "| [`{name}`](#{name}) | {} |", about(command));
    }
    output += "\n## Options of every command\n";
    let everywhere = all.get_arguments().filter(|it| it.is_global_set());
    options(&mut output, everywhere);
    after(&mut output, &all);
    for command in shown(&all) {
        let _ = write!(
            output,
            "\n## {}\n\n{}\n",
            command.get_name(),
            about(command)
        );
        usage(&mut output, command);
        arguments(&mut output, command);
        let own = command.get_opts().chain(flags(command));
        options(&mut output, own.filter(|it| !it.is_global_set()));
        after(&mut output, command);
    }
    output
}

/// The commands that `--help` lists, but `help` itself.
fn shown(all: &Command) -> impl Iterator<Item = &Command> {
    let commands = all.get_subcommands();
    commands.filter(|it| !it.is_hide_set() && it.get_name() != "help")
}

/// Options without a value, but those of clap itself.
fn flags(command: &Command) -> impl Iterator<Item = &Arg> {
    let optional = command.get_arguments().filter(|it| !it.is_positional());
    optional.filter(|it| !takes_value(it) && !matches!(it.get_id().as_str(), "help" | "version"))
}

fn takes_value(argument: &Arg) -> bool {
    argument.get_action().takes_values()
}

fn about(command: &Command) -> String {
    let about = command.get_long_about().or(command.get_about());
    one_line(&about.map(ToString::to_string).unwrap_or_default())
}

fn usage(output: &mut String, command: &Command) {
    let usage = command.clone().render_usage().to_string();
    let lines = usage
        .lines()
        .map(|line| line.trim_start_matches("Usage:").trim());
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    let _ = write!(output, "\n```text\n{}\n```\n", lines.join("\n"));
}

fn arguments(output: &mut String, command: &Command) {
    let positional: Vec<&Arg> = command
        .get_positionals()
        .filter(|it| !it.is_hide_set())
        .collect();
    if positional.is_empty() {
        return;
    }
    *output += "\n| argument | meaning |\n|---|---|\n";
    for argument in positional {
        row(output, &value_names(argument), argument);
    }
}

/// A table of options, of which hidden ones are left out.
fn options<'a>(output: &mut String, options: impl Iterator<Item = &'a Arg>) {
    let shown: Vec<&Arg> = options.filter(|it| !it.is_hide_set()).collect();
    if shown.is_empty() {
        return;
    }
    *output += "\n| option | meaning |\n|---|---|\n";
    for option in shown {
        row(output, &spelling(option), option);
    }
}

fn row(output: &mut String, spelling: &str, argument: &Arg) {
    let mark = if argument.is_required_set() { "**" } else { "" };
    let meaning = cell(&meaning(argument));
    let _ = writeln!(output, "| {mark}`{}`{mark} | {meaning} |", cell(spelling));
}

/// How an option is written, for example `--threads N, -j N`.
fn spelling(option: &Arg) -> String {
    let value = match takes_value(option) {
        true => format!(" {}", value_names(option)),
        false => String::new(),
    };
    let long = option.get_long().map(|name| format!("--{name}{value}"));
    let short = option.get_short().map(|letter| format!("-{letter}{value}"));
    long.into_iter().chain(short).collect::<Vec<_>>().join(", ")
}

fn value_names(argument: &Arg) -> String {
    let names = argument.get_value_names().unwrap_or_default();
    let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
    let several = argument
        .get_num_args()
        .is_some_and(|count| count.max_values() > 1);
    let dots = if several || repeats(argument) {
        "..."
    } else {
        ""
    };
    names.join(" ") + dots
}

/// Whether an argument without a name takes all words that follow.
fn repeats(argument: &Arg) -> bool {
    argument.is_positional() && matches!(argument.get_action(), clap::ArgAction::Append)
}

/// What an argument says, its words if it has a choice of them, and what counts where it is left out.
fn meaning(argument: &Arg) -> String {
    let help = argument.get_long_help().or(argument.get_help());
    let mut meaning = one_line(&help.map(ToString::to_string).unwrap_or_default());
    let values = argument.get_possible_values();
    if takes_value(argument) && !values.is_empty() {
        let words = values.iter().filter(|it| !it.is_hide_set()).map(|word| {
            let help = word.get_help().map(|help| one_line(&help.to_string()));
            let help = help.map(|help| format!(" ({})", help.trim_end_matches('.')));
            format!("`{}`{}", word.get_name(), help.unwrap_or_default())
        });
        let _ = write!(meaning, " One of {}.", words.collect::<Vec<_>>().join(", "));
    }
    let default = argument.get_default_values().first();
    if let Some(default) = default.filter(|_| takes_value(argument)) {
        let _ = write!(meaning, " Default: `{}`.", default.to_string_lossy());
    }
    meaning
}

fn after(output: &mut String, command: &Command) {
    let text = command.get_after_help().map(ToString::to_string);
    let text = text.unwrap_or_default();
    if !text.is_empty() {
        let _ = write!(output, "\n```text\n{}\n```\n", text.trim());
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text as one cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[test]
fn the_committed_reference_of_the_commands_is_made_of_their_definitions() {
    crate::command::tests::assert_is_committed("docs/reference/commands.md", &reference());
}

#[test]
fn every_argument_of_every_command_has_a_meaning() {
    let all = super::Arguments::command();
    for command in shown(&all) {
        for argument in command.get_arguments().filter(|it| !it.is_hide_set()) {
            let said = meaning(argument);
            let name = command.get_name();
            assert!(
                said.contains(' '),
                "{name}: {} has no description",
                argument.get_id()
            );
        }
    }
}
