//! A topic map to begin with.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::fields::{FieldSummary, FieldValue};
use super::{Inspection, TopicInspection};

pub(super) fn draft_map(found: &Inspection) -> String {
    let mut text = String::from(
        "# A draft: delete what is not needed, rename the signals, and fill in what is marked.\n",
    );
    time_section(found, &mut text);
    frames(found, &mut text);
    let mut names = BTreeSet::new();
    for topic in &found.topics {
        // Times and transforms are not signals by themselves.
        if matches!(topic.name.as_str(), "/tf" | "/tf_static" | "/clock") {
            continue;
        }
        let (name, type_name) = (comment(&topic.name), comment(or_unknown(&topic.type_name)));
        let _ = write!(text, "\n# {name} ({type_name})");
        match topic.rate_hz {
            Some(rate_hz) => {
                let _ = writeln!(text, ", {rate_hz:.1} Hz");
            }
            None => text.push('\n'),
        }
        if let Some(reason) = &topic.undecodable {
            let _ = writeln!(text, "# cannot be decoded: {}", comment(reason));
        }
        for field in &topic.fields {
            entry(topic, field, &mut names, &mut text);
        }
    }
    text
}

fn or_unknown(type_name: &str) -> &str {
    if type_name.is_empty() {
        "no type"
    } else {
        type_name
    }
}

/// One line of a comment: letters that would end it, or that TOML does not allow, become spaces.
fn comment(text: &str) -> String {
    let shown = |letter: char| if letter.is_control() { ' ' } else { letter };
    text.chars().map(shown).collect()
}

fn time_section(found: &Inspection, text: &mut String) {
    text.push_str("\n[time]\nfrom = \"log\" # or publish, header or clock\n");
    let stamped: Vec<&TopicInspection> = found
        .topics
        .iter()
        .filter(|topic| topic.behind_stamp_secs.is_some())
        .collect();
    if !stamped.is_empty() {
        text.push_str("# log time minus the stamps of the headers, least and greatest:\n");
    }
    for topic in stamped {
        if let Some((least, most)) = topic.behind_stamp_secs {
            let name = comment(&topic.name);
            let _ = writeln!(text, "#   {name}: {least:.6} s to {most:.6} s");
        }
    }
}

fn frames(found: &Inspection, text: &mut String) {
    if found.frames.is_empty() {
        return;
    }
    text.push_str("\n# Frames, each in its parent:\n");
    for frame in &found.frames {
        let kind = if frame.is_static { "static" } else { "moving" };
        let _ = writeln!(
            text,
            "#   {} in {} ({kind})",
            comment(&frame.frame),
            comment(&frame.parent)
        );
    }
    let parents: BTreeSet<&str> = found
        .frames
        .iter()
        .map(|frame| frame.parent.as_str())
        .collect();
    let leaf = found
        .frames
        .iter()
        .find(|frame| !frame.is_static && !parents.contains(frame.frame.as_str()));
    if let Some(leaf) = leaf {
        let root = root_of(found, &leaf.frame);
        let _ = write!(
            text,
            "# A position comes from transforms like this:\n# [\"/hand\"]\n# position_of = {}\n\
             # in_frame = {}\n",
            quoted(&leaf.frame),
            quoted(root)
        );
    }
}

fn root_of<'f>(found: &'f Inspection, frame: &'f str) -> &'f str {
    let mut current = frame;
    for _ in 0..found.frames.len() {
        match found.frames.iter().find(|edge| edge.frame == current) {
            Some(edge) => current = &edge.parent,
            None => break,
        }
    }
    current
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn entry(
    topic: &TopicInspection,
    field: &FieldSummary,
    names: &mut BTreeSet<String>,
    text: &mut String,
) {
    // The parts of a time are no signals.
    if field.path.ends_with(".nanosec") || field.path.ends_with(".sec") {
        return;
    }
    let is_name = matches!(&field.first, FieldValue::Text(_));
    let is_label = field.path.ends_with("frame_id") || field.path.starts_with("name[");
    if is_name && is_label {
        return;
    }
    let name = unique(signal_name(topic, field), names);
    let from = quoted(&format!("{}.{}", topic.name, field.path));
    let _ = write!(text, "[{}]\nfrom = {from}\n", quoted(&name));
    match &field.first {
        FieldValue::Text(value) => {
            let _ = writeln!(text, "values = [{}] # fill in: all values", quoted(value));
        }
        FieldValue::Bool(_) => text.push_str("kind = \"bool\"\n"),
        _ if field.unit.is_empty() => {
            let hint = joint_hint(topic, field);
            let _ = writeln!(text, "# unit = \"\" # fill in{hint}");
        }
        _ => {
            let _ = writeln!(text, "unit = {}", quoted(&field.unit));
        }
    }
    if let Some(count) = field.elements {
        let _ = writeln!(text, "# the first of {count} elements");
    }
}

fn joint_hint(topic: &TopicInspection, field: &FieldSummary) -> &'static str {
    if !topic.type_name.ends_with("JointState") {
        return "";
    }
    match field.path.split('[').next() {
        Some("position") => ": rad if the joint turns, m if it slides",
        Some("velocity") => ": rad/s if the joint turns, m/s if it slides",
        Some("effort") => ": N*m if the joint turns, N if it slides",
        _ => "",
    }
}

/// The topic without its first slash as a field: `/arm/joint_states` and `velocity[name='wrist']`
/// become `/arm/joint_states.velocity_wrist`.
fn signal_name(topic: &TopicInspection, field: &FieldSummary) -> String {
    let words = field.path.replace("[name='", "_").replace(['[', ' '], "_");
    let fits = |letter: &char| letter.is_alphanumeric() || "._-".contains(*letter);
    let path: String = words.chars().filter(fits).collect();
    let path = if path.is_empty() { "value" } else { &path };
    let fits = |letter: &char| letter.is_alphanumeric() || "/_-".contains(*letter);
    let topic_name: String = topic
        .name
        .replace(['.', ' '], "_")
        .chars()
        .filter(fits)
        .collect();
    let topic_name = topic_name.trim_start_matches('/');
    let topic_name = if topic_name.is_empty() {
        "topic"
    } else {
        topic_name
    };
    format!("/{topic_name}.{path}")
}

fn unique(name: String, names: &mut BTreeSet<String>) -> String {
    let mut candidate = name.clone();
    let mut number = 2;
    while !names.insert(candidate.clone()) {
        candidate = format!("{name}_{number}");
        number += 1;
    }
    candidate
}
