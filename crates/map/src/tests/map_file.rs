//! Map files: what goes in comes out, and goes on as before; anything else is refused with the reason.

use std::sync::Arc;

use geometry::Sensor;
use proptest::prelude::*;
use rand::Rng;
use sha2::{Digest, Sha256};

use super::random_mutations::{random_map, random_step};
use super::world::*;
use crate::file::{FORMAT_VERSION, decode, encode};
use crate::{Batch, KeyframeId, Map, MapFileError, MapFileInfo, NewKeyframe, PointId};

fn info() -> MapFileInfo {
    MapFileInfo {
        sensor: Some(Sensor::Stereo),
        program_version: "1.2.3".to_owned(),
        sequence: "Straße \"06\"".to_owned(),
        configuration: "orb:\n  features: 2000\n".to_owned(),
        vocabulary_sha256: String::new(),
        body_from_left: "1 0 0 0.5 0 1 0 0 0 0 1 0".to_owned(),
        stamps_ns: vec![1_403_636_579_763_555_584],
    }
}

/// A small map with removed, merged and forwarded things, a scale and two sub-maps.
fn small_map() -> Map {
    let mut map = random_map(5, 120);
    let points: Vec<PointId> = map.points().map(|p| p.id).collect();
    map.merge_points(points[0], points[points.len() - 1]).unwrap();
    map
}

/// Closes bytes with a right checksum again.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let header = Sha256::digest(&bytes[..32]);
    bytes[32..40].copy_from_slice(&header[..8]);
    let end = bytes.len() - 32;
    let seal = Sha256::digest(&bytes[..end]);
    bytes[end..].copy_from_slice(&seal);
    bytes
}

/// A file of this content, as a program with a defect would write it.
fn file_of_content(content: &[u8]) -> Vec<u8> {
    let mut bytes = encode(&Map::new(), &MapFileInfo::default());
    let info_len = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    bytes.truncate(40 + info_len);
    let stored = zstd::bulk::compress(content, 1).unwrap();
    bytes[16..24].copy_from_slice(&(stored.len() as u64).to_le_bytes());
    bytes[24..32].copy_from_slice(&(content.len() as u64).to_le_bytes());
    bytes.extend(stored);
    bytes.extend([0; 32]);
    sealed(bytes)
}

/// The unpacked content of a map's file.
fn content_of(map: &Map) -> Vec<u8> {
    let bytes = encode(map, &MapFileInfo::default());
    let info_len = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    zstd::stream::decode_all(&bytes[40 + info_len..bytes.len() - 32]).unwrap()
}

#[track_caller]
fn expect_error(bytes: &[u8], message: &str) {
    assert_eq!(decode(bytes).expect_err("refused").to_string(), message);
}

#[test]
fn a_map_comes_back_as_it_was() {
    let map = small_map();
    assert!(map.roots().len() > 1 && map.n_keyframes() < map.next_keyframe_id().0 as usize);
    let bytes = encode(&map, &info());
    let (back, told) = decode(&bytes).unwrap();
    assert_eq!((back.digest(), back.revision()), (map.digest(), map.revision()));
    assert_eq!(told, info());
    assert_eq!(encode(&back, &told), bytes, "and is written as the same bytes");
    for (a, b) in map.keyframes().zip(back.keyframes()) {
        assert_eq!((a.inserted_at, a.frame.rig.clone()), (b.inserted_at, b.frame.rig.clone()));
        assert_eq!(a.frame.bounds(), b.frame.bounds());
    }
    assert_eq!((map.first_young.clone(), map.roots()), (back.first_young.clone(), back.roots()));
}

#[test]
fn an_empty_map_comes_back_and_can_be_filled() {
    let (mut back, _) = decode(&encode(&Map::new(), &info())).unwrap();
    assert_eq!((back.digest(), back.revision(), back.roots()), (Map::new().digest(), 0, &[][..]));
    assert_eq!(add(&mut back, &[], &[&[(0, 0)]]), KeyframeId(0));
}

