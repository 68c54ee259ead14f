//! What was seen of an episode, for the page and for Foxglove.

use super::shown::nanos;
use diagnostic::Problem;
use evidence::replay::{Form, Role, Scene, Shape};
use recording::{SceneFile, SceneForm, ScenePose, SceneShape};
use testbench::geometry::Pose;
use testbench::physics::Form as BenchForm;
use testbench::{Role as BenchRole, ViewKeeper, VisibleShape, hull_triangles};

/// Half the edge of the ground where it has to have one, in metres.
const GROUND_HALF_M: f64 = 5.0;
/// How thick the ground is drawn.
const GROUND_THICK_M: f64 = 0.01;

/// For the page.
pub fn of_page(seen: &ViewKeeper) -> Scene {
    let pose = |pose: &Pose| (pose.position_m, pose.orientation);
    let shape = |shape: &VisibleShape| {
        Some(Shape {
            body: shape.body,
            role: match shape.role {
                BenchRole::Robot => Role::Robot,
                BenchRole::Object => Role::Object,
                BenchRole::Person => Role::Person,
                BenchRole::Surroundings => Role::Surroundings,
            },
            pose: pose(&shape.pose),
            form: form(&shape.form)?,
        })
    };
    Scene {
        bodies: seen.geometry.bodies.clone(),
        shapes: seen.geometry.shapes.iter().filter_map(shape).collect(),
        times_secs: seen.times_secs.clone(),
        poses: seen
            .poses
            .iter()
            .map(|poses| poses.iter().map(pose).collect())
            .collect(),
    }
}

/// `None` for a hull of points in one plane, of which nothing is seen.
fn form(form: &BenchForm) -> Option<Form> {
    Some(match form {
        BenchForm::Ground => Form::Ground,
        BenchForm::Box { edges_m } => Form::Box { edges_m: *edges_m },
        BenchForm::Sphere { radius_m } => Form::Ellipsoid {
            radii_m: [*radius_m; 3],
        },
        BenchForm::Ellipsoid { radii_m } => Form::Ellipsoid { radii_m: *radii_m },
        BenchForm::Capsule { radius_m, length_m } => Form::Capsule {
            radius_m: *radius_m,
            length_m: *length_m,
        },
        BenchForm::Cylinder { radius_m, length_m } => Form::Cylinder {
            radius_m: *radius_m,
            length_m: *length_m,
        },
        BenchForm::Hull { points_m } => {
            let corners = hull_triangles(points_m);
            if corners.is_empty() {
                return None;
            }
            Form::Triangles {
                points_m: points_m.clone(),
                corners,
            }
        }
    })
}

/// For Foxglove's 3D panel.
pub fn of_foxglove(seen: &ViewKeeper) -> Result<Vec<u8>, Problem> {
    let failed = |error: recording::RawWriteError| {
        Problem::new("cannot-record", format!("the scene: {error}"))
    };
    let bodies = &seen.geometry.bodies;
    let shapes = seen.geometry.shapes.iter();
    let shapes: Vec<SceneShape> = shapes.filter_map(|it| shape_of(it, bodies)).collect();
    let mut file = SceneFile::new().map_err(failed)?;
    if let Some(first_secs) = seen.times_secs.first() {
        file.shapes(nanos(*first_secs), &shapes).map_err(failed)?;
    }
    for (time_secs, poses) in seen.times_secs.iter().zip(&seen.poses) {
        let poses = bodies.iter().cloned().zip(poses.iter().map(place));
        let poses: Vec<(String, ScenePose)> = poses.collect();
        file.poses(nanos(*time_secs), &poses).map_err(failed)?;
    }
    file.finish().map_err(failed)
}

fn place(pose: &Pose) -> ScenePose {
    ScenePose {
        position_m: pose.position_m,
        orientation: pose.orientation,
    }
}

fn shape_of(shape: &VisibleShape, bodies: &[String]) -> Option<SceneShape> {
    let mut pose = place(&shape.pose);
    let form = match form(&shape.form)? {
        Form::Ground => {
            pose.position_m[2] -= GROUND_THICK_M / 2.0;
            SceneForm::Box {
                edges_m: [2.0 * GROUND_HALF_M, 2.0 * GROUND_HALF_M, GROUND_THICK_M],
            }
        }
        Form::Box { edges_m } => SceneForm::Box { edges_m },
        Form::Ellipsoid { radii_m } => SceneForm::Ellipsoid { radii_m },
        Form::Cylinder { radius_m, length_m } => SceneForm::Cylinder { radius_m, length_m },
        Form::Capsule { radius_m, length_m } => SceneForm::Capsule { radius_m, length_m },
        Form::Triangles { points_m, corners } => SceneForm::Triangles { points_m, corners },
    };
    Some(SceneShape {
        name: shape.name.clone(),
        body: shape.body.and_then(|body| bodies.get(body).cloned()),
        pose,
        form,
        colour: match shape.role {
            BenchRole::Robot => [0.53, 0.57, 0.65, 1.0],
            BenchRole::Object => [0.82, 0.44, 0.12, 1.0],
            BenchRole::Person => [0.25, 0.53, 0.79, 1.0],
            BenchRole::Surroundings => [0.81, 0.78, 0.72, 1.0],
        },
    })
}
