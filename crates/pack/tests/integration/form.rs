//! The form of a pack, and what is refused.

use crate::made::{about, archive, key, parts};
use pack::{About, Content, Part, Role, Signature, check, write};

#[test]
fn the_same_parts_in_any_order_give_the_same_bytes() {
    let mut turned = Vec::new();
    write(
        parts().into_iter().rev().collect(),
        about(),
        Some(&key()),
        &mut turned,
    )
    .expect("written");
    assert!(turned == archive(Some(&key())));
}

#[test]
fn a_pack_is_as_it_was_written_and_its_signature_says_by_whom() {
    let signed = archive(Some(&key()));
    let found = check(&mut signed.as_slice(), Some(&key().public()));
    assert_eq!(found.faults, []);
    let id = key().public().id();
    assert_eq!(found.signature, Signature::Valid { key: id.clone() });
    assert_eq!((found.parts, found.bytes), (8, signed.len() as u64));
    let manifest = found.manifest.expect("a manifest");
    let names: Vec<&str> = manifest.subject.iter().map(|it| it.name.as_str()).collect();
    let expected = [
        "SHA256SUMS",
        "VERIFY.md",
        "empty",
        "results/study.json",
        "study/%2E%2E/a b.prism",
        "study/table.csv",
    ];
    assert_eq!(names, expected);
    assert_eq!(manifest.predicate.not_shown, about().not_shown);
    // Without a key nothing is known of the signature, and without a signature nothing of who made it.
    let found = check(&mut signed.as_slice(), None);
    assert_eq!(
        (found.faults.len(), found.signature),
        (0, Signature::NotVerified { key: id })
    );
    let unsigned = archive(None);
    let found = check(&mut unsigned.as_slice(), None);
    assert_eq!(
        (found.faults.len(), found.signature),
        (0, Signature::Absent)
    );
    let found = check(&mut unsigned.as_slice(), Some(&key().public()));
    assert_eq!(
        (found.faults.len(), found.signature),
        (1, Signature::Invalid)
    );
    let other = pack::Key::of_seed([3; 32]).public();
    let found = check(&mut signed.as_slice(), Some(&other));
    assert_eq!(
        (found.faults.len(), found.signature),
        (1, Signature::Invalid)
    );
    assert!(
        found.faults[0].what.contains(&other.id()),
        "{:?}",
        found.faults
    );
}

#[test]
fn what_cannot_be_packed_is_refused() {
    let twice = |a: &str, b: &str| {
        let part = |name: &str| Part::new(name, Role::Study, "", Content::text(""));
        let written = write(
            vec![part(a), part(b)],
            About::new("x"),
            None,
            &mut Vec::new(),
        );
        written.map(|_| ()).map_err(|problem| problem.code)
    };
    assert_eq!(twice("a.csv", "A.csv"), Err("same-part"));
    assert_eq!(twice("manifest.json", "b"), Err("same-part"));
    assert_eq!(twice("verify.MD", "b"), Err("same-part"));
    assert_eq!(twice("a.csv", "b.csv"), Ok(()));
    let first = std::cell::Cell::new(true);
    let open = move || {
        let text: &'static [u8] = if first.replace(false) { b"one" } else { b"two" };
        Ok(Box::new(text) as Box<dyn std::io::Read>)
    };
    let changing = Content::streamed(Box::new(open)).expect("read once");
    let part = Part::new("a", Role::Recording, "", changing);
    let problem =
        write(vec![part], About::new("x"), None, &mut Vec::new()).expect_err("it was changed");
    assert_eq!(problem.code, "changed-while-packed");
}

/// A disk that is full after some bytes.
struct Full(usize);

impl std::io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self
            .0
            .checked_sub(bytes.len())
            .ok_or(std::io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_an_error_wherever_it_comes() {
    let size = archive(Some(&key())).len();
    for room in (0..size).step_by(97).chain([size - 1]) {
        let problem = write(parts(), about(), Some(&key()), &mut Full(room)).expect_err("no room");
        assert_eq!(problem.code, "cannot-write", "{room}");
    }
    assert!(write(parts(), about(), Some(&key()), &mut Full(size)).is_ok());
}