#[test]
fn frames_keep_depth_activation_and_camera_and_share_what_they_shared() {
    let mut map = Map::new();
    let mut random = generator(3);
    for i in 0..6_u32 {
        let mut frame = (*frame(i)).clone();
        if i >= 4 {
            Arc::make_mut(&mut frame.rig).distortion.k1 = -0.1;
        }
        if i >= 2 {
            let right_u = frame.keypoints.iter().map(|k| k.x - random.random_range(0.0..50.0)).collect();
            let (keypoints, descriptors) = (frame.keypoints, frame.descriptors);
            let features = features::Features { keypoints, descriptors };
            frame = features::Frame::new(i, 1e9 + 0.1, frame.rig, frame.scales, features, right_u);
        }
        if i >= 4 {
            frame.depth.iter_mut().step_by(3).for_each(|d| *d *= 1.5); // measured, not what the disparity says
            frame.activation.iter_mut().chain(&mut frame.lasting).for_each(|a| *a = random.random());
        }
        let keyframe = NewKeyframe { frame: Arc::new(frame), ..new_keyframe(&map, &[]) };
        map.insert(Batch { keyframe: Some(keyframe), points: vec![] }).unwrap();
    }
    let (back, _) = decode(&encode(&map, &info())).unwrap();
    assert_eq!(back.digest(), map.digest());
    let rig = |k: u32| &back.keyframe(KeyframeId(k)).unwrap().frame.rig;
    assert!(Arc::ptr_eq(rig(0), rig(3)) && Arc::ptr_eq(rig(4), rig(5)) && !Arc::ptr_eq(rig(3), rig(4)));
    let scales = |k: u32| &back.keyframe(KeyframeId(k)).unwrap().frame.scales;
    assert!((1..6).all(|k| Arc::ptr_eq(scales(0), scales(k))));
    let bounds = |m: &Map| m.keyframe(KeyframeId(5)).unwrap().frame.bounds();
    assert_eq!(bounds(&back), bounds(&map));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Through any history: the map that was read and the one that was written stay equal under the same mutations.
    #[test]
    fn mutations_go_on_as_before(seed in any::<u64>(), n_before in 0_u64..100, n_after in 1_u64..60) {
        let mut map = random_map(seed, n_before);
        let (mut back, _) = decode(&encode(&map, &info())).unwrap();
        prop_assert_eq!(back.digest(), map.digest());
        for i in 0..n_after {
            let results = [&mut map, &mut back].map(|m| random_step(m, seed ^ 1, i));
            prop_assert_eq!(results[0], results[1]);
        }
        prop_assert_eq!((back.digest(), back.revision()), (map.digest(), map.revision()));
        let ids = |m: &Map| (m.next_keyframe_id(), m.next_point_id());
        prop_assert_eq!(ids(&back), ids(&map));
    }
}

#[test]
fn every_changed_byte_is_noticed() {
    let bytes = encode(&small_map(), &info());
    let mut random = generator(11);
    for i in 0..1_000 {
        let mut changed = bytes.clone();
        // Every byte of the header and some of the rest.
        let at = if i < 200 { i } else { random.random_range(0..bytes.len()) };
        changed[at] ^= random.random_range(1..=255_u8);
        assert!(decode(&changed).is_err(), "byte {at}");
    }
}

#[test]
fn every_missing_end_is_noticed() {
    let bytes = encode(&small_map(), &info());
    let mut random = generator(12);
    let n = bytes.len();
    let lengths = (1..100).chain(n - 100..n).chain((0..800).map(|_| random.random_range(1..n)));
    for length in lengths {
        let expected = if length < 40 { 40 } else { n as u64 };
        let truncated = MapFileError::Truncated { found: length as u64, expected };
        assert_eq!(decode(&bytes[..length]).err(), Some(truncated));
    }
    expect_error(&bytes[..9], "truncated map file: has 9 bytes, 40 expected");
    let longer = [&bytes[..], &[0]].concat();
    assert_eq!(
        decode(&longer).err(),
        Some(MapFileError::TooLong { found: n as u64 + 1, expected: n as u64 })
    );
}

