//! How ROS 2 names stand on the wire.
//!
//! Source: ROS 2 design, "Topic and Service name mapping to DDS" and "Mapping between ROS interface types and DDS IDL
//! types": the topic `/robot/state` of type `pkg/msg/State` is the DDS topic `rt/robot/state` of type
//! `pkg::msg::dds_::State_`.

/// The name of a DDS topic as the user knows it: with `/` for a topic of ROS, unchanged for another. `None` for what
/// carries services, actions' replies and ROS's own discovery.
pub(crate) fn shown_topic(dds: &str) -> Option<String> {
    if let Some(ros) = dds.strip_prefix("rt/") {
        return Some(format!("/{ros}"));
    }
    let hidden = ["rq/", "rr/", "rs/", "rp/", "ra/"]
        .iter()
        .any(|prefix| dds.starts_with(prefix))
        || dds == "ros_discovery_info"
        || dds.starts_with("DCPS");
    (!hidden && !dds.is_empty()).then(|| dds.to_owned())
}

/// The DDS topic for a name as the user knows it.
pub(crate) fn dds_topic(shown: &str) -> String {
    if shown.starts_with('/') {
        format!("rt{shown}")
    } else {
        shown.to_owned()
    }
}

/// The name of a DDS type as the user knows it.
pub(crate) fn shown_type(dds: &str) -> String {
    let bare = dds.strip_suffix('_');
    match bare.and_then(|bare| bare.split_once("::dds_::")) {
        Some((package, name)) => format!("{}/{name}", package.replace("::", "/")),
        None => dds.to_owned(),
    }
}

/// The DDS type for a type as the user knows it. `pkg/State` means `pkg/msg/State`.
pub(crate) fn dds_type(shown: &str) -> String {
    let parts: Vec<&str> = shown.split('/').collect();
    match parts.as_slice() {
        [package, kind, name] => format!("{package}::{kind}::dds_::{name}_"),
        [package, name] => format!("{package}::msg::dds_::{name}_"),
        _ => shown.to_owned(),
    }
}

/// The type's hash that ROS 2 puts into a publisher's user data as `typehash=…;`.
pub(crate) fn type_hash(user_data: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(user_data).ok()?;
    let mut entries = text.split(['\0', ';']);
    let hash = entries.find_map(|entry| entry.strip_prefix("typehash="))?;
    Some(hash.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_there_and_back() {
        for (shown, dds) in [("/tf", "rt/tf"), ("/a/b", "rt/a/b"), ("Square", "Square")] {
            assert_eq!(dds_topic(shown), dds);
            assert_eq!(shown_topic(dds).as_deref(), Some(shown));
        }
        for (shown, dds) in [
            (
                "sensor_msgs/msg/JointState",
                "sensor_msgs::msg::dds_::JointState_",
            ),
            ("ShapeType", "ShapeType"),
        ] {
            assert_eq!(dds_type(shown), dds);
            assert_eq!(shown_type(dds), shown);
        }
        assert_eq!(dds_type("std_msgs/Bool"), "std_msgs::msg::dds_::Bool_");
    }

    #[test]
    fn services_and_discovery_are_hidden() {
        for name in [
            "rq/addRequest",
            "rr/addReply",
            "ros_discovery_info",
            "DCPSTopic",
            "",
        ] {
            assert_eq!(shown_topic(name), None, "{name}");
        }
    }

    #[test]
    fn the_hash_is_found_in_the_user_data() {
        assert_eq!(
            type_hash(b"typehash=RIHS01_ab12;"),
            Some("RIHS01_ab12".into())
        );
        assert_eq!(
            type_hash(b"enclave=/;typehash=RIHS01_c;x=1"),
            Some("RIHS01_c".into())
        );
        assert_eq!(type_hash(b"enclave=/;"), None);
        assert_eq!(type_hash(&[0xff, 0xfe]), None);
    }
}
