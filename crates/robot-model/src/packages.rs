//! Where the files of packages are: `package://` of ROS and `model://` of Gazebo.

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