#[test]
fn foreign_files_are_named() {
    let ending = "expected a file that begins with `DSMAP`";
    expect_error(&[], &format!("not a map file: the file is empty, {ending}"));
    expect_error(b"%YAML:1.0\n", &format!("not a map file: it begins with `%YAML:1.`, {ending}"));
    expect_error(&[0x89, b'P', b'N'], &format!("not a map file: it begins with `\\x89PN`, {ending}"));
    // A transfer as text has turned the line end.
    expect_error(
        b"DSMAP\0\n\x01\0\0\0",
        &format!("not a map file: it begins with `DSMAP\\x00\\n\\x01`, {ending}"),
    );
}

#[test]
fn a_damaged_file_says_which_part() {
    let mut bytes = encode(&small_map(), &info());
    bytes[60] ^= 1;
    let message = decode(&bytes).unwrap_err().to_string();
    assert!(message.starts_with("damaged map file: checksum of the file is "), "{message}");
    bytes[9] ^= 1;
    let message = decode(&bytes).unwrap_err().to_string();
    assert!(message.starts_with("damaged map file: checksum of the header is "), "{message}");
}

#[test]
fn a_newer_version_is_refused_as_such() {
    let mut bytes = encode(&small_map(), &info());
    for version in [FORMAT_VERSION + 1, u32::MAX, 1, 0] {
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        let message = format!("map file has format version {version}, this program reads versions 2 to 3");
        expect_error(&sealed(bytes.clone()), &message);
        // The length is not looked at before the version.
        expect_error(&sealed([&bytes[..], &[0]].concat()), &message);
    }
}

#[test]
fn a_file_from_before_loops_were_kept_is_a_map_without_them() {
    let map = (0..).map(|seed| random_map(seed, 60)).find(|map| map.loops().is_empty()).unwrap();
    let content = content_of(&map);
    let mut bytes = file_of_content(&content[..content.len() - 1]);
    bytes[8..12].copy_from_slice(&2_u32.to_le_bytes());
    let (read, _) = decode(&sealed(bytes)).unwrap();
    assert_eq!(read.digest(), map.digest());
}

