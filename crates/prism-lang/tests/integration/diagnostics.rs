//! Every mistake has a place, a message and a remedy: the catalogue in `diagnostics.md`, checked line by line.

use prism_lang::resolved::Model;
use prism_lang::{
    Constants, Diagnostic, Diagnostics, parse_model, parse_properties, resolve, resolve_properties,
    resolve_with,
};

const CATALOGUE: &str = include_str!("../diagnostics.md");
const MODEL_OF_PROPERTIES: &str = "dtmc module m x : [0..3]; b : bool; [a] x<3 -> (x'=x+1); endmodule \
    label \"done\" = x=3; const int n = 2; rewards \"cost\" [a] true : 1; endrewards";

fn lines(text: &str, diagnostics: &[Diagnostic]) -> Vec<String> {
    let mut lines = Vec::new();
    for d in diagnostics {
        let remedy = d.remedy.as_deref().expect("every diagnostic has a remedy");
        lines.push(format!(
            "[{}] at `{}`: {} | {remedy}",
            d.code,
            d.span.of(text),
            d.message
        ));
        for (span, note) in &d.related {
            lines.push(format!("`{}`: {note}", span.of(text)));
        }
    }
    if lines.is_empty() {
        lines.push("nothing".to_owned());
    }
    lines
}

fn about_model(text: &str) -> Vec<String> {
    let parsed = parse_model(text);
    if parsed.has_errors() {
        return lines(text, &parsed.diagnostics);
    }
    match resolve(&parsed.tree, &Constants::new()) {
        Ok(model) => lines(text, &model.warnings),
        Err(diagnostics) => lines(text, &diagnostics),
    }
}

fn about_property(text: &str, model: &Model) -> Vec<String> {
    let parsed = parse_properties(text);
    if parsed.has_errors() {
        return lines(text, &parsed.diagnostics);
    }
    match resolve_properties(&parsed.tree, model, &Constants::new()) {
        Ok(_) => lines(text, &[]),
        Err(diagnostics) => lines(text, &diagnostics),
    }
}

#[test]
fn the_catalogue_of_mistakes_is_true() {
    let of_type = |keyword: &str| {
        let text = MODEL_OF_PROPERTIES.replacen("dtmc", keyword, 1);
        resolve(&parse_model(&text).tree, &Constants::new()).unwrap()
    };
    let (dtmc, mdp, ctmc) = (of_type("dtmc"), of_type("mdp"), of_type("ctmc"));
    let mut checked = 0;
    let mut catalogue = CATALOGUE.lines().peekable();
    while let Some(line) = catalogue.next() {
        let found = if let Some(text) = line.strip_prefix("model ") {
            about_model(text)
        } else if let Some(text) = line.strip_prefix("property ") {
            about_property(text, &dtmc)
        } else if let Some(text) = line.strip_prefix("in-mdp ") {
            about_property(text, &mdp)
        } else if let Some(text) = line.strip_prefix("in-ctmc ") {
            about_property(text, &ctmc)
        } else {
            continue;
        };
        let mut expected = Vec::new();
        while let Some(said) = catalogue.next_if(|l| l.starts_with("    ")) {
            expected.push(said.trim().to_owned());
        }
        assert_eq!(found, expected, "about: {line}");
        checked += 1;
    }
    assert!(
        checked > 80,
        "only {checked} texts were read from the catalogue"
    );
}

fn codes<T>(result: Result<T, Diagnostics>) -> Vec<&'static str> {
    match result {
        Ok(_) => Vec::new(),
        Err(diagnostics) => diagnostics.iter().map(|d| d.code).collect(),
    }
}

#[test]
fn values_from_outside_are_checked() {
    let model = parse_model(
        "dtmc const int n; const double p = 0.5; const bool b; module m x : [0..n]; endmodule",
    )
    .tree;
    let given = |text| Constants::parse(text).unwrap();
    assert!(codes(resolve(&model, &given("n=3,b=true"))).is_empty());
    assert_eq!(
        codes(resolve(&model, &given("n=3"))),
        ["undefined-constant"]
    );
    assert_eq!(codes(resolve(&model, &given("n=1.5,b=true"))), ["type"]);
    assert_eq!(codes(resolve(&model, &given("n=3,b=1"))), ["type"]);
    assert_eq!(
        codes(resolve(&model, &given("n=3,b=true,p=0.1"))),
        ["constant-given-twice"]
    );
    let with = |overrides| {
        codes(resolve_with(
            &model,
            &given("n=3,b=true"),
            &given(overrides),
        ))
    };
    assert!(with("p=0.1").is_empty());
    assert_eq!(with("q=0.1"), ["unknown-constant"]);
    let model = resolve(&model, &given("n=3,b=true")).unwrap();
    let properties = parse_properties("const int k; P=? [ F<=k x=n ]").tree;
    assert!(codes(resolve_properties(&properties, &model, &given("k=2,n=3"))).is_empty());
    assert_eq!(
        codes(resolve_properties(&properties, &model, &given("k=2,kk=3"))),
        ["unknown-constant"]
    );
    assert_eq!(
        codes(resolve_properties(&properties, &model, &given("n=3"))),
        ["undefined-constant"]
    );
}

#[test]
fn formulas_that_explode_are_refused() {
    let mut text = "dtmc formula f0 = x=1; ".to_owned();
    for i in 0..60 {
        text += &format!("formula f{} = f{i} & f{i} | f{i};", i + 1);
    }
    text += "module m x : [0..1]; [] f60 -> true; endmodule";
    assert!(codes(resolve(&parse_model(&text).tree, &Constants::new())).contains(&"too-large"));
    let mut text = "dtmc formula f0 = x; ".to_owned();
    for i in 0..2000 {
        text += &format!("formula f{} = f{i}+1;", i + 1);
    }
    text += "module m x : [0..1]; [] f2000=1 -> true; endmodule";
    assert!(codes(resolve(&parse_model(&text).tree, &Constants::new())).contains(&"too-large"));
}
