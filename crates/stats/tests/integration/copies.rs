//! A small version of the simulation of copies: how often independent studies are asked about, and which copies are found.

#[path = "../../examples/copies.rs"]
#[allow(dead_code, reason = "the example's own beginning")]
mod example;

#[test]
fn independent_studies_are_seldom_asked_about_and_copies_are_found() {
    let studies = 300;
    let table = example::table(studies);
    let of = |name: &str| {
        let row = table.iter().find(|row| row.name == name);
        row.unwrap_or_else(|| panic!("no row {name}")).asked
    };
    for row in table.iter().filter(|row| !row.copied) {
        // Three standard errors above 1 %; always as many trials is what the assumption excludes.
        let allowed = if row.name.starts_with("the same, always") {
            0.15
        } else {
            0.028
        };
        assert!(row.asked <= allowed, "{} {}", row.name, row.asked);
    }
    assert!(of("copied totals of 6 modes in 200 trials") > 0.9);
    assert!(of("renamed rows, 20 x 10") > 0.8);
    // Three standard errors below the 52 % of 2000 studies.
    assert!(of("3 copied rates, 4 decimals") > 0.43);
    // Too little to tell: no alarm rather than a guess.
    assert!(of("renamed rows, 5 x 10") < 0.05);
}
