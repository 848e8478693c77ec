//! Which topics a run takes, where nobody names them.

use std::fmt;
use std::path::Path;

use geometry::Sensor;

use crate::error::BagError;
use crate::topic::Topic;

/// What an image topic is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The left or only image.
    Left,
    /// The right image.
    Right,
    /// Registered depth.
    Depth,
}

impl Role {
    fn word(self) -> &'static str {
        match self {
            Role::Left => "left",
            Role::Right => "right",
            Role::Depth => "depth",
        }
    }
}

/// Topics by role, as the user names them: `left=/cam0/image_raw,right=/cam1/image_raw`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles(Vec<(Role, String)>);

impl std::str::FromStr for Roles {
    type Err = BagError;

    fn from_str(text: &str) -> Result<Self, BagError> {
        let one = |part: &str| {
            let (role, topic) = part.split_once('=')?;
            let role = match role.trim() {
                "left" | "image" | "rgb" | "color" => Role::Left,
                "right" => Role::Right,
                "depth" => Role::Depth,
                _ => return None,
            };
            Some((role, topic.trim().to_owned()))
        };
        let roles: Option<Vec<_>> = text.split(',').map(one).collect();
        let roles = roles.filter(|roles| roles.iter().any(|(role, _)| *role == Role::Left));
        roles.map(Roles).ok_or_else(|| BagError::BadRoles(text.to_owned()))
    }
}

/// Positions of the chosen topics in [`crate::Bag::topics`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The left or only image.
    pub left: usize,
    /// The right image.
    pub right: Option<usize>,
    /// Depth.
    pub depth: Option<usize>,
}

impl Choice {
    /// The sensor that these topics are.
    pub fn sensor(&self) -> Sensor {
        match (self.right, self.depth) {
            (Some(_), _) => Sensor::Stereo,
            (None, Some(_)) => Sensor::Rgbd,
            (None, None) => Sensor::Mono,
        }
    }

    /// The same for another sensor, if its topics are there.
    #[must_use]
    pub fn as_sensor(self, sensor: Option<Sensor>) -> Self {
        match sensor {
            None => self,
            Some(Sensor::Stereo) => Self { depth: None, ..self },
            Some(Sensor::Rgbd) => Self { right: None, ..self },
            Some(Sensor::Mono) => Self { right: None, depth: None, ..self },
        }
    }
}

