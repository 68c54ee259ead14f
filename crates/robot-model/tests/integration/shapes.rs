//! Poses, inertias and meshes against closed forms and against each other.

use crate::common;

use common::close;
use proptest::prelude::*;
use robot_model::{Geometry, Inertial, Mesh, Pose, parse, pose};

fn direction() -> impl Strategy<Value = [f64; 3]> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_filter_map("a direction", |v: [f64; 3]| {
        if pose::length(v) > 0.1 {
            pose::direction(v)
        } else {
            None
        }
    })
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (
        [-2.0..2.0, -2.0..2.0, -2.0..2.0_f64],
        direction(),
        -3.0..3.0_f64,
    )
        .prop_map(|(position_m, axis, angle)| Pose {
            position_m,
            rotation: pose::about(axis, angle),
        })
}

/// A box of triangles with the given half extents, as text STL.
fn stl_box([a, b, c]: [f64; 3]) -> String {
    let corner = |index: usize| {
        let sign = |bit: usize| if index & bit == 0 { -1.0 } else { 1.0 };
        format!("vertex {} {} {}\n", a * sign(1), b * sign(2), c * sign(4))
    };
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let facets = faces.map(|face: [usize; 3]| {
        format!(
            "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            face.map(corner).concat()
        )
    });
    format!("solid box\n{}endsolid box\n", facets.concat())
}

/// The mesh of a file's bytes, scaled.
fn mesh(name: &str, bytes: &[u8], scale: &str) -> Mesh {
    let text = format!(
        "<robot name='r'><link name='a'><collision><geometry><mesh filename='{name}' scale='{scale}'/></geometry></collision></link></robot>"
    );
    let loaded = parse("r.urdf", &text, &mut |_: &str| Ok(bytes.to_vec())).expect("a mesh");
    loaded.model.meshes[0].clone()
}

#[test]
fn a_mesh_of_a_box_weighs_what_the_box_weighs() {
    let half = [0.3, 0.2, 0.1];
    let text = stl_box(half);
    let solid = Geometry::Box {
        half_extents_m: half,
    };
    for scale in ["1 1 1", "-1 1 1"] {
        let mesh = mesh("box.stl", text.as_bytes(), scale);
        assert_eq!((mesh.vertices_m.len(), mesh.triangles.len()), (8, 12));
        assert!(mesh.is_solid());
        let found = mesh.solid();
        let expected = solid.inertial(solid.volume_m3(&[]), &[]).expect("a volume");
        assert!(
            (found.mass_kg - expected.mass_kg).abs() < 1e-15,
            "{found:?}"
        );
        assert!(
            close(&found.tensor_kg_m2, &expected.tensor_kg_m2),
            "{found:?}"
        );
    }
}

#[test]
fn binary_and_text_stl_and_obj_are_one_mesh() {
    let text = stl_box([0.5, 0.25, 0.125]);
    let from_text = mesh("box.stl", text.as_bytes(), "1 1 1");
    let mut binary = vec![b's'; 80];
    binary.extend(12_u32.to_le_bytes());
    for triangle in &from_text.triangles {
        binary.extend([0; 12]);
        for corner in triangle {
            for x in from_text.vertices_m[*corner as usize] {
                binary.extend((x as f32).to_le_bytes());
            }
        }
        binary.extend([0; 2]);
    }
    let from_binary = mesh("box.STL", &binary, "1 1 1");
    assert_eq!(from_binary.vertices_m, from_text.vertices_m);
    assert_eq!(from_binary.triangles, from_text.triangles);
    let mut obj = String::new();
    for [x, y, z] in &from_text.vertices_m {
        obj += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in &from_text.triangles {
        obj += &format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1);
    }
    let from_obj = mesh("box.obj", obj.as_bytes(), "1 1 1");
    assert_eq!(from_obj.vertices_m, from_text.vertices_m);
    assert_eq!(from_obj.triangles, from_text.triangles);
}

/// The text of a prism over a polygon (counter-clockwise, cut into triangles by hand) of height 1, as OBJ.
fn prism(corners: &[[f64; 2]], cut: &[[usize; 3]]) -> String {
    let count = corners.len();
    let mut text = String::new();
    for z in [0.0, 1.0] {
        for [x, y] in corners {
            text.push_str(&format!("v {x} {y} {z}\n"));
        }
    }
    for [a, b, c] in cut {
        text.push_str(&format!("f {} {} {}\n", a + 1, c + 1, b + 1));
        text.push_str(&format!(
            "f {} {} {}\n",
            a + 1 + count,
            b + 1 + count,
            c + 1 + count
        ));
    }
    for a in 0..count {
        let b = (a + 1) % count;
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, b + 1 + count));
        text.push_str(&format!(
            "f {} {} {}\n",
            a + 1,
            b + 1 + count,
            a + 1 + count
        ));
    }
    text
}

