//! Where the files of packages are: `package://` of ROS and `model://` of Gazebo.

use crate::xml;

/// The paths at which `package://PACKAGE/FILE` or `model://PACKAGE/FILE` may be, in the order in which they are to be tried:
/// in each folder above the description, the nearest first, as the package itself and as what has the package in it.
/// Empty for every other address.
///
/// ```
/// let paths = robot_model::package_paths("robots/arm/urdf/arm.urdf", "package://arm/meshes/link.stl");
/// assert_eq!(paths[1], "robots/arm/meshes/link.stl");
/// assert!(robot_model::package_paths("arm.urdf", "meshes/link.stl").is_empty());
/// ```
#[must_use]
pub fn package_paths(description: &str, address: &str) -> Vec<String> {
    let named = match address.split_once("://") {
        Some(("package" | "model", named)) => named,
        _ => return vec![],
    };
    let (package, inside) = named.split_once('/').unwrap_or((named, ""));
    let mut found = vec![];
    let mut folder = description;
    while let Some((above, _)) = folder.rsplit_once('/') {
        folder = above;
        if folder.rsplit('/').next() == Some(package) {
            found.push(format!("{folder}/{inside}"));
        }
        found.push(format!("{folder}/{named}"));
    }
    if !description.starts_with('/') {
        found.push(named.to_owned());
    }
    found
}

/// The path at which `package://PACKAGE/FILE` is if the description itself lies in that package, whatever its folder is called:
/// in the nearest folder above it whose `package.xml` says the package's name. `read` gives a file's text, if there is one.
///
/// ```
/// let mut read = |path: &str| {
///     let text = "<package><name>arm_description</name></package>";
///     (path == "checkout/package.xml").then(|| text.to_owned())
/// };
/// let address = "package://arm_description/meshes/link.stl";
/// let found = robot_model::own_package_path("checkout/urdf/arm.urdf", address, &mut read);
/// assert_eq!(found.as_deref(), Some("checkout/meshes/link.stl"));
/// ```
#[must_use]
pub fn own_package_path(
    description: &str,
    address: &str,
    read: &mut dyn FnMut(&str) -> Option<String>,
) -> Option<String> {
    let (_, named) = address
        .split_once("://")
        .filter(|(scheme, _)| matches!(*scheme, "package" | "model"))?;
    let (package, inside) = named.split_once('/').unwrap_or((named, ""));
    let mut folder = description;
    loop {
        folder = folder.rsplit_once('/')?.0;
        let text = read(&format!("{folder}/package.xml"));
        let root = text.and_then(|text| xml::read("package.xml", &text).ok());
        if root.is_some_and(|root| root.text_of("name") == Some(package)) {
            return Some(format!("{folder}/{inside}"));
        }
    }
}
