//! A model given by its states and transitions: PRISM's files (`.tra`, `.sta`, `.lab`, `.srew`, `.trew`) or Storm's.

use crate::request::{CheckRequest, ModelInput};
use checker::formats::{ExplicitError, ExplicitFiles, read_drn, read_explicit};
use checker::state_space::StateSpace;
use diagnostic::{Problem, Source};
use host::Events;
use prism_lang::Arithmetic;
use prism_lang::resolved::ModelType;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The forms of PRISM's files.
const FORMS: [&str; 5] = ["tra", "sta", "lab", "srew", "trew"];

/// The texts of a model's files.
pub(crate) struct Files {
    kind: Option<ModelType>,
    content: Content,
}

enum Content {
    Drn(Source),
    /// With the form of each; those of rewards with the number of their structure.
    Parts(Vec<(&'static str, usize, Source)>),
}

impl Files {
    /// Reads the files, if the request names some in place of a model in the PRISM language.
    pub fn read(request: &CheckRequest, talk: &Events) -> Result<Option<Self>, Problem> {
        let named = Self::named(request)?;
        if named.is_empty() {
            return Ok(None);
        }
        for (what, is_set) in [
            ("with open constants", request.open.is_some()),
            ("that is to be certified", request.certify),
            ("with rounded probabilities", request.sum_roundoff.is_some()),
        ] {
            if is_set {
                let message = format!("a model {what} must be in the PRISM language");
                let remedy = "give the file that the states and transitions were made from";
                return Err(Problem::new("unsupported", message).remedy(remedy));
            }
        }
        let own = [
            ModelType::Dtmc,
            ModelType::Ctmc,
            ModelType::Mdp,
            ModelType::Lts,
        ];
        let asked = request.model_type.map(|asked| asked.keyword());
        let kind = own.into_iter().find(|kind| Some(kind.keyword()) == asked);
        if let [("drn", _, path)] = &named[..] {
            let content = Content::Drn(host::files::read_any_size(path)?);
            return Ok(Some(Self { kind, content }));
        }
        if !named.iter().any(|(form, ..)| *form == "tra") {
            let message = "the transitions of the model are missing";
            let remedy = "give FILE.tra as the model";
            return Err(Problem::new("no-transitions", message).remedy(remedy));
        }
        say_what_is_not_read(&named, talk);
        let parts = named
            .into_iter()
            .map(|(form, structure, path)| {
                Ok((form, structure, host::files::read_any_size(&path)?))
            })
            .collect::<Result<_, Problem>>()?;
        let content = Content::Parts(parts);
        Ok(Some(Self { kind, content }))
    }

    /// The files that the request names: form, number of the reward structure, path.
    fn named(request: &CheckRequest) -> Result<Vec<(&'static str, usize, PathBuf)>, Problem> {
        let mut named: Vec<(&'static str, usize, PathBuf)> = Vec::new();
        for asked in &request.imports {
            let (form, path) = asked.split_once('=').unwrap_or(("", asked));
            let Some(form) = FORMS.into_iter().find(|known| *known == form) else {
                let message = format!("`{asked}` names no part of a model to read");
                let remedy = format!("write FORM=FILE; the forms are {}", FORMS.join(", "));
                return Err(Problem::new("bad-form", message).remedy(remedy));
            };
            let before = named.iter().filter(|(known, ..)| *known == form).count();
            named.push((form, before, PathBuf::from(path)));
        }
        if named.iter().any(|(form, ..)| *form == "tra") {
            return Ok(named);
        }
        let ModelInput::File(model) = &request.model else {
            return Ok(named);
        };
        let ending = model.extension().and_then(|e| e.to_str());
        match ending {
            Some("drn") if named.is_empty() => {
                named.push(("drn", 0, model.clone()));
            }
            Some("all") => named.extend(all(model)),
            Some(endings) if endings.split(',').all(|e| FORMS.contains(&e)) => {
                for form in FORMS
                    .into_iter()
                    .filter(|f| endings.split(',').any(|e| e == *f))
                {
                    let found = beside(model, form);
                    // One that is not there is an error of reading it.
                    match found.is_empty() {
                        true => named.push((form, 0, model.with_extension(form))),
                        false => named.extend(found),
                    }
                }
            }
            _ => {}
        }
        Ok(named)
    }

    /// The state space.
    pub fn space<N: Arithmetic>(&self) -> Result<StateSpace<N>, Problem> {
        match &self.content {
            Content::Drn(source) => read_drn(&source.text).map_err(|error| wrong(source, &error)),
            Content::Parts(parts) => {
                let text = |form: &str| {
                    let found = parts.iter().find(|(known, ..)| *known == form);
                    found.map(|(_, _, source)| source.text.as_str())
                };
                let structures = parts.iter().map(|(_, structure, _)| structure + 1);
                let rewards = |structure: usize| {
                    let of = |form: &str| {
                        let is_it =
                            |part: &&(&str, usize, Source)| (part.0, part.1) == (form, structure);
                        parts
                            .iter()
                            .find(is_it)
                            .map_or("", |part| part.2.text.as_str())
                    };
                    (of("srew"), of("trew"))
                };
                let given = |(states, transitions): &(&str, &str)| {
                    !(states.is_empty() && transitions.is_empty())
                };
                let files = ExplicitFiles {
                    kind: self.kind,
                    transitions: text("tra").unwrap_or_default(),
                    states: text("sta"),
                    labels: text("lab"),
                    rewards: (0..structures.max().unwrap_or(0))
                        .map(rewards)
                        .filter(given)
                        .collect(),
                };
                read_explicit(&files).map_err(|error| {
                    // Of several files of rewards the first is named: the message says which form it is.
                    let found = parts.iter().find(|(form, ..)| *form == error.file);
                    let source = found.or(parts.first()).map(|(_, _, source)| source);
                    source.map_or_else(
                        || Problem::new("bad-model-file", error.to_string()),
                        |source| wrong(source, &error),
                    )
                })
            }
        }
    }
}

/// All files of a model that there are; its transitions even if they are not, which is an error of reading them.
fn all(model: &Path) -> Vec<(&'static str, usize, PathBuf)> {
    let mut found = vec![("tra", 0, model.with_extension("tra"))];
    for form in &FORMS[1..] {
        found.extend(beside(model, form));
    }
    found
}

/// The files of a form: one, or one for each reward structure, numbered from 1.
fn beside(model: &Path, form: &'static str) -> Vec<(&'static str, usize, PathBuf)> {
    let path = model.with_extension(form);
    if path.exists() {
        return vec![(form, 0, path)];
    }
    if !form.ends_with("rew") {
        return Vec::new();
    }
    let stem = model.with_extension("").display().to_string();
    let numbered = |structure: usize| PathBuf::from(format!("{stem}{}.{form}", structure + 1));
    (0..)
        .map(|structure| (form, structure, numbered(structure)))
        .take_while(|(_, _, path)| path.exists())
        .collect()
}

/// Labels and values that lie beside the transitions and are not read would be missed.
fn say_what_is_not_read(named: &[(&'static str, usize, PathBuf)], talk: &Events) {
    let Some((_, _, transitions)) = named.iter().find(|(form, ..)| *form == "tra") else {
        return;
    };
    let is_unread = |form: &&&str| !named.iter().any(|(known, ..)| known == *form);
    let unread: Vec<String> = FORMS[1..]
        .iter()
        .filter(is_unread)
        .flat_map(|form| beside(transitions, form))
        .map(|(_, _, path)| path.display().to_string())
        .collect();
    if !unread.is_empty() {
        let all = transitions.with_extension("all");
        talk.say(&format!(
            "note: {} {} not read; give {} as the model to read all of them",
            unread.join(", "),
            if unread.len() == 1 { "is" } else { "are" },
            all.display()
        ));
    }
}

/// A line of a file that is wrong.
fn wrong(source: &Source, error: &ExplicitError) -> Problem {
    let place = line(&source.text, error.line);
    Problem::new("bad-model-file", error.message.as_str())
        .remedy("correct the line; Storm and PRISM write such files (`-exportmodel`), and so does `corroborate export`")
        .at(source, place)
}

/// Where a line of a text lies, without its end; behind the last line, the end of the text.
fn line(text: &str, number: usize) -> Range<usize> {
    let before = text.split_inclusive('\n').take(number.saturating_sub(1));
    let begin = before.map(str::len).sum();
    let own = text[begin..].lines().next().unwrap_or_default();
    begin..begin + own.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_line_has_its_place() {
        assert_eq!(line("a\nbc\r\nd", 2), 2..4);
        assert_eq!(line("a\nbc\n", 3), 5..5);
        let error = ExplicitError {
            file: "tra",
            line: 2,
            message: "wrong".to_owned(),
        };
        let problem = wrong(&Source::new("m.tra", "1 1\nx"), &error);
        let place = problem.place().expect("a place");
        assert_eq!(
            (place.name.as_str(), place.line, place.column),
            ("m.tra", 2, 1)
        );
    }
}
