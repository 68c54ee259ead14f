//! An assurance case in the Structured Assurance Case Metamodel (SACM), for tools that exchange cases.
//!
//! # Definition
//! One assurance case package with two argument packages (the safety argument and the argument for its confidence) and a package
//! of artifacts, one for each piece of evidence that is cited:
//!
//! | GSN | SACM |
//! |---|---|
//! | goal, counter goal | `Claim`; `needsSupport` if undeveloped, `defeated` if defeated |
//! | strategy | `ArgumentReasoning` of the relations from what stands below it to the goal above it |
//! | solution, counter solution | `ArtifactReference`; where evidence is cited, to its `Artifact` |
//! | supported by a goal; by a solution | `AssertedInference`; `AssertedEvidence` |
//! | context; justification | `Claim`, asserted; axiomatic; by `AssertedContext` |
//! | challenges | `AssertedInference` with `isCounter` |
//! | assurance claim point | `metaClaim` of the relation or claim: the goal of the confidence argument |
//!
//! # Source
//! OMG, *Structured Assurance Case Metamodel*, version 2.3, whose namespaces are those of the metamodel for the
//! Eclipse Modelling Framework; XMI 2 as that framework writes it. The table: Wei, Kelly, Dai, Zhao, Hawkins, "Model based system
//! assurance using the Structured Assurance Case Metamodel", Journal of Systems and Software 154 (2019).
//!
//! # Deviation
//! There a context is a reference to an artifact. Contexts here are statements, so they are claims in context. An undeveloped
//! strategy is a relation without sources that needs support.
//!
//! # Guarantee
//! Every identifier is unique, every reference is to an element of the file and of a type that the metamodel asks for. Letters that
//! XML cannot hold are written as U+FFFD. Cost: linear in the argument times its relations.

use super::node::{Argument, Kind, Node};
use super::{AssuranceCase, statement_file};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Namespaces by prefix.
const NAMESPACES: [(&str, &str); 5] = [
    ("xmi", "http://www.omg.org/XMI"),
    ("xsi", "http://www.w3.org/2001/XMLSchema-instance"),
    ("assuranceCase_", "http://omg.sacm/2.3/assurancecase"),
    ("argumentation_", "http://omg.sacm/2.3/argumentation"),
    ("artifact_", "http://omg.sacm/2.3/artifact"),
];

/// The identifier of the package of artifacts.
const ARTIFACTS: &str = "artifacts";

/// The assurance case as one file in XMI.
///
/// Artifacts carry the identifier of the evidence, the hash of all its inputs (`blake3`) and the file of its in-toto statement
/// (`statement`) as tagged values.
#[must_use]
pub fn sacm(case: &AssuranceCase) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    text.push_str("<assuranceCase_:AssuranceCasePackage xmi:version=\"2.0\"");
    for (prefix, namespace) in NAMESPACES {
        let _ = write!(text, " xmlns:{prefix}=\"{namespace}\"");
    }
    text.push_str(" xmi:id=\"case\" gid=\"case\">\n");
    let mut out = Writer {
        text,
        depth: 1,
        places: BTreeMap::new(),
    };
    out.name("Assurance case");
    out.description(&case.safety.brief);
    out.artifacts(case);
    let confidence = Package {
        id: "confidence",
        argument: &case.confidence,
        points: BTreeMap::new(),
    };
    let points = case.confidence.nodes.iter().filter_map(|node| {
        let point = node.argues.as_deref()?;
        Some((point, confidence.element(&node.id)))
    });
    let safety = Package {
        id: "safety",
        argument: &case.safety,
        points: points.collect(),
    };
    out.package(&safety);
    out.package(&confidence);
    out.text
        .push_str("</assuranceCase_:AssuranceCasePackage>\n");
    out.text
}

/// An argument that becomes a package.
struct Package<'a> {
    id: &'a str,
    argument: &'a Argument,
    /// The claims of the other argument by the claim points that they argue.
    points: BTreeMap<&'a str, String>,
}

