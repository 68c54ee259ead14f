//! What can be seen to be wrong in masses and inertias where they stand; what is made of it is in [`crate::dynamics`].

use crate::diagnostics::Place;
use crate::dynamics::Unphysical;
use crate::reader::Reader;
use crate::shape::Inertial;

/// Checks one inertia at the place where it stands.
pub(crate) fn inertia(reader: &mut Reader<'_, '_>, place: &Place, link: &str, given: &Inertial) {
    if given.mass_kg < 0.0 {
        let message = format!("link {link} has a negative mass ({} kg)", given.mass_kg);
        reader.problem(place, message, "give a mass of at least 0");
        return;
    }
    let [low, middle, high] = given.principal_moments_kg_m2();
    let moments = format!("principal moments {low:.4e}, {middle:.4e}, {high:.4e} kg m²");
    let (simulated, Some(unphysical)) = given.simulated() else {
        return;
    };
    let [least, _, most] = simulated.map_or([0.0; 3], |it| it.principal_moments_kg_m2());
    let (message, remedy) = match unphysical {
        // Descriptions print a few digits; nothing is to be done about it.
        Unphysical::Rounded => return,
        Unphysical::Thin => (
            format!("link {link} has no inertia about an axis ({moments})"),
            format!("give it its thickness; a simulation takes {least:.4e} kg m² at least"),
        ),
        Unphysical::Impossible if low < 0.0 => (
            format!("the inertia of link {link} is not positive definite ({moments})"),
            format!(
                "check the signs of the products of inertia and the unit (kg m², not kg mm²); a simulation takes their mean, {most:.4e} kg m², about every axis"
            ),
        ),
        Unphysical::Impossible => (
            format!(
                "no rigid body has the inertia of link {link}: {moments}, the largest exceeds the sum of the others"
            ),
            format!(
                "compute it again from the body's shape; a simulation takes their mean, {most:.4e} kg m², about every axis"
            ),
        ),
    };
    reader.warn(place, message, remedy);
}
