//! A problem as it is shown on a terminal, with the lines of the text that it speaks of, and its exit code.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use diagnostic::{Excerpt, Kind, Problem};

/// The exit code that a problem ends the program with.
pub fn exit_code(problem: &Problem) -> u8 {
    match problem.kind() {
        Kind::Input => 2,
        Kind::DataLost | Kind::Undecided => 3,
        Kind::Interrupted => 130,
    }
}

/// The problem as it is shown to the user, with all others of the same input.
pub fn rendered(problem: &Problem, colour: bool) -> String {
    let renderer = match colour {
        true => Renderer::styled(),
        false => Renderer::plain(),
    };
    let all = std::iter::once(problem).chain(problem.others());
    let shown = all.map(|one| renderer.render(&groups(one)).to_string());
    let shown: Vec<String> = shown.chain(problem.rest()).collect();
    shown.join("\n\n")
}

fn groups(problem: &Problem) -> Vec<Group<'_>> {
    let title = Level::ERROR.primary_title(problem.message());
    let title = match problem.kind() {
        Kind::Interrupted => title,
        _ => title.id(problem.code),
    };
    let mut group = match problem.place() {
        Some(place) => match &place.excerpt {
            Some(excerpt) => title.element(snippet(&place.name, excerpt)),
            None => title.element(
                Origin::path(place.name.as_str())
                    .line(place.line)
                    .char_column(place.column),
            ),
        },
        None => Group::with_title(title),
    };
    if let Some(remedy) = problem.what_to_do() {
        group = group.element(Level::HELP.message(remedy));
    }
    vec![group]
}

fn snippet<'a>(
    name: &'a str,
    excerpt: &'a Excerpt,
) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
    let related = excerpt.related.iter().map(|(span, note)| {
        AnnotationKind::Context
            .span(span.clone())
            .label(note.as_str())
    });
    Snippet::source(excerpt.text.as_str())
        .line_start(excerpt.first_line)
        .path(name)
        .annotation(AnnotationKind::Primary.span(excerpt.span.clone()))
        .annotations(related)
}

#[cfg(test)]
mod tests {
    use super::*;
    use annotate_snippets::Annotation;
    use std::ops::Range;

    /// The part of a range that lies in the text, between characters.
    fn within(text: &str, range: Range<usize>) -> Range<usize> {
        let boundary = |offset: usize| {
            let mut at = offset.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = boundary(range.start);
        start..boundary(range.end).max(start)
    }

    fn drawn(snippet: Snippet<'_, Annotation<'_>>) -> String {
        let group = Level::ERROR.primary_title("wrong").element(snippet);
        Renderer::plain().render(&[group]).to_string()
    }

    /// An excerpt looks as all of the text would.
    #[test]
    fn an_excerpt_is_rendered_as_the_whole_text_is() {
        let short: String = (1..=40).map(|line| format!("line é {line};\n")).collect();
        let long: String = (1..=2_000)
            .map(|line| format!("line é {line};\n"))
            .collect();
        for text in [short.as_str(), &long, "one line", "", "\n", "a\n\nb"] {
            let length = text.len();
            for (from, to) in [
                (0, 4),
                (length / 2, length / 2 + 30),
                (length, length),
                (length / 3, length),
            ] {
                let (span, other) = (
                    within(text, from..to),
                    within(text, length / 4..length / 4 + 3),
                );
                let whole = Snippet::source(text)
                    .path("name")
                    .annotation(AnnotationKind::Primary.span(span.clone()))
                    .annotation(AnnotationKind::Context.span(other.clone()).label("this"));
                let excerpt = Excerpt::new(text, span, vec![(other, "this".into())]);
                let excerpt = excerpt.expect("lines are short");
                assert_eq!(drawn(snippet("name", &excerpt)), drawn(whole));
            }
        }
    }
}
