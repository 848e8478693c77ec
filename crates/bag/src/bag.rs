//! A bag, scanned once: topics, stamps, and where each image lies.

use std::path::{Path, PathBuf};

use crate::choice::names;
use crate::error::BagError;
use crate::image::Picture;
use crate::messages::{self, CameraInfo, PackedImage, RawImage, StampedTransform};
use crate::metadata::{self, Files};
use crate::storage::{Place, Seen};
use crate::topic::{Kind, Topic};
use crate::wire::{Decoded, Wire};

/// An image's stamp and where it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Time of exposure, nanoseconds: the stamp of the header.
    pub t_ns: i64,
    place: Place,
}

/// Poses of one topic, in the order of the bag.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseStream(pub Vec<StampedTransform>);

/// A bag.
pub struct Bag {
    path: PathBuf,
    files: Files,
    topics: Vec<Topic>,
    /// Of each topic.
    contents: Vec<Content>,
    poses: PoseStream,
    remarks: Vec<String>,
}

/// What is kept of a topic's messages.
struct Content {
    /// How they are written.
    wire: Wire,
    /// Its images, by stamp once the scan is over.
    stamps: Vec<Stamp>,
    /// Its first `CameraInfo`.
    camera: Option<CameraInfo>,
}

/// What a scan has gathered.
#[derive(Default)]
struct Gathered {
    topics: Vec<Topic>,
    contents: Vec<Content>,
    poses: Vec<StampedTransform>,
    /// Messages that do not hold what their type says, and the first one's reason.
    unreadable: usize,
    first_reason: Option<String>,
}

impl Gathered {
    fn take(&mut self, seen: &Seen<'_>, pose_topic: Option<&str>) {
        let i = match self.topics.iter().position(|topic| topic.name == seen.topic) {
            Some(i) => i,
            None => {
                self.topics.push(Topic::new(seen.topic.to_owned(), seen.type_name.to_owned()));
                self.contents.push(Content { wire: seen.wire, stamps: Vec::new(), camera: None });
                self.topics.len() - 1
            }
        };
        match self.read(i, seen, pose_topic) {
            Ok(t_ns) => self.topics[i].count(t_ns),
            Err(reason) => {
                self.unreadable += 1;
                self.first_reason.get_or_insert_with(|| format!("{}: {reason}", seen.topic));
            }
        }
    }

    /// Keeps what a message is needed for; returns its stamp.
    fn read(&mut self, i: usize, seen: &Seen<'_>, pose_topic: Option<&str>) -> Decoded<i64> {
        let Seen { wire, data, place, .. } = *seen;
        let kind = self.topics[i].kind;
        match kind {
            Kind::Image | Kind::CompressedImage => {
                let t_ns = messages::header_stamp(data, wire)?;
                if self.topics[i].encoding.is_none() {
                    self.describe(i, data, wire)?;
                }
                self.contents[i].stamps.push(Stamp { t_ns, place });
                Ok(t_ns)
            }
            Kind::CameraInfo => {
                if self.contents[i].camera.is_none() {
                    self.contents[i].camera = Some(CameraInfo::of(data, wire)?);
                }
                messages::header_stamp(data, wire)
            }
            Kind::Imu => messages::header_stamp(data, wire),
            _ if kind.has_poses() && pose_topic == Some(seen.topic) => {
                if kind == Kind::Transforms {
                    self.poses.extend(messages::transforms(data, wire)?);
                } else {
                    self.poses.push(messages::stamped_pose(data, wire, kind != Kind::PoseStamped)?);
                }
                Ok(self.poses.last().map_or(seen.log_ns, |pose| pose.t_ns))
            }
            _ => Ok(seen.log_ns),
        }
    }

    /// Encoding and size of a topic's images, by its first one.
    fn describe(&mut self, i: usize, data: &[u8], wire: Wire) -> Decoded<()> {
        let topic = &mut self.topics[i];
        if topic.kind == Kind::Image {
            let image = RawImage::of(data, wire)?;
            (topic.encoding, topic.size) = (Some(image.encoding), Some((image.width, image.height)));
        } else {
            topic.encoding = Some(PackedImage::of(data, wire)?.format);
        }
        Ok(())
    }
}

