//! What other readers take without a word is no reason to refuse a robot.

use crate::common::{elements, loaded};
use robot_model::{JointKind, parse};

#[test]
fn commas_and_a_trailing_nul_are_read_with_a_warning() {
    let text = "<robot name='r'><link name='a'><collision><origin xyz='1, 2,3'/><geometry><sphere radius='1'/></geometry></collision></link></robot>\0";
    let loaded = loaded("r.urdf", text);
    let shape = &loaded.model.links[0].shapes[0];
    assert_eq!(shape.pose_in_link.position_m, [1.0, 2.0, 3.0]);
    assert_eq!(loaded.warnings.len(), 1);
    assert!(loaded.warnings[0].message.contains("commas"));
}

#[test]
fn a_shape_of_no_size_is_left_out_and_said() {
    let text = "<robot name='r'><link name='a'><collision><geometry><sphere radius='0'/></geometry></collision></link></robot>";
    let loaded = loaded("r.urdf", text);
    assert!(loaded.model.links[0].shapes.is_empty());
    assert_eq!(elements(&loaded.gaps), ["sphere@radius"]);
}

#[test]
fn limits_upside_down_are_none_a_reduction_may_be_a_word_and_spherical_is_a_ball() {
    let text = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
<joint name='j' type='revolute'><parent link='a'/><child link='b'/><limit lower='1' upper='-1' effort='1' velocity='1'/></joint>
<joint name='k' type='spherical'><parent link='b'/><child link='c'/></joint>
<transmission name='t'><joint name='j'/><actuator name='m'><mechanicalReduction>reduction</mechanicalReduction></actuator></transmission></robot>";
    let loaded = loaded("r.urdf", text);
    assert_eq!(loaded.model.joints[0].limits, None);
    assert_eq!(loaded.model.joints[1].kind, JointKind::Ball);
    assert!(loaded.warnings[0].message.contains("above its upper limit"));
    assert_eq!(
        elements(&loaded.gaps),
        ["joint@type", "actuator/mechanicalReduction"]
    );
}

#[test]
fn a_face_of_two_corners_has_no_area_and_no_harm() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let text = "<robot name='r'><link name='a'><collision><geometry><mesh filename='m.obj'/></geometry></collision></link></robot>";
    let mut files = |_: &str| Ok(mesh.as_bytes().to_vec());
    let loaded = parse("r.urdf", text, &mut files).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(loaded.model.meshes[0].triangles.len(), 4);
}
