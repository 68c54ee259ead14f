//! What the designs promise.

use super::*;

fn space(text: &str) -> Space {
    Space::from_toml(text).unwrap()
}

fn cube(dimensions: usize) -> Space {
    let parameter =
        |i| format!("[[parameter]]\nname = \"x{i}\"\nsets = [\"x{i}\"]\nuniform = [0, 1]\n");
    space(&(0..dimensions).map(parameter).collect::<String>())
}

fn rows(design: Design, dimensions: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut sampler = Sampler::new(cube(dimensions), design, seed);
    sampler
        .ask(count)
        .unwrap()
        .into_iter()
        .map(|p| p.0)
        .collect()
}

const ALL: [Design; 4] = [
    Design::Random,
    Design::LatinHypercube,
    Design::LowDiscrepancy,
    Design::Boundary,
];

#[test]
fn discrepancy_is_that_of_the_literature() {
    // scipy 1.17: scipy.stats.qmc.discrepancy([[1,3],[2,6],[3,2],[4,5],[5,1],[6,4]]) after scaling
    // to (k - 1/2)/6 is the CD^2 of K.-T. Fang, R. Li and A. Sudjianto (2006), table 3.
    let points = [[1, 3], [2, 6], [3, 2], [4, 5], [5, 1], [6, 4]];
    let rows: Vec<Vec<f64>> = points
        .iter()
        .map(|row| row.iter().map(|k| (f64::from(*k) - 0.5) / 6.0).collect())
        .collect();
    let square = centred_discrepancy(&rows).unwrap().powi(2);
    assert!(
        (square - 0.008_142_039_609_053_464).abs() < 1e-12,
        "{square}"
    );
    assert_eq!(centred_discrepancy(&[]), None);
    assert_eq!(centred_discrepancy(&[vec![0.1], vec![0.1, 0.2]]), None);
}

#[test]
fn low_discrepancy_is_lower_than_chance() {
    for dimensions in [2, 6] {
        for seed in 0..5 {
            let of = |design| centred_discrepancy(&rows(design, dimensions, 256, seed)).unwrap();
            let (even, latin, chance) = (
                of(Design::LowDiscrepancy),
                of(Design::LatinHypercube),
                of(Design::Random),
            );
            assert!(
                even < 0.5 * chance && latin < chance,
                "{even} {latin} {chance}"
            );
        }
    }
}

#[test]
fn a_latin_hypercube_has_one_point_in_each_slice() {
    let rows = rows(Design::LatinHypercube, 3, 40, 5);
    for coordinate in 0..3 {
        let mut slices: Vec<usize> = rows
            .iter()
            .map(|r| (r[coordinate] * 40.0) as usize)
            .collect();
        slices.sort_unstable();
        assert_eq!(slices, (0..40).collect::<Vec<_>>());
    }
}

#[test]
fn portions_do_not_matter_where_points_are_a_sequence() {
    for design in [Design::Random, Design::LowDiscrepancy, Design::Boundary] {
        let mut parts = Sampler::new(cube(3), design, 9);
        let mut points = parts.ask(3).unwrap();
        points.extend(parts.ask(4).unwrap());
        assert_eq!(points, Sampler::new(cube(3), design, 9).ask(7).unwrap());
    }
}

#[test]
fn boundaries_are_visited() {
    let rows = rows(Design::Boundary, 3, 400, 1);
    let at_limit = |x: &f64| *x == 0.0 || *x == 1.0;
    let corners = rows.iter().filter(|row| row.iter().all(at_limit)).count();
    let inside = rows.iter().filter(|row| !row.iter().any(at_limit)).count();
    // Expected 400 (1/5 + 4/5 (1/4)^3) = 85 and 400 4/5 (3/4)^3 = 135; five deviations are 50.
    assert!(
        (35..135).contains(&corners) && (85..185).contains(&inside),
        "{corners} {inside}"
    );
    let mixed = space(
        "[[parameter]]\nname = \"n\"\nsets = [\"n\"]\nnormal = [0, 1]\n\
         [[parameter]]\nname = \"c\"\nsets = [\"c\"]\nchoice = [1, 2, 3]\nweights = [1000, 1, 0]",
    );
    let points = Sampler::new(mixed, Design::Boundary, 1).ask(200).unwrap();
    let rare = points.iter().filter(|p| p.0[1] == 2.0).count();
    assert!((60..140).contains(&rare) && points.iter().all(|p| p.0[1] != 3.0));
    assert!(points.iter().all(|p| p.0[0].abs() < 3.1));
    assert!(points.iter().any(|p| p.0[0] > 3.0) && points.iter().any(|p| p.0[0] < -3.0));
}

#[test]
fn constraints_hold_and_impossible_ones_are_said() {
    let text = "[[parameter]]\nname = \"x\"\nsets = [\"x\"]\nuniform = [0, 1]\n\
                [[parameter]]\nname = \"y\"\nsets = [\"y\"]\nuniform = [0, 1]\n\
                [[constraint]]\nsum = { x = 1, y = 1 }\n";
    for design in ALL {
        let mut sampler = Sampler::new(space(&format!("{text}at_most = 0.5")), design, 1);
        let points = sampler.ask(100).unwrap();
        assert!(points.len() == 100 && points.iter().all(|p| p.0[0] + p.0[1] <= 0.5));
        assert!(sampler.allowed_share().unwrap() < 0.7);
        let mut never = Sampler::new(space(&format!("{text}at_least = 3.0")), design, 1);
        assert_eq!(never.ask(1), Err(CampaignError::TooTight { tried: 10_000 }));
        let mut positive = Sampler::new(cube(1), design, 1);
        let points = positive.ask_where(20, &|p| p.0[0] > 0.9).unwrap();
        assert!(points.iter().all(|p| p.0[0] > 0.9));
    }
}

#[test]
fn no_parameter_and_no_point_are_no_problem() {
    for design in ALL {
        let mut sampler = Sampler::new(Space::default(), design, 1);
        assert_eq!(sampler.ask(2).unwrap(), [Point(vec![]), Point(vec![])]);
        assert!(Sampler::new(cube(2), design, 1).ask(0).unwrap().is_empty());
    }
}
