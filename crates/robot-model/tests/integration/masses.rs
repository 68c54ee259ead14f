//! What of masses and inertias is simulated, and which links cannot be.

use crate::common::{close, loaded};
use robot_model::{Inertial, Unphysical};

fn inertial(mass_kg: f64, tensor_kg_m2: [f64; 6]) -> Inertial {
    Inertial {
        mass_kg,
        centre_m: [0.1, 0.2, 0.3],
        tensor_kg_m2,
    }
}

#[test]
fn what_weighs_nothing_is_nothing_and_a_point_is_as_it_is() {
    assert_eq!(inertial(0.0, [0.0; 6]).simulated(), (None, None));
    let point = inertial(2.0, [0.0; 6]);
    assert_eq!(point.simulated(), (Some(point), None));
    let sound = inertial(2.0, [1.0, 1.0, 2.0, 0.0, 0.0, 0.0]);
    assert_eq!(sound.simulated(), (Some(sound), None));
}

#[test]
fn what_no_body_has_becomes_what_an_engine_takes() {
    let cases = [
        ([1.0, 1.0, 5.0, 0.0, 0.0, 0.0], Unphysical::Impossible),
        ([1.0, 1.0, 1.0, 3.0, 0.0, 0.0], Unphysical::Impossible),
        ([1.0, 1.0, 2.00001, 0.0, 0.0, 0.0], Unphysical::Rounded),
        ([1.0, 1.0, 0.0, 0.0, 0.0, 0.0], Unphysical::Thin),
    ];
    for (tensor, why) in cases {
        let given = inertial(2.0, tensor);
        let (simulated, found) = given.simulated();
        let simulated = simulated.expect("it weighs something");
        let [low, middle, high] = simulated.principal_moments_kg_m2();
        assert_eq!(found, Some(why));
        assert!(
            low > 0.0 && low + middle >= high,
            "{tensor:?}: {simulated:?}"
        );
        assert_eq!(
            (simulated.mass_kg, simulated.centre_m),
            (2.0, given.centre_m)
        );
    }
    // The mean of the moments keeps their sum.
    let (mean, _) = inertial(2.0, cases[0].0).simulated();
    let expected = [7.0 / 3.0, 7.0 / 3.0, 7.0 / 3.0, 0.0, 0.0, 0.0];
    assert!(close(&mean.expect("some").tensor_kg_m2, &expected));
}

#[test]
fn a_link_may_be_borne_by_what_is_fixed_to_it_but_not_by_what_moves_against_it() {
    let text = |kind: &str| {
        format!(
            r#"<robot name="r"><link name="world"/><link name="frame"/>
  <link name="tool"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="turns" type="continuous"><parent link="world"/><child link="frame"/></joint>
  <joint name="holds" type="{kind}"><parent link="frame"/><child link="tool"/></joint></robot>"#
        )
    };
    assert!(loaded("r.urdf", &text("fixed")).refusals(true).is_empty());
    assert_eq!(
        loaded("r.urdf", &text("continuous")).refusals(true).len(),
        1
    );
}

#[test]
fn bounds_balance_and_total_mass_of_mjcf_are_computed() {
    let text = |compiler: &str| {
        format!(
            r#"<mujoco><compiler {compiler}/><worldbody>
  <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 4"/></body>
  <body><inertial pos="0 0 0" mass="3" diaginertia="6 6 6"/></body></worldbody></mujoco>"#
        )
    };
    let moments = |compiler: &str| {
        let loaded = loaded("r.xml", &text(compiler));
        let links = loaded.model.links.iter().filter_map(|link| link.inertial);
        links
            .map(|it| (it.mass_kg, it.tensor_kg_m2))
            .collect::<Vec<_>>()
    };
    let bounded = moments(r#"boundmass="2" boundinertia="5""#);
    assert_eq!(bounded[0], (2.0, [5.0, 5.0, 5.0, 0.0, 0.0, 0.0]));
    assert_eq!(bounded[1].0, 3.0);
    assert!(close(
        &moments(r#"balanceinertia="true""#)[0].1,
        &[2.0, 2.0, 2.0, 0.0, 0.0, 0.0]
    ));
    let scaled = moments(r#"settotalmass="8""#);
    assert_eq!((scaled[0].0, scaled[1].0), (2.0, 6.0));
    assert_eq!(scaled[1].1, [12.0, 12.0, 12.0, 0.0, 0.0, 0.0]);
}