/// Names of topics as messages list them.
pub(crate) fn names<'a>(topics: impl Iterator<Item = &'a Topic>) -> String {
    let names: Vec<&str> = topics.map(|topic| topic.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Words of names that are the left and the right camera of a pair.
const PAIRS: [(&str, &str); 7] = [
    ("left", "right"),
    ("cam0", "cam1"),
    ("cam_0", "cam_1"),
    ("camera0", "camera1"),
    ("camera_0", "camera_1"),
    ("infra1", "infra2"),
    ("image_0", "image_1"),
];

/// Words of names of topics that a person looks at rather than a program.
const ASIDE: [&str; 4] = ["theora", "overlay", "debug", "annotated"];

/// The topics that `roles` names, else those that names and types suggest: a pair of cameras, an image with depth, or one camera. Topics
/// with more messages go first, raw ones before compressed ones, and earlier names before later ones.
///
/// # Errors
/// A topic that is not there, or a bag without images.
pub fn choose(path: &Path, topics: &[Topic], roles: Option<&Roles>) -> Result<Choice, BagError> {
    let images = || topics.iter().filter(|topic| topic.has_images());
    if let Some(Roles(roles)) = roles {
        let of = |wanted: Role| {
            let Some((role, name)) = roles.iter().find(|(role, _)| *role == wanted) else { return Ok(None) };
            let at = topics.iter().position(|topic| topic.name == *name && topic.has_images());
            let missing = || BagError::NoTopic {
                path: path.to_path_buf(),
                role: role.word(),
                name: name.clone(),
                known: names(images()),
            };
            at.map(Some).ok_or_else(missing)
        };
        let left = of(Role::Left)?.ok_or_else(|| BagError::BadRoles(String::new()))?;
        return Ok(Choice { left, right: of(Role::Right)?, depth: of(Role::Depth)? });
    }
    let mut ranked: Vec<usize> = (0..topics.len()).filter(|&i| topics[i].has_images()).collect();
    ranked.retain(|&i| !ASIDE.iter().any(|word| topics[i].name.contains(word)));
    ranked.sort_by_key(|&i| {
        let topic = &topics[i];
        (std::cmp::Reverse(topic.count), topic.kind != crate::topic::Kind::Image, topic.name.clone())
    });
    let is_depth = |i: usize| {
        let topic = &topics[i];
        let encoding = topic.encoding.as_deref().unwrap_or_default();
        encoding == "32FC1"
            || encoding.contains("compressedDepth")
            || (topic.name.contains("depth") && encoding != "mono8")
    };
    let (depths, colors): (Vec<usize>, Vec<usize>) = ranked.iter().partition(|&&i| is_depth(i));
    for &left in &colors {
        for (one, other) in PAIRS {
            if !topics[left].name.contains(one) {
                continue;
            }
            let partner = topics[left].name.replace(one, other);
            if let Some(&right) = colors.iter().find(|&&i| topics[i].name == partner) {
                return Ok(Choice { left, right: Some(right), depth: None });
            }
        }
    }
    let Some(&left) = colors.first() else {
        return Err(BagError::NoImages { path: path.to_path_buf(), held: names(topics.iter()) });
    };
    // Depth that is registered to the color image, where there are several.
    let aligned =
        depths.iter().find(|&&i| topics[i].name.contains("aligned") || topics[i].name.contains("registered"));
    Ok(Choice { left, right: None, depth: aligned.or(depths.first()).copied() })
}

impl fmt::Display for Roles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<String> =
            self.0.iter().map(|(role, topic)| format!("{}={topic}", role.word())).collect();
        f.write_str(&parts.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, kind: &str, encoding: &str, count: usize) -> Topic {
        Topic { encoding: Some(encoding.to_owned()), count, ..Topic::new(name.to_owned(), kind.to_owned()) }
    }

    fn chosen<'a>(topics: &'a [Topic], roles: Option<&str>) -> Result<Vec<&'a str>, String> {
        let roles = roles.map(|text| text.parse().unwrap());
        let choice = choose(Path::new("x.bag"), topics, roles.as_ref()).map_err(|error| error.to_string())?;
        let all = [Some(choice.left), choice.right, choice.depth];
        Ok(all.into_iter().flatten().map(|i| topics[i].name.as_str()).collect())
    }

    const IMAGE: &str = "sensor_msgs/msg/Image";

    #[test]
    fn a_pair_is_found_by_its_names() {
        let topics = [
            topic("/cam1/image_raw", IMAGE, "mono8", 9),
            topic("/cam0/image_raw", IMAGE, "mono8", 9),
            topic("/imu0", "sensor_msgs/Imu", "", 90),
        ];
        assert_eq!(chosen(&topics, None).unwrap(), ["/cam0/image_raw", "/cam1/image_raw"]);
    }

    #[test]
    fn color_goes_with_the_depth_that_is_registered_to_it() {
        let topics = [
            topic("/camera/color/image_raw", IMAGE, "rgb8", 30),
            topic("/camera/depth/image_rect_raw", IMAGE, "16UC1", 30),
            topic("/camera/aligned_depth_to_color/image_raw", IMAGE, "16UC1", 30),
            topic("/camera/color/image_raw/compressed", "sensor_msgs/CompressedImage", "jpeg", 30),
        ];
        let expected = ["/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"];
        assert_eq!(chosen(&topics, None).unwrap(), expected);
    }

    #[test]
    fn topics_can_be_named_and_wrong_names_get_the_list() {
        let topics = [topic("/a", IMAGE, "mono8", 3), topic("/b", IMAGE, "mono8", 3)];
        assert_eq!(chosen(&topics, Some("left=/b,right=/a")).unwrap(), ["/b", "/a"]);
        assert_eq!(
            chosen(&topics, Some("left=/c")).unwrap_err(),
            "--topics: found no topic /c for left in x.bag; its image topics are /a, /b"
        );
        for wrong in ["", "right=/a", "front=/a", "/a"] {
            assert!(wrong.parse::<Roles>().is_err(), "{wrong}");
        }
        let none = [topic("/imu0", "sensor_msgs/Imu", "", 90)];
        assert!(chosen(&none, None).unwrap_err().ends_with("it holds /imu0"));
    }
}
