//! Why a bag, or a message of it, cannot be used.

use std::path::PathBuf;

/// Why a bag, or a message of it, cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// The operating system does not let it be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
    /// The file is not a bag.
    #[error("{}: found {found}, expected a bag: an MCAP file, a ROS 1 bag (#ROSBAG V2.0), an SQLite file of rosbag2, or a folder with them", path.display())]
    NotABag {
        /// The file or folder.
        path: PathBuf,
        /// What it begins with, or holds.
        found: String,
    },
    /// The bag is broken where it has to be whole.
    #[error("{}: byte {at}: {reason}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// Where, bytes from the start; the row of a table in SQLite.
        at: u64,
        /// What is wrong.
        reason: String,
    },
    /// A message does not hold what its type says.
    #[error("{topic}: message at {t_ns} ns: {reason}")]
    Message {
        /// The topic.
        topic: String,
        /// Its stamp, nanoseconds.
        t_ns: i64,
        /// What is wrong.
        reason: String,
    },
    /// A topic that was asked for is not there.
    #[error("--topics: found no topic {name} for {role} in {}; its image topics are {known}", path.display())]
    NoTopic {
        /// The bag.
        path: PathBuf,
        /// What it was wanted for.
        role: &'static str,
        /// Its name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// No topic holds images.
    #[error("{}: found no topic with images, expected sensor_msgs/Image or CompressedImage; it holds {held}", path.display())]
    NoImages {
        /// The bag.
        path: PathBuf,
        /// The topics that there are.
        held: String,
    },
    /// The argument that names topics cannot be read.
    #[error(
        "--topics: found `{0}`, expected left=/topic, and right=/topic or depth=/topic, with commas between them"
    )]
    BadRoles(String),
    /// No topic with poses has that name.
    #[error("{}: found no topic {name} with poses, expected nav_msgs/Odometry, geometry_msgs/PoseStamped, TransformStamped or tf2_msgs/TFMessage; there are {known}", path.display())]
    NoPoses {
        /// The bag.
        path: PathBuf,
        /// The name.
        name: String,
        /// Topics with poses.
        known: String,
    },
}

impl BagError {
    /// What is said of a scan that this ended early, unless the file cannot be read at all.
    pub(crate) fn ends_scan(self) -> Result<String, BagError> {
        match self {
            BagError::Unreadable { .. } => Err(self),
            _ => Ok(format!("{self}; what follows is left out")),
        }
    }
}