impl Bag {
    /// Goes through a bag: a file or a rosbag2 folder. Poses are kept of the topic `pose_topic`.
    ///
    /// # Errors
    /// A path that is not a bag, or cannot be read; a topic without poses.
    pub fn open(path: &Path, pose_topic: Option<&str>) -> Result<Self, BagError> {
        let mut files = metadata::open(path)?;
        let mut gathered = Gathered::default();
        let mut remarks = std::mem::take(&mut files.remarks);
        for (n, storage) in files.storages.iter_mut().enumerate() {
            let file = u16::try_from(n).unwrap_or(u16::MAX);
            let remark = storage.scan(&mut |mut seen: Seen<'_>| {
                seen.place.file = file;
                gathered.take(&seen, pose_topic);
            })?;
            remarks.extend(remark);
        }
        let Gathered { topics, mut contents, poses, unreadable, first_reason } = gathered;
        if let Some(name) = pose_topic
            && !topics.iter().any(|topic| topic.name == name && topic.kind.has_poses())
        {
            let known = names(topics.iter().filter(|topic| topic.kind.has_poses()));
            return Err(BagError::NoPoses { path: path.to_path_buf(), name: name.to_owned(), known });
        }
        if let Some(reason) = first_reason {
            remarks.push(format!(
                "{}: {unreadable} messages cannot be read; the first one: {reason}",
                path.display()
            ));
        }
        for (Content { stamps, .. }, topic) in contents.iter_mut().zip(&topics) {
            stamps.sort_by_key(|stamp| stamp.t_ns);
            let n = stamps.len();
            stamps.dedup_by_key(|stamp| stamp.t_ns);
            if stamps.len() < n {
                remarks.push(format!(
                    "{}: {} messages repeat the stamp of another one and are left out",
                    topic.name,
                    n - stamps.len()
                ));
            }
        }
        let poses = PoseStream(poses);
        Ok(Self { path: path.to_path_buf(), files, topics, contents, poses, remarks })
    }

    /// File or folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The topics, in the order of their first messages.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// Images of a topic, by stamp.
    pub fn stamps(&self, topic: usize) -> &[Stamp] {
        &self.contents[topic].stamps
    }

    /// The `CameraInfo` beside an image topic: that of the same folder of names.
    pub fn camera_of(&self, image_topic: usize) -> Option<&CameraInfo> {
        let mut folder = self.topics[image_topic].name.as_str();
        while let Some((parent, _)) = folder.rsplit_once('/') {
            let wanted = format!("{parent}/camera_info");
            let at =
                self.topics.iter().position(|topic| topic.name == wanted && topic.kind == Kind::CameraInfo);
            if let Some(at) = at {
                return self.contents[at].camera.as_ref();
            }
            folder = parent;
        }
        None
    }

    /// The poses of the topic that was asked for.
    pub fn poses(&self) -> &PoseStream {
        &self.poses
    }

    /// What there is to say about the bag: where it is broken, and what was left out.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Reads an image; `wants_depth` tells how 16-bit values are meant.
    ///
    /// # Errors
    /// A file that has changed, or a message that is not an image.
    pub fn image(&mut self, topic: usize, stamp: Stamp, wants_depth: bool) -> Result<Picture, BagError> {
        let Stamp { t_ns, place } = stamp;
        let name = || self.topics[topic].name.clone();
        let Some(storage) = self.files.storages.get_mut(usize::from(place.file)) else {
            return Err(BagError::Message { topic: name(), t_ns, reason: "its file is gone".to_owned() });
        };
        let bytes = storage.read(place)?;
        let picture = Picture::of(&bytes, self.contents[topic].wire, self.topics[topic].kind, wants_depth);
        picture.map_err(|reason| BagError::Message { topic: name(), t_ns, reason })
    }
}

impl std::fmt::Debug for Bag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bag")
            .field("path", &self.path)
            .field("topics", &self.topics.len())
            .finish_non_exhaustive()
    }
}
