//! Definitions of ROS 2 types by name, for what carries none: a running system, old recordings.

use std::path::PathBuf;

use crate::reader::{ReadError, ReadProblem};
use crate::rosbag2::types::Definitions;

/// Definitions of types: the common ones whose fields are the same in all releases, and those of message files.
///
/// ```
/// let types = recording::TypeDefinitions::new(&[])?;
/// assert!(types.text("sensor_msgs/msg/JointState").is_some_and(|text| text.contains("velocity")));
/// assert_eq!(types.text("my_robot/msg/Unheard"), None);
/// # Ok::<(), recording::ReadError>(())
/// ```
#[derive(Debug)]
pub struct TypeDefinitions(Definitions);

impl TypeDefinitions {
    /// The known types, and those in the `.msg` files below `folders`, which go before.
    ///
    /// # Errors
    /// The folder or file that cannot be read.
    pub fn new(folders: &[PathBuf]) -> Result<Self, ReadError> {
        Definitions::with_folders(folders)
            .map(Self)
            .map_err(|(path, error)| ReadError::from(ReadProblem::Io(error)).in_file(&path))
    }

    /// The definition of `type_name` (`package/msg/Type`) and of all that it consists of, in the language `ros2msg`;
    /// `None` if one of them is not known.
    #[must_use]
    pub fn text(&self, type_name: &str) -> Option<String> {
        self.0.joined(type_name).ok()
    }
}
