//! Any text is read without a crash, and every place that is reported lies within it.

use proptest::prelude::*;
use requirement_lang::compile::coverage::bins;
use requirement_lang::compile::goal::trace_goal;
use requirement_lang::compile::monitor::monitor;
use requirement_lang::{Context, explain, parse};

const WORDS: [&str; 56] = [
    "in",
    "while",
    "during",
    "before",
    "after",
    "only",
    "when",
    "whenever",
    "if",
    "unless",
    "not",
    "the",
    "robot",
    "shall",
    "with",
    "probability",
    "at",
    "least",
    "most",
    "95",
    "%",
    "of",
    "cases",
    "0.9",
    "immediately",
    "next",
    "step",
    "eventually",
    "always",
    "never",
    "within",
    "2",
    "s",
    "for",
    "until",
    "satisfy",
    "then",
    "repeatedly",
    "a",
    "b",
    "and",
    "or",
    "=>",
    "<=>",
    "(",
    ")",
    ",",
    ".",
    "x < 3 m/s",
    "mode",
    "is",
    "true",
    "'q",
    "!",
    "é",
    "5 steps",
];

fn check(text: &str) -> Result<(), TestCaseError> {
    let context = Context {
        parameters: None,
        vocabulary: Some(&["a", "b"]),
    };
    for context in [context, Context::default()] {
        let parsed = parse(text, &context);
        for diagnostic in &parsed.diagnostics {
            let place = text.get(diagnostic.span.start..diagnostic.span.end);
            prop_assert!(place.is_some(), "{diagnostic:?} in {text:?}");
            prop_assert!(diagnostic.remedy.is_some());
        }
        let _ = (explain(&parsed.tree), parsed.tree.to_string());
        let forms = (
            monitor(&parsed.tree),
            trace_goal(&parsed.tree),
            bins(&parsed.tree),
        );
        if !parsed.has_errors() {
            prop_assert!(
                forms.0.is_ok() && forms.1.is_ok() && forms.2.is_ok(),
                "{text:?}: {forms:?}"
            );
            let canonical = parsed.tree.to_string();
            let again = parse(&canonical, &Context::default());
            prop_assert!(
                !again.has_errors(),
                "{text:?} is printed {canonical:?}: {:?}",
                again.diagnostics
            );
            prop_assert_eq!(again.tree.to_string(), canonical);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn rows_of_keywords(words in proptest::collection::vec(proptest::sample::select(&WORDS[..]), 0..24)) {
        check(&words.join(" "))?;
        check(&words.concat())?;
    }

    #[test]
    fn sentences_with_rows_of_keywords(
        left in proptest::collection::vec(proptest::sample::select(&WORDS[..]), 0..8),
        right in proptest::collection::vec(proptest::sample::select(&WORDS[..]), 0..8),
    ) {
        check(&format!("{}, the robot shall {}", left.join(" "), right.join(" ")))?;
    }

    #[test]
    fn any_letters(text in "\\PC{0,60}") {
        check(&text)?;
    }
}

#[test]
fn deep_nesting_is_refused_or_read_but_never_exhausts_the_stack() {
    for depth in [10, 500, 100_000] {
        let check = |expression: &str, fits: bool| {
            let text = format!("the robot shall always satisfy {expression}");
            let parsed = parse(&text, &Context::default());
            assert_eq!(
                parsed.has_errors(),
                !fits,
                "depth {depth}: {:?}",
                parsed.diagnostics.first()
            );
            assert_eq!(monitor(&parsed.tree).is_ok(), fits);
            let _ = (parsed.tree.to_string(), explain(&parsed.tree));
        };
        check(
            &format!("{}a{}", "(".repeat(depth), ")".repeat(depth)),
            depth <= 64,
        );
        check(&format!("{}a", "not ".repeat(depth)), depth < 2000);
        check(&vec!["a"; depth].join(" => "), depth < 1000);
        check(&vec!["a"; depth].join(" <=> "), depth < 1000);
    }
}
