//! False conflicts over whole studies: a small version of the example's table.

#[path = "../../examples/false_conflicts.rs"]
mod study;

use study::{Uniform, study};

/// At most 5 % of studies have a false conflict, whatever the number of requirements; held to four standard deviations.
/// Conflicts that are there are found in most studies all the same.
#[test]
fn false_conflicts_are_rare_over_the_study_as_a_whole() {
    for (count, studies, faults) in [(1, 200, false), (5, 40, false), (5, 40, true)] {
        let mut uniform = Uniform(7);
        let found: Vec<_> = (0..studies)
            .map(|_| study(&mut uniform, count, faults))
            .collect();
        let share = |wrong: usize| wrong as f64 / f64::from(studies);
        let most = 0.05 + 4.0 * (0.05_f64 * 0.95 / f64::from(studies)).sqrt();
        let conflicts = found.iter().filter(|it| it.conflict[0]).count();
        assert!(share(conflicts) <= most, "{count}: {conflicts}");
        let power = found.iter().filter(|it| it.power).count();
        assert!(share(power) >= f64::from(u8::from(faults)) * 0.7, "{power}");
    }
}
