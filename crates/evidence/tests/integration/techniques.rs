//! Whether the list of all techniques has all of them.

use evidence::Technique;
use std::collections::BTreeSet;

#[test]
fn the_list_of_all_techniques_has_every_one_that_can_be_written() {
    let schema = schemars::schema_for!(Technique);
    let schema = serde_json::to_value(schema).expect("JSON");
    let words = schema["oneOf"].as_array().expect("one for each variant");
    let words: BTreeSet<&str> = words.iter().filter_map(|it| it["const"].as_str()).collect();
    let listed = Technique::ALL.iter().map(|it| it.traits().key);
    assert_eq!(listed.collect::<BTreeSet<_>>(), words);
}
