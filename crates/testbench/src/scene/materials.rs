//! What surfaces are made of, put on the shapes of a layout.

use super::build::{BuiltObject, BuiltPerson, BuiltRobot};
use super::data::{Material, SceneData, key_of};
use super::draws::Draws;
use crate::bench::ScenarioError;
use crate::physics::{Layout, ShapePlan};

/// Gives the shapes of what is made of a material its friction and its surface.
///
/// # Errors
/// [`ScenarioError::UnknownName`] for a link that a description does not have.
pub(super) fn coat(
    layout: &mut Layout,
    data: &SceneData,
    (robots, objects, people): (&[BuiltRobot], &[BuiltObject], &[BuiltPerson]),
    draws: Draws,
) -> Result<(), ScenarioError> {
    let named = |name: &Option<String>| {
        let name = name.as_ref()?;
        data.materials.iter().find(|it| &it.name == name)
    };
    let ground = data.ground.as_ref().and_then(|it| named(&it.material));
    if let (Some(material), Some(shape)) = (ground, layout.shapes.first_mut()) {
        put_on(shape, material, draws);
    }
    for (robot, built) in data.robots.iter().zip(robots) {
        let shapes = built.added.shapes.clone();
        if let Some(material) = named(&robot.material) {
            coat_all(layout, shapes.clone(), material, draws);
        }
        for (link, material) in &robot.materials {
            let Some(body) = built.added.links.get(link) else {
                return Err(ScenarioError::UnknownName {
                    key: key_of("robot", &robot.name, "materials"),
                    name: link.clone(),
                });
            };
            let own = &mut layout.shapes[shapes.clone()];
            let own = own.iter_mut().filter(|shape| shape.body == Some(*body));
            if let Some(material) = named(&Some(material.clone())) {
                own.for_each(|shape| put_on(shape, material, draws));
            }
        }
    }
    let of_objects = data.objects.iter().zip(objects);
    let of_objects = of_objects.map(|(object, built)| (&object.material, &built.shapes));
    let of_people = data.people.iter().zip(people);
    let of_people = of_people.map(|(person, built)| (&person.material, &built.shapes));
    for (material, shapes) in of_objects.chain(of_people) {
        if let Some(material) = named(material) {
            coat_all(layout, shapes.clone(), material, draws);
        }
    }
    Ok(())
}

fn coat_all(
    layout: &mut Layout,
    shapes: std::ops::Range<usize>,
    material: &Material,
    draws: Draws,
) {
    for shape in &mut layout.shapes[shapes] {
        put_on(shape, material, draws);
    }
}

fn put_on(shape: &mut ShapePlan, material: &Material, draws: Draws) {
    if let Some(friction) = &material.friction {
        shape.friction = draws.of("material", &material.name, "friction", friction);
    }
    shape.surface = material.surface();
}