impl Package<'_> {
    /// The identifier of an element in the file.
    fn element(&self, node: &str) -> String {
        format!("{}.{node}", self.id)
    }

    /// The claims about a relation, or about the element itself where both are the same.
    fn claims_about(&self, from: &Node, to: &str) -> Option<&str> {
        let point = from.claim_point.as_ref().filter(|it| it.at == to)?;
        self.points.get(point.name.as_str()).map(String::as_str)
    }
}

/// A relation between elements, by their identifiers in the argument.
struct Relation<'a> {
    kind: &'static str,
    sources: Vec<&'a str>,
    target: &'a str,
    reasoning: Option<&'a str>,
    /// The identifier of a claim about it.
    about: Option<&'a str>,
    is_counter: bool,
    needs_support: bool,
}

impl<'a> Relation<'a> {
    fn new(kind: &'static str, sources: Vec<&'a str>, target: &'a str) -> Self {
        Self {
            kind,
            sources,
            target,
            reasoning: None,
            about: None,
            is_counter: false,
            needs_support: false,
        }
    }
}

/// What supports an element as relations to `target`: claims by inference, references as evidence, strategies by what stands below
/// them.
fn support<'a>(
    package: &'a Package<'a>,
    node: &'a Node,
    target: &'a str,
    reasoning: Option<(&'a str, Option<&'a str>)>,
    into: &mut Vec<Relation<'a>>,
) {
    let (mut claims, mut references) = (Vec::new(), Vec::new());
    for id in &node.supported_by {
        let Some(below) = package.argument.node(id) else {
            continue;
        };
        match below.kind {
            Kind::Goal | Kind::CounterGoal | Kind::Context | Kind::Justification => {
                claims.push(below.id.as_str())
            }
            Kind::Solution | Kind::CounterSolution => references.push(below.id.as_str()),
            Kind::Strategy => {
                let about = package
                    .claims_about(node, &below.id)
                    .or(reasoning.and_then(|it| it.1));
                support(package, below, target, Some((&below.id, about)), into);
            }
        }
    }
    let is_open = node.kind == Kind::Strategy && node.supported_by.is_empty();
    let with = |kind, sources: Vec<&'a str>| Relation {
        reasoning: reasoning.map(|it| it.0),
        about: reasoning.and_then(|it| it.1),
        needs_support: is_open,
        ..Relation::new(kind, sources, target)
    };
    if !claims.is_empty() || is_open {
        into.push(with("AssertedInference", claims));
    }
    if !references.is_empty() {
        into.push(with("AssertedEvidence", references));
    }
}

/// All relations of an argument, in the order of its elements.
fn relations<'a>(package: &'a Package<'a>) -> Vec<Relation<'a>> {
    let mut relations = Vec::new();
    for node in &package.argument.nodes {
        // What supports a strategy supports the goal above it.
        if node.kind != Kind::Strategy {
            support(package, node, &node.id, None, &mut relations);
        }
        if let Some(target) = &node.challenges {
            relations.push(Relation {
                is_counter: true,
                ..Relation::new("AssertedInference", vec![&node.id], target)
            });
        }
        if !node.in_context_of.is_empty() {
            let contexts = node.in_context_of.iter().map(String::as_str).collect();
            relations.push(Relation::new("AssertedContext", contexts, &node.id));
        }
    }
    relations
}

/// XML that grows.
struct Writer {
    text: String,
    depth: usize,
    /// The identifiers of artifacts by those of the evidence.
    places: BTreeMap<String, String>,
}

impl Writer {
    fn line(&mut self, line: &str) {
        let _ = writeln!(self.text, "{:1$}{line}", "", 2 * self.depth);
    }

