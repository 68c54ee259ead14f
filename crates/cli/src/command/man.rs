//! `corroborate man`: manual pages, made of the definitions by which arguments are parsed.

use super::Done;
use crate::args::{Arguments, Man};
use clap::{Command, CommandFactory};
use clap_mangen::Man as Page;
use corroborate::Outcome;
use diagnostic::{Problem, counted, did_you_mean};
use host::files::write_whole;
use std::path::Path;

/// Prints a page, or writes all.
pub fn man(arguments: &Man) -> Result<Done, Problem> {
    let mut all = Arguments::command();
    all.build();
    let output = match (&arguments.out, &arguments.page) {
        (Some(folder), _) => write_all(&all, folder)?,
        (None, None) => page(&all)?,
        (None, Some(name)) => page(find(&all, name)?)?,
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

/// The commands that have a page.
fn shown(all: &Command) -> impl Iterator<Item = &Command> {
    all.get_subcommands()
        .filter(|it| !it.is_hide_set() && it.get_name() != "help")
}

fn find<'c>(all: &'c Command, name: &str) -> Result<&'c Command, Problem> {
    let mut commands = shown(all);
    commands.find(|it| it.get_name() == name).ok_or_else(|| {
        let message = format!("there is no command `{name}`");
        Problem::new("unknown-command", message).remedy(
            match did_you_mean(name, shown(all).map(Command::get_name)) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "`corroborate --help` lists the commands".to_owned(),
            },
        )
    })
}

/// The page of a command in the language of `man`.
fn page(command: &Command) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    let rendered = Page::new(command.clone()).render(&mut bytes);
    let text = rendered.ok().and_then(|()| String::from_utf8(bytes).ok());
    text.ok_or_else(|| Problem::new("not-text", "the manual page is not text"))
}

fn write_all(all: &Command, folder: &Path) -> Result<String, Problem> {
    let mut count = 0_usize;
    for command in std::iter::once(all).chain(shown(all)) {
        let name = match command.get_name() {
            "corroborate" => "corroborate.1".to_owned(),
            own => format!("corroborate-{own}.1"),
        };
        write_whole(&folder.join(name), page(command)?.as_bytes())?;
        count += 1;
    }
    Ok(format!(
        "{} written to {}\n",
        counted(count, "page"),
        folder.display()
    ))
}
