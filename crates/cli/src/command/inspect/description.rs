//! A robot's or scene's description in words.

use corroborate::inspect::collision_shapes;
use robot_model::{JointKind, Loaded, Model};
use std::fmt::Write;
use testbench::scene::{SceneGap, description_gaps};

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
    refusals(&mut output, loaded);
    warnings(&mut output, loaded);
    // Exactly what a scene with this description says that it lacks.
    let mut lacking = description_gaps(file, loaded);
    lacking.retain(|gap| gap.effect != "doubt");
    let is_sound = loaded.warnings.is_empty() && loaded.refusals(false).is_empty();
    gaps(&mut output, &lacking, is_sound);
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

/// What keeps a simulation from running it, if its base is fixed or only if it is free.
fn refusals(output: &mut String, loaded: &Loaded) {
    let always = loaded.refusals(true);
    let mut free = loaded.refusals(false);
    free.retain(|refusal| !always.iter().any(|known| known.place == refusal.place));
    let kinds = [
        ("a simulation refuses it", always),
        (
            "a simulation refuses it unless the scene fixes its base (`fixed = true`)",
            free,
        ),
    ];
    for (heading, refusals) in kinds {
        if !refusals.is_empty() {
            let _ = writeln!(output, "\n{heading}:");
        }
        for refusal in refusals {
            let _ = writeln!(output, "  {refusal}");
        }
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
fn gaps(output: &mut String, gaps: &[SceneGap], is_sound: bool) {
    if gaps.is_empty() {
        output.push_str(match is_sound {
            true => "\nEverything in it was carried over.\n",
            false => "\nBut for what is probably wrong, everything in it was carried over.\n",
        });
        return;
    }
    let _ = writeln!(output, "\nnot carried over ({}):", gaps.len());
    let mut groups: std::collections::BTreeMap<_, Vec<&SceneGap>> =
        std::collections::BTreeMap::new();
    for gap in gaps {
        groups
            .entry((rank(&gap.effect), &gap.element, &gap.what))
            .or_default()
            .push(gap);
    }
    for ((_, element, what), members) in groups {
        let first = members[0];
        let place = match first.place {
            Some([line, column]) => format!("{}:{line}:{column}", first.file),
            None => first.file.clone(),
        };
        let others = match members.len() {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        let _ = writeln!(
            output,
            "  {}: {element} {what}: {} ({place}{others})",
            first.effect, first.consequence
        );
    }
}

/// What changes how a robot moves comes first.
fn rank(effect: &str) -> usize {
    let order = [
        "motion", "contact", "sensing", "control", "looks", "nothing",
    ];
    let found = order.iter().position(|known| *known == effect);
    found.unwrap_or(order.len())
}
