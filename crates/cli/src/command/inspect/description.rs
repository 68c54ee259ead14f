//! A robot's or scene's description in words.

use corroborate::inspect::collision_shapes;
use robot_model::{Gap, JointKind, Loaded, Model};
use std::fmt::Write;

/// Its tree, and what of it a simulation would not have.
pub fn text(file: &str, loaded: &Loaded) -> String {
    let model = &loaded.model;
    let mut output = format!(
        "{file}: {} of {}: {}, {}, {} of freedom, {:.6} kg\n\n",
        model.format,
        model.name,
        counted(model.links.len(), "link"),
        counted(model.joints.len(), "joint"),
        counted(model.freedoms(), "degree"),
        model.total_mass_kg()
    );
    tree(&mut output, model);
    names(
        &mut output,
        "sensors",
        model.sensors.iter().map(|sensor| &sensor.name),
    );
    names(
        &mut output,
        "drives",
        model.actuators.iter().map(|drive| &drive.name),
    );
    warnings(&mut output, loaded);
    gaps(&mut output, &loaded.gaps, !loaded.warnings.is_empty());
    output
}

/// `1 link`, `2 links`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Links by their place in the tree, with what moves them.
fn tree(output: &mut String, model: &Model) {
    let mut depths: Vec<usize> = Vec::with_capacity(model.links.len());
    for (index, link) in model.links.iter().enumerate() {
        let depth = link.parent.map_or(0, |parent| depths[parent] + 1);
        depths.push(depth);
        // Long chains stay on the page.
        let indent = "  ".repeat(depth.min(20));
        let mut line = format!("{indent}{}", link.name);
        for joint in model.joints_of(index) {
            let _ = write!(line, "  {} {}", joint.kind, joint.name);
            if let Some([low, high]) = joint.limits {
                let unit = if joint.kind == JointKind::Prismatic {
                    "m"
                } else {
                    "rad"
                };
                let _ = write!(line, " [{low:.4}, {high:.4}] {unit}");
            }
        }
        if let Some(inertial) = link.inertial {
            let _ = write!(line, "  {:.4} kg", inertial.mass_kg);
        }
        let shapes = collision_shapes(model, index);
        if shapes > 0 {
            let _ = write!(line, "  {}", counted(shapes, "shape"));
        }
        let _ = writeln!(output, "{line}");
    }
}

fn names<'a>(output: &mut String, what: &str, names: impl Iterator<Item = &'a String>) {
    let names: Vec<&str> = names.map(String::as_str).collect();
    if !names.is_empty() {
        let _ = writeln!(output, "\n{what}: {}", names.join(", "));
    }
}

fn warnings(output: &mut String, loaded: &Loaded) {
    if loaded.warnings.is_empty() {
        return;
    }
    let _ = writeln!(output, "\nprobably wrong:");
    for warning in &loaded.warnings {
        let _ = writeln!(output, "  {warning}");
    }
}

/// Gaps by what they concern; those of one kind on one line.
fn gaps(output: &mut String, gaps: &[Gap], has_warnings: bool) {
    if gaps.is_empty() {
        output.push_str(match has_warnings {
            false => "\nEverything in it was carried over.\n",
            true => "\nBut for what is probably wrong, everything in it was carried over.\n",
        });
        return;
    }
    let _ = writeln!(output, "\nnot carried over ({}):", gaps.len());
    let mut groups: std::collections::BTreeMap<_, Vec<&Gap>> = std::collections::BTreeMap::new();
    for gap in gaps {
        groups
            .entry((gap.effect, &gap.element, &gap.what))
            .or_default()
            .push(gap);
    }
    for ((effect, element, what), members) in groups {
        let first = members[0];
        let others = match members.len() {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        let _ = writeln!(
            output,
            "  {effect}: {element} {what}: {} ({}{others})",
            first.consequence, first.place
        );
    }
}