    fn open(&mut self, element: &str) {
        self.line(element);
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    fn name(&mut self, name: &str) {
        self.line(&format!(
            "<name lang=\"en\" content=\"{}\"/>",
            escaped(name)
        ));
    }

    /// A text in one language, where the metamodel allows several.
    fn words(&mut self, element: &str, words: &str) {
        self.open(&format!("<{element}>"));
        self.line(&format!(
            "<value lang=\"en\" content=\"{}\"/>",
            escaped(words)
        ));
        self.close(element);
    }

    fn description(&mut self, words: &str) {
        self.open("<description>");
        self.words("content", words);
        self.close("description");
    }

    fn tag(&mut self, key: &str, value: &str) {
        self.open("<taggedValue>");
        self.words("content", value);
        self.words("key", key);
        self.close("taggedValue");
    }

    /// An artifact for each piece of evidence that is cited.
    fn artifacts(&mut self, case: &AssuranceCase) {
        let nodes = case.safety.nodes.iter().chain(&case.confidence.nodes);
        let cited = nodes.filter_map(|node| node.citation.as_ref());
        let by_id: BTreeMap<&str, &str> = cited
            .map(|it| (it.evidence.as_str(), it.inputs.as_str()))
            .collect();
        self.open(&format!(
            "<artifactPackage xmi:id=\"{ARTIFACTS}\" gid=\"{ARTIFACTS}\">"
        ));
        self.name("Evidence");
        for (number, (evidence, inputs)) in by_id.iter().enumerate() {
            let gid = escaped(evidence);
            let id = artifact(number);
            self.open(&format!(
                "<artifactElement xsi:type=\"artifact_:Artifact\" xmi:id=\"{id}\" gid=\"{gid}\">"
            ));
            self.name(evidence);
            self.tag("blake3", inputs);
            self.tag("statement", &statement_file(evidence));
            self.close("artifactElement");
        }
        self.close("artifactPackage");
        self.places = by_id
            .keys()
            .enumerate()
            .map(|(number, it)| ((*it).to_owned(), artifact(number)))
            .collect();
    }

    fn package(&mut self, package: &Package<'_>) {
        let id = package.id;
        self.open(&format!("<argumentPackage xmi:id=\"{id}\" gid=\"{id}\">"));
        self.name(&package.argument.name);
        self.description(&package.argument.brief);
        for node in &package.argument.nodes {
            self.node(package, node);
        }
        for (number, relation) in relations(package).iter().enumerate() {
            self.relation(package, number + 1, relation);
        }
        self.close("argumentPackage");
    }

    fn node(&mut self, package: &Package<'_>, node: &Node) {
        let id = package.element(&node.id);
        let mut more = String::new();
        let kind = match node.kind {
            Kind::Strategy => "ArgumentReasoning",
            Kind::Solution | Kind::CounterSolution => {
                let place = node
                    .citation
                    .as_ref()
                    .and_then(|it| self.places.get(&it.evidence));
                if let Some(place) = place {
                    let _ = write!(more, " referencedArtifactElement=\"{place}\"");
                }
                "ArtifactReference"
            }
            _ => {
                let declared = declaration(node);
                let _ = write!(more, " assertionDeclaration=\"{declared}\"");
                if let Some(about) = package.claims_about(node, &node.id) {
                    let _ = write!(more, " metaClaim=\"{about}\"");
                }
                "Claim"
            }
        };
        let gid = escaped(&node.id);
        self.open(&format!("<argumentationElement xsi:type=\"argumentation_:{kind}\" xmi:id=\"{id}\" gid=\"{gid}\"{more}>"));
        self.name(&node.id);
        self.description(&node.text);
        self.close("argumentationElement");
    }

    fn relation(&mut self, package: &Package<'_>, number: usize, relation: &Relation<'_>) {
        let own = format!("R-{number}");
        let id = package.element(&own);
        let sources: Vec<String> = relation
            .sources
            .iter()
            .map(|it| package.element(it))
            .collect();
        let mut more = String::new();
        if relation.needs_support {
            more.push_str(" assertionDeclaration=\"needsSupport\"");
        }
        if let Some(about) = relation.about {
            let _ = write!(more, " metaClaim=\"{about}\"");
        }
        if relation.is_counter {
            more.push_str(" isCounter=\"true\"");
        }
        if !sources.is_empty() {
            let _ = write!(more, " source=\"{}\"", sources.join(" "));
        }
        let _ = write!(more, " target=\"{}\"", package.element(relation.target));
        if let Some(reasoning) = relation.reasoning {
            let _ = write!(more, " reasoning=\"{}\"", package.element(reasoning));
        }
        let kind = relation.kind;
        self.open(&format!("<argumentationElement xsi:type=\"argumentation_:{kind}\" xmi:id=\"{id}\" gid=\"{own}\"{more}>"));
        self.name(&own);
        self.close("argumentationElement");
    }
}

fn artifact(number: usize) -> String {
    format!("{ARTIFACTS}.{}", number + 1)
}

/// How a claim is declared.
fn declaration(node: &Node) -> &'static str {
    match node.kind {
        _ if node.defeated => "defeated",
        _ if node.undeveloped => "needsSupport",
        Kind::Justification => "axiomatic",
        _ => "asserted",
    }
}

