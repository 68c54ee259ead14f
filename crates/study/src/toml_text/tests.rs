use super::*;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only read")]
struct File {
    title: String,
    #[serde(default)]
    entry: Vec<Entry>,
}

#[derive(Debug, Deserialize)]
#[expect(dead_code, reason = "only read")]
struct Entry {
    id: String,
    colour: Colour,
    count: u64,
    range: [f64; 2],
    #[serde(flatten)]
    kind: Kind,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Colour {
    Red,
    Green,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[expect(dead_code, reason = "only read")]
enum Kind {
    Laser { rays: u32 },
}

fn shown(text: &str) -> String {
    let source = Source {
        name: "f.toml".into(),
        text: text.into(),
    };
    read::<File>("bad-study-file", &source)
        .expect_err("mistakes")
        .to_string()
}

#[test]
fn missing_fields_are_told_at_once_each_in_its_table() {
    let said = shown(
        "[[entry]]\nkind = \"laser\"\nrays = 3\n\n[[entry]]\nid = \"b\"\nrange = [0.0, 1.0]\nkind = \"laser\"\nrays = 3\n",
    );
    for field in ["title", "id", "colour", "count", "range"] {
        assert!(
            said.contains(&format!("missing field `{field}`")),
            "{field}:\n{said}"
        );
    }
    for place in ["f.toml:1:", "f.toml:5:"] {
        assert!(said.contains(place), "{place}:\n{said}");
    }
}

#[test]
fn an_unknown_field_of_a_tagged_table_is_shown_at_itself() {
    let said = shown(
        "title = \"t\"\n[[entry]]\nid = \"a\"\ncolour = \"red\"\ncount = 1\nrange = [0.0, 1.0]\nkind = \"laser\"\nrays = 3\nrayz = 4\n",
    );
    assert!(said.contains("unknown field `rayz`"), "{said}");
    assert!(said.contains("f.toml:9:1"), "{said}");
}
