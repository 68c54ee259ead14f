//! What becomes of robots' descriptions in a scene, for comparison with another simulator: one line of JSON for each file.
//!
//! `cargo run --example robots -- LIBRARY SECONDS < FILES`
//!
//! Each robot stands alone in a scene without ground or drives, the root of a URDF fixed, and moves for the given time
//! without contact, in steps of 2 ms or of the description's own length, if that is shorter. The line has what a scene lacks of the description, or why it is refused, the total mass, the
//! degrees of freedom, and where links are in the end.

use std::error::Error;
use std::io::BufRead;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};
use stimulus::Stimulus;
use testbench::Engine;
use testbench::controller::ControllerError;
use testbench::physics::{Layout, Motion, MujocoPhysics, Physics, Touches};
use testbench::scene::{SceneBench, mujoco};
use testbench::{Bench, Cancel, Unwatched};

/// The longest and the shortest time step; the other simulator takes the same.
const STEP_SECS: [f64; 2] = [0.002, 0.0001];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [library, seconds] = arguments.as_slice() else {
        return Err("give LIBRARY SECONDS, and files on standard input".into());
    };
    let engine = Engine::load(Path::new(library))?;
    let seconds: f64 = seconds.parse()?;
    for file in std::io::stdin().lock().lines() {
        let file = file?;
        // One that makes the program fail does not keep the others from being looked at.
        let run = AssertUnwindSafe(|| run(&engine, Path::new(&file), seconds));
        let found = catch_unwind(run).unwrap_or_else(|_| json!({ "refused": "panicked" }));
        println!("{}", json!({ "file": file, "ours": found }));
    }
    Ok(())
}

fn run(engine: &Engine, file: &Path, seconds: f64) -> Value {
    let folder = file.parent().unwrap_or(Path::new("."));
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let read = |address: &str| {
        let local = address.strip_prefix("file://").unwrap_or(address);
        std::fs::read(folder.join(local)).map_err(|error| error.to_string())
    };
    let inspected = read(&name)
        .and_then(|bytes| String::from_utf8(bytes).map_err(|error| error.to_string()))
        .and_then(|text| {
            let mut resolve = |address: &str| read(address);
            robot_model::parse(&name, &text, &mut resolve).map_err(|error| error.to_string())
        });
    let inspected = match inspected {
        Ok(inspected) => inspected,
        Err(refused) => return json!({ "unread": refused }),
    };
    let [longest, shortest] = STEP_SECS;
    let own_secs = inspected.model.time_step_secs.unwrap_or(longest);
    let step_secs = own_secs.clamp(shortest, longest);
    let no_code = Arc::new(|_: &_| {
        Err(ControllerError::Failed {
            message: "no controller is wanted".into(),
        })
    });
    let scene = scene_of(file, &name, step_secs);
    let (bench, gaps) = match SceneBench::new(&scene, &read, mujoco(engine), no_code) {
        Ok(made) => made,
        Err(refused) => return json!({ "refused": refused.to_string() }),
    };
    // As `simulate` runs it, with contact.
    let wait = Stimulus::of(bench.tests()[0].clone());
    if let Err(refused) = bench.run(&wait, 1, &mut Unwatched, &Cancel::default()) {
        return json!({ "refused": refused.to_string() });
    }
    let steps = (seconds / step_secs).round() as u64;
    let gaps: Vec<Value> = gaps
        .iter()
        .map(|gap| json!([gap.effect, gap.element, gap.what]))
        .collect();
    match bench.layout_of(1) {
        Ok(layout) => moved(engine, layout, steps, gaps),
        Err(refused) => json!({ "refused": refused.to_string() }),
    }
}

/// A scene with the robot alone and an episode of a twentieth of a second.
fn scene_of(file: &Path, name: &str, step_secs: f64) -> String {
    let is_urdf = file.extension().is_some_and(|ending| ending == "urdf");
    format!(
        "name = \"robots\"\nabstract_test = [{{ name = \"wait\", actions = [] }}]\n\
         [simulation]\nduration_secs = {0}\ntime_step_secs = {step_secs}\nrecord_hz = {1}\npeople_hz = {1}\n\
         [[robot]]\nname = \"robot\"\nfile = {name:?}\nfixed = {is_urdf}\n",
        20.0 * step_secs,
        0.1 / step_secs
    )
}

fn moved(engine: &Engine, mut layout: Layout, steps: u64, gaps: Vec<Value>) -> Value {
    for shape in &mut layout.shapes {
        shape.touches = Touches::Nothing;
    }
    let mut physics = match MujocoPhysics::new(engine, &layout) {
        Ok(physics) => physics,
        Err(refused) => return json!({ "refused": refused.to_string() }),
    };
    for _ in 0..steps {
        physics.step();
    }
    let free = layout.bodies.iter().filter(|it| it.motion == Motion::Free);
    let joints = layout.joints.iter().map(|joint| match joint.kind {
        testbench::physics::JointKind::Ball => 3,
        _ => 1,
    });
    let mass_kg: f64 = layout
        .bodies
        .iter()
        .filter_map(|body| body.inertia.map(|inertia| inertia.mass_kg))
        .sum();
    let bodies: Vec<Value> = layout
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| {
            let pose = physics.body_pose(index);
            let name = body.name.strip_prefix("robot/").unwrap_or(&body.name);
            json!([name, pose.position_m, pose.orientation])
        })
        .collect();
    json!({
        "gaps": gaps, "sound": physics.is_sound(), "mass_kg": mass_kg,
        "freedoms": 6 * free.count() + joints.sum::<usize>(), "bodies": bodies,
    })
}