#[test]
fn descriptions_of_other_programs_are_read_by_name() {
    let with_info = |json: &str| {
        let bytes = encode(&Map::new(), &MapFileInfo::default());
        let info_len = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let mut changed = bytes[..40].to_vec();
        changed[12..16].copy_from_slice(&(json.len() as u32).to_le_bytes());
        changed.extend(json.as_bytes());
        changed.extend(&bytes[40 + info_len..]);
        sealed(changed)
    };
    let (_, told) = decode(&with_info(r#"{"sensor": "mono", "made_with_love": true}"#)).unwrap();
    assert_eq!(told, MapFileInfo { sensor: Some(Sensor::Mono), ..MapFileInfo::default() });
    assert_eq!(decode(&with_info(r#"{"sensor": ""}"#)).unwrap().1, MapFileInfo::default());
    let message = decode(&with_info(r#"{"sensor": "lidar"}"#)).unwrap_err().to_string();
    let expected = "unreadable map file: description: found 'lidar', expected stereo, rgbd, mono";
    assert!(message.starts_with(expected), "{message}");
    let message = decode(&with_info(r#"{"sensor": 7}"#)).unwrap_err().to_string();
    assert!(message.starts_with("unreadable map file: description: invalid type: integer `7`"), "{message}");
}

#[test]
fn a_content_of_another_length_than_stated_is_refused() {
    let content = content_of(&small_map());
    let stated = |length: u64| {
        let mut bytes = file_of_content(&content);
        bytes[24..32].copy_from_slice(&length.to_le_bytes());
        sealed(bytes)
    };
    let n = content.len() as u64;
    assert!(decode(&stated(n)).is_ok());
    let differs = |word, n| format!("unreadable map file: content is {word} than the {n} bytes stated");
    expect_error(&stated(n - 1), &differs("longer", n - 1));
    expect_error(&stated(n + 1), &differs("shorter", n + 1));
    // More than can be packed: refused before memory is asked for.
    let message = decode(&stated(u64::MAX)).unwrap_err().to_string();
    assert!(message.ends_with(&format!("cannot hold a content of {}", u64::MAX)), "{message}");
    let mut longer = content.clone();
    longer.extend([0; 3]);
    expect_error(&file_of_content(&longer), "unreadable map file: 3 bytes behind the records");
    let message = decode(&file_of_content(&content[..content.len() / 2])).unwrap_err().to_string();
    assert!(message.starts_with("unreadable map file: records: "), "{message}");
}

#[test]
fn a_broken_map_with_right_checksums_is_refused_by_its_first_violation() {
    let (k, p) = (KeyframeId, PointId);
    let reread = |break_it: &dyn Fn(&mut Map)| {
        let mut map = row_of_keyframes(5);
        break_it(&mut map);
        decode(&encode(&map, &info())).expect_err("refused").to_string()
    };
    let expect = |what: &str, break_it: &dyn Fn(&mut Map)| {
        let found = reread(break_it);
        assert!(found.starts_with(&format!("inconsistent map in file: {what}")), "{found}");
    };
    expect("a number of point P2 is not finite", &|m| m.points.live_mut(p(2)).position.x = f64::NAN);
    expect("point P2 names keyframe K9, which does not exist (and 1 more)", &|m| {
        m.points.live_mut(p(2)).observations[1].keyframe = k(9);
    });
    expect("point P2 has an observation in feature 40 of keyframe K1", &|m| {
        m.points.live_mut(p(2)).observations[1].feature = 40;
    });
    expect("keyframe K1 is on or behind a cycle of the spanning tree", &|m| {
        m.keyframes.live_mut(k(1)).parent = Some(k(4));
    });
    expect("keyframe K1 was inserted at revision 9 of 5", &|m| m.keyframes.live_mut(k(1)).inserted_at = 9);
    expect("points from keyframe K3 on are noted to begin at Some(PointId(13))", &|m| {
        m.first_young[1] = p(13)
    });
    expect("loop edge from keyframe K1 to K2 has no counterpart", &|m| {
        m.keyframes.live_mut(k(1)).loop_edges.push(k(2));
    });
    expect("pose of keyframe K1 has no rotation", &|m| {
        m.keyframes.live_mut(k(1)).cam_from_world.rotation =
            geometry::SO3::from_matrix_unchecked(geometry::Mat3::identity() * 2.0);
    });
    let octave = |m: &mut Map| {
        Arc::make_mut(&mut m.keyframes.live_mut(k(1)).frame).keypoints[3].octave = 8;
    };
    let found = reread(&|m| octave(m));
    assert_eq!(found, "unreadable map file: keyframe K1 has a feature of octave 8, there are 8 levels");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Content that no program of ours writes, under right checksums: an error or a sound map, never a panic.
    #[test]
    fn garbage_under_right_checksums_is_no_danger(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut content = content_of(&row_of_keyframes(3));
        for (at, byte) in &changes {
            let at = at.index(content.len());
            content[at] = *byte;
        }
        if let Some(cut) = cut {
            content.truncate(cut.index(content.len()));
        }
        if let Ok((map, _)) = decode(&file_of_content(&content)) {
            prop_assert_eq!(map.check(), Ok(()));
        }
    }

    /// Bytes from nowhere.
    #[test]
    fn noise_is_refused(noise in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(decode(&noise).is_err());
        prop_assert!(decode(&file_of_content(&noise)).is_err());
    }
}
