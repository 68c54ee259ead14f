//! How results are drawn: the page, and the argument of an assurance case.

use corroborate::StudyResult;
use corroborate::assure::{Argued, Drawing};
use report::assurance;

/// How the page and the argument of an assurance case are drawn.
pub fn drawing() -> Drawing<'static> {
    Drawing {
        page: &report::html,
        argument: &argued,
        statement_file: &assurance::statement_file,
    }
}

/// The argument of a result, in the files that are written of it.
fn argued(result: &StudyResult) -> Argued {
    let case = assurance::case(result);
    let count = |wanted: fn(&assurance::Node) -> bool| {
        let nodes = case.safety.nodes.iter().chain(&case.confidence.nodes);
        nodes.filter(|node| wanted(node)).count()
    };
    let named = |name: &str, text: String| (name.to_owned(), text);
    Argued {
        elements: count(|_| true),
        undeveloped: count(|node| node.undeveloped),
        defeated: count(|node| node.defeated),
        files: vec![
            named("argument.gsn.yaml", assurance::yaml(&case.safety)),
            named("confidence.gsn.yaml", assurance::yaml(&case.confidence)),
            named("argument.sacm.xmi", assurance::sacm(&case)),
            named("provenance.json", assurance::provenance(result)),
        ],
    }
}
