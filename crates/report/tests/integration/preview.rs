//! Writes the fixture's report to `target/report-preview.html`, to be looked
//! at, and holds it to its size.

use crate::fixture;

#[test]
fn the_preview_is_written_and_small() {
    let page = report::html(&fixture::study());
    let target = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    std::fs::create_dir_all(&target).expect("target folder");
    std::fs::write(target.join("report-preview.html"), &page).expect("preview");
    println!("{}", report::text(&fixture::study(), 100, false));
    println!("{}", report::text(&fixture::study(), 60, true));
    assert!(page.len() < 520_000, "{} bytes", page.len());
}
