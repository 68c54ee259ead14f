//! Where the gates of a text stand.

use std::ops::Range;

use diagnostic::Source;

use super::lexer::{Placed, Token, tokens};
use super::statement::connective_of;
use crate::mistakes::Mistakes;
use crate::rewrites::{Written, WrittenGate};

/// The gates and events of a text that can be read; what cannot is left out.
pub(crate) fn written_in_galileo(text: &str) -> Written {
    let source = Source {
        name: String::new(),
        text: text.to_owned(),
    };
    // What is wrong with the text is said where it is read.
    let mut mistakes = Mistakes::new(&source);
    let all = tokens(text, &mut mistakes);
    let statements = all.split(|(token, _)| *token == Token::Semicolon);
    let mut found = Written::default();
    for statement in statements {
        found.gates.extend(gate(statement));
        found.events.extend(event(statement));
    }
    found
}

fn event(statement: &[Placed<'_>]) -> Option<String> {
    match statement {
        [
            (Token::Quoted(name) | Token::Word(name), _),
            (Token::Word(_), _),
            (Token::Equals, _),
            ..,
        ] => Some((*name).to_owned()),
        _ => None,
    }
}

fn gate(statement: &[Placed<'_>]) -> Option<WrittenGate> {
    let [
        (Token::Quoted(name) | Token::Word(name), _),
        (Token::Word(kind), place),
        arguments @ ..,
    ] = statement
    else {
        return None;
    };
    let named = arguments.iter().map(|(token, span)| match token {
        Token::Quoted(name) | Token::Word(name) => Some((Some((*name).to_owned()), span.clone())),
        Token::Equals | Token::Semicolon => None,
    });
    let arguments: Option<Vec<(Option<String>, Range<usize>)>> = named.collect();
    let arguments = arguments.filter(|it| !it.is_empty())?;
    Some(WrittenGate {
        name: (*name).to_owned(),
        connective: connective_of(kind, arguments.len())?,
        words: vec![place.clone()],
        arguments,
    })
}