#[test]
fn a_concave_mesh_is_a_gap_and_a_convex_one_is_none() {
    let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let square = prism(&square, &[[0, 1, 2], [0, 2, 3]]);
    // An L: the square without its upper right quarter.
    let angle = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let angle = prism(&angle, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    let urdf = |part: &str| {
        format!(
            "<robot name='r'><link name='a'><{part}><geometry><mesh filename='m.obj'/></geometry></{part}></link></robot>"
        )
    };
    let sdf = "<sdf version='1.9'><model name='m'><link name='a'><collision name='c'><geometry><mesh><uri>m.obj</uri></mesh></geometry></collision></link></model></sdf>";
    let mjcf = "<mujoco><asset><mesh name='m' file='m.obj'/></asset><worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>";
    for (file, text, mesh, expected) in [
        ("r.urdf", urdf("collision"), &square, 0),
        ("r.urdf", urdf("collision"), &angle, 1),
        ("r.urdf", urdf("visual"), &angle, 0),
        ("r.sdf", sdf.to_owned(), &angle, 1),
        // MuJoCo means the hull.
        ("r.xml", mjcf.to_owned(), &angle, 0),
    ] {
        let loaded = robot_model::parse(file, &text, &mut |_: &str| Ok(mesh.clone().into_bytes()));
        let gaps = loaded.unwrap_or_else(|problems| panic!("{problems}")).gaps;
        let hollow: Vec<String> = gaps.iter().map(ToString::to_string).collect();
        let hollow: Vec<&String> = hollow
            .iter()
            .filter(|gap| gap.contains("convex hull"))
            .collect();
        assert_eq!(hollow.len(), expected, "{file}: {gaps:?}");
        // From the face of one arm of the L to the end of the other it is 1 m.
        assert!(
            hollow.iter().all(|gap| gap.contains("1.000 m")),
            "{hollow:?}"
        );
    }
}

#[test]
fn a_flat_mesh_has_no_hull() {
    let text = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\n";
    let flat = mesh("flat.obj", text.as_bytes(), "1 1 1");
    assert_eq!(flat.triangles.len(), 2, "a square is two triangles");
    assert!(!flat.is_solid());
}

#[test]
fn shapes_made_of_parts_weigh_as_their_parts() {
    // A capsule is a cylinder and a ball pulled apart: its moment along the axis is the sum of theirs.
    let (radius_m, length_m, mass) = (0.1, 0.5, 3.0);
    let capsule = Geometry::Capsule { radius_m, length_m };
    let cylinder = Geometry::Cylinder { radius_m, length_m };
    let ball = Geometry::Sphere { radius_m };
    let total = cylinder.volume_m3(&[]) + ball.volume_m3(&[]);
    assert!((capsule.volume_m3(&[]) - total).abs() < 1e-15);
    let share = |part: &Geometry| {
        part.inertial(mass * part.volume_m3(&[]) / total, &[])
            .expect("a volume")
    };
    let along = share(&cylinder).tensor_kg_m2[2] + share(&ball).tensor_kg_m2[2];
    let found = capsule.inertial(mass, &[]).expect("a volume");
    assert!((found.tensor_kg_m2[2] - along).abs() < 1e-15);
    // An ellipsoid with equal axes is a ball.
    let round = Geometry::Ellipsoid {
        radii_m: [radius_m; 3],
    };
    assert_eq!(round.inertial(1.0, &[]), ball.inertial(1.0, &[]));
}

proptest! {
    #[test]
    fn a_pose_and_its_inverse_cancel(a in any_pose(), b in any_pose(), point in [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64]) {
        let back = a.inverse().then(&a).apply(point);
        prop_assert!(close(&back, &point));
        prop_assert!(close(&a.then(&b).apply(point), &a.apply(b.apply(point))));
    }

    #[test]
    fn rotations_are_found_again_from_their_axes(pose in any_pose()) {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| pose::rotate(pose.rotation, axis));
        let found = pose::from_axes(axes[0], axes[1], axes[2]);
        let same: f64 = found.iter().zip(pose.rotation).map(|(a, b)| a * b).sum();
        prop_assert!((same.abs() - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn principal_axes_give_the_tensor_back(moments in [0.1..1.0, 0.1..1.0, 0.1..1.0_f64], pose in any_pose()) {
        let diagonal = Inertial { mass_kg: 1.0, centre_m: [0.0; 3], tensor_kg_m2: [moments[0], moments[1], moments[2], 0.0, 0.0, 0.0] };
        let turned = diagonal.placed(&pose);
        let (found, axes) = turned.principal_axes();
        let again = Inertial { tensor_kg_m2: [found[0], found[1], found[2], 0.0, 0.0, 0.0], ..diagonal }
            .placed(&Pose::turned(axes));
        prop_assert!(close(&again.tensor_kg_m2, &turned.tensor_kg_m2), "{again:?}");
        let mut sorted = moments;
        sorted.sort_by(f64::total_cmp);
        prop_assert!(close(&turned.principal_moments_kg_m2(), &sorted));
    }

    #[test]
    fn halves_of_a_box_weigh_as_the_box(half in [0.1..1.0, 0.1..1.0, 0.1..1.0_f64], cut in 0.1..0.9_f64, pose in any_pose()) {
        let [a, b, c] = half;
        let part = |from: f64, to: f64| {
            let shape = Geometry::Box { half_extents_m: [(to - from) / 2.0, b, c] };
            let mass = shape.volume_m3(&[]);
            shape.inertial(mass, &[]).expect("a volume").placed(&Pose::at([f64::midpoint(from, to), 0.0, 0.0])).placed(&pose)
        };
        let middle = -a + 2.0 * a * cut;
        let joined = part(-a, middle).joined(&part(middle, a));
        let whole = part(-a, a);
        prop_assert!((joined.mass_kg - whole.mass_kg).abs() < 1e-12);
        prop_assert!(close(&joined.centre_m, &whole.centre_m));
        prop_assert!(joined.tensor_kg_m2.iter().zip(whole.tensor_kg_m2).all(|(a, b)| (a - b).abs() < 1e-11));
    }
}