/// A text as the value of an attribute.
fn escaped(text: &str) -> String {
    let mut value = String::new();
    for letter in text.chars() {
        match letter {
            '&' => value.push_str("&amp;"),
            '<' => value.push_str("&lt;"),
            '>' => value.push_str("&gt;"),
            '"' => value.push_str("&quot;"),
            '\n' | '\t' | '\r' => {
                let _ = write!(value, "&#{};", u32::from(letter));
            }
            '\u{fffe}' | '\u{ffff}' => value.push('\u{fffd}'),
            letter if letter < ' ' => value.push('\u{fffd}'),
            letter => value.push(letter),
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::super::node::{Builder, Citation};
    use super::*;

    fn case() -> AssuranceCase {
        let mut safety = Builder::new();
        let top = safety.add(Kind::Goal, "top", "All \"hold\" & <more>\u{1}\nhere");
        safety.context(top, Kind::Context, "level", "95 %");
        let strategy = safety.support(top, Kind::Strategy, "by", "Over each");
        safety.claim_point(top, strategy, "ACP-1".into());
        let solution = safety.support(strategy, Kind::Solution, "E1", "E1");
        safety.cite(
            solution,
            Citation {
                evidence: "E1".into(),
                inputs: "00".into(),
            },
        );
        safety.support(strategy, Kind::Goal, "open", "Not yet");
        safety.support(top, Kind::Strategy, "none", "Nothing below");
        safety.challenge(top, "no", "It fails", true);
        let mut confidence = Builder::new();
        let relied = confidence.add(Kind::Goal, "relied", "It can be relied on");
        confidence.argue(relied, "ACP-1".into());
        AssuranceCase {
            safety: safety.finish("Safety", "Brief".into()),
            confidence: confidence.finish("Confidence", "Brief".into()),
        }
    }

    #[test]
    fn strategies_are_the_reasoning_of_relations() {
        let text = sacm(&case());
        let has = |wanted: &str| assert!(text.contains(wanted), "no {wanted} in {text}");
        has(
            "AssertedEvidence\" xmi:id=\"safety.R-2\" gid=\"R-2\" metaClaim=\"confidence.G-relied\" source=\"safety.Sn-E1\" target=\"safety.G-top\" reasoning=\"safety.S-by\"",
        );
        has(
            "gid=\"R-1\" metaClaim=\"confidence.G-relied\" source=\"safety.G-open\" target=\"safety.G-top\" reasoning=\"safety.S-by\"",
        );
        has(
            "gid=\"R-3\" assertionDeclaration=\"needsSupport\" target=\"safety.G-top\" reasoning=\"safety.S-none\"",
        );
        has("isCounter=\"true\" source=\"safety.CG-no\" target=\"safety.G-top\"");
        has(
            "AssertedContext\" xmi:id=\"safety.R-4\" gid=\"R-4\" source=\"safety.C-level\" target=\"safety.G-top\"",
        );
        has("referencedArtifactElement=\"artifacts.1\"");
        has("gid=\"G-top\" assertionDeclaration=\"defeated\"");
        has("gid=\"G-open\" assertionDeclaration=\"needsSupport\"");
        has("content=\"All &quot;hold&quot; &amp; &lt;more&gt;\u{fffd}&#10;here\"");
    }
}
