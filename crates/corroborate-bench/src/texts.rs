//! The assets of a study as texts, and what such texts say: changes are made on them by the code of the product.

use crate::fault::Assets;
use crate::requirements::Forms;
use crate::study::ids;
use checker::Method;
use std::fmt::Write as _;

/// The time step that a scene begins with.
const STEP_SECS: f64 = 0.002;

/// The place of the time step in a scene.
pub const STEP_KEY: &str = "simulation.time_step_secs";

fn value(text: &str) -> Result<toml::Table, String> {
    text.parse()
        .map_err(|error: toml::de::Error| error.to_string())
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The requirements with their forms.
#[must_use]
pub fn requirements(forms: &[Forms]) -> String {
    let mut text = String::from("# What is required, each once.\n");
    for form in forms {
        let _ = write!(
            text,
            "\n[[requirement]]\nid = {}\nshall = {}\n",
            quoted(form.id),
            quoted(&form.sentence)
        );
        if let Some(property) = &form.property {
            let _ = writeln!(text, "property = {}", quoted(property));
        }
        if let Some(monitor) = &form.monitor {
            let _ = writeln!(text, "formula = {}", quoted(monitor));
        }
        if form.clock != 1.0 {
            let _ = writeln!(text, "clock = {}", form.clock);
        }
    }
    text
}

/// Takes the forms from a text of requirements.
///
/// # Errors
/// What is wrong with the text.
pub fn read_requirements(text: &str, forms: &mut [Forms]) -> Result<(), String> {
    let document = value(text)?;
    let tables = document.get("requirement").and_then(toml::Value::as_array);
    for form in forms {
        let mut own = tables.into_iter().flatten();
        let own = own.find(|table| table.get("id").and_then(toml::Value::as_str) == Some(form.id));
        let own = own.ok_or_else(|| format!("no requirement `{}`", form.id))?;
        let said = |key: &str| {
            own.get(key)
                .and_then(toml::Value::as_str)
                .map(str::to_owned)
        };
        form.property = said("property");
        form.monitor = said("formula");
        form.clock = own
            .get("clock")
            .and_then(toml::Value::as_float)
            .unwrap_or(1.0);
    }
    Ok(())
}

const METHODS: [(Method, &str); 2] = [
    (Method::Sound, "sound"),
    (Method::PrismDefault, "prism-default"),
];

/// The ledger's entry of the formal evidence.
#[must_use]
pub fn ledger(methods: &[Method]) -> String {
    let names = methods.iter().map(|method| {
        let known = METHODS.iter().find(|(known, _)| known == method);
        quoted(known.map_or("sound", |(_, name)| name))
    });
    let names: Vec<String> = names.collect();
    format!(
        "[[evidence]]\nid = \"{}\"\nmethods = [{}]\n",
        ids::MODEL,
        names.join(", ")
    )
}

/// The methods of a ledger.
///
/// # Errors
/// What is wrong with the text.
pub fn read_methods(text: &str) -> Result<Vec<Method>, String> {
    let document = value(text)?;
    let methods = document
        .get("evidence")
        .and_then(|all| all.get(0)?.get("methods")?.as_array());
    let methods = methods.ok_or("no methods")?.iter().map(|name| {
        let mut known = METHODS.iter();
        let found = known.find(|(_, known)| name.as_str() == Some(known));
        found.map(|(method, _)| *method).ok_or("an unknown method")
    });
    Ok(methods.collect::<Result<_, _>>()?)
}

/// The simulator's scene.
#[must_use]
pub fn scene() -> String {
    format!("[simulation]\ntime_step_secs = {STEP_SECS}\n")
}

/// The step of a scene, as a part of that of [`scene`].
///
/// # Errors
/// What is wrong with the text.
pub fn read_step(text: &str) -> Result<f64, String> {
    let document = value(text)?;
    let step = document
        .get("simulation")
        .and_then(|it| it.get("time_step_secs")?.as_float());
    Ok(step.ok_or("no time step")? / STEP_SECS)
}

/// The experiments' table: which stage's failures stand in the row of each name.
#[must_use]
pub fn table(assets: &Assets) -> String {
    let rows = assets.modes.iter().zip(&assets.columns);
    let mut text = String::from("mode,stage\n");
    for (mode, stage) in rows {
        let _ = writeln!(text, "{mode},{stage}");
    }
    text
}

/// The stages by name, in the order of `modes`.
///
/// # Errors
/// What is wrong with the text.
pub fn read_table(text: &str, modes: &[String]) -> Result<Vec<usize>, String> {
    let of = |mode: &String| {
        let mut rows = text.lines().filter_map(|line| line.split_once(','));
        let row = rows.find(|(name, _)| name == mode);
        let stage = row.and_then(|(_, stage)| stage.parse().ok());
        stage.ok_or_else(|| format!("no row `{mode}`"))
    };
    modes.iter().map(of).collect()
}
