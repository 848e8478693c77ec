//! The format: what is written is read, cut streams end, damage and other versions are named.

use geometry::Sensor;
use proptest::prelude::*;

use super::world::{row, start, tracked};
use crate::{
    ActivationMap, DeltaOptions, DeltaTracker, End, Ending, FeatureState, Features, FinalPose, Image, Level,
    Pose, ReadError, Record, StageTime, StreamReader, StreamWriter, Text,
};

/// One record of each kind.
fn records() -> Vec<Record> {
    let delta = DeltaTracker::new(DeltaOptions::default()).advance(&row(6), 25);
    let pose = Pose { rotation_xyzw: [0.0, 0.0, 0.0, 1.0], translation: [1.0, 2.0, 3.0] };
    vec![
        start(9, Sensor::Stereo),
        tracked(3, 0.5, Some(0), 0.0),
        Record::Features(Features {
            frame: 3,
            pixels: (0..300).map(|i| [i as f32, 2.5]).collect(),
            states: vec![FeatureState::Outlier; 300],
            activations: vec![200; 300],
        }),
        Record::Image(Image { frame: 3, size: [2, 1], jpeg: vec![0xff, 0xd8, 0, 1] }),
        Record::Activation(ActivationMap { frame: 3, size: [3, 1], values: vec![1, 2, 255] }),
        Record::Map(delta),
        Record::Stages { frame: 3, stages: vec![StageTime { name: "map".to_owned(), ms: 1.5 }] },
        Record::Text(Text { frame: None, level: Level::Warning, text: "lost".to_owned() }),
        Record::End(End {
            trajectory: vec![FinalPose { frame: 3, world_from_cam: pose, submap: Some(0) }],
            summary: "fine".to_owned(),
            left_out: 4,
        }),
    ]
}

fn written(records: &[Record]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = StreamWriter::new(&mut bytes).unwrap();
    records.iter().for_each(|record| writer.write(record).unwrap());
    let n_bytes = writer.n_bytes();
    assert_eq!(n_bytes, bytes.len() as u64);
    bytes
}

/// All records up to the end or an error, and how it ended.
fn read(bytes: &[u8]) -> (Vec<Record>, Result<Ending, ReadError>) {
    let mut records = Vec::new();
    let mut reader = match StreamReader::new(bytes) {
        Ok(reader) => reader,
        Err(error) => return (records, Err(error)),
    };
    loop {
        match reader.next_record() {
            Ok(Some(record)) => records.push(record),
            Ok(None) => return (records, Ok(reader.ending().unwrap())),
            Err(error) => return (records, Err(error)),
        }
    }
}

#[test]
fn every_kind_of_record_comes_back_as_it_was() {
    let (back, ending) = read(&written(&records()));
    assert_eq!(back, records());
    assert_eq!(ending.unwrap(), Ending::Whole);
}

#[test]
fn large_records_are_packed() {
    let features = &records()[2];
    assert!(written(std::slice::from_ref(features)).len() < 1800, "300 features of 10 bytes each");
}

#[test]
fn a_stream_that_was_cut_anywhere_keeps_what_was_whole() {
    let records = records();
    let bytes = written(&records);
    let mut ends: Vec<usize> = (0..=records.len()).map(|n| written(&records[..n]).len()).collect();
    for cut in 12..bytes.len() {
        let whole = ends.iter().rposition(|&end| end <= cut).unwrap();
        let (back, ending) = read(&bytes[..cut]);
        assert_eq!(back.len(), whole, "cut at {cut}");
        let expected = if ends[whole] == cut { Ending::Whole } else { Ending::CutOff };
        assert_eq!(ending.unwrap(), expected, "cut at {cut}");
    }
    ends.dedup();
    assert_eq!(ends.len(), records.len() + 1, "every record has bytes");
}

#[test]
fn other_files_and_other_versions_are_refused() {
    for bytes in [&b""[..], b"DSEVEN", b"DSEVENTX\x01\0\0\0", b"%PDF-1.4 and so on"] {
        let error = read(bytes).1.unwrap_err().to_string();
        assert_eq!(error, "not an event stream: it does not begin with DSEVENTS");
    }
    let error = read(b"DSEVENTS\x09\0\0\0").1.unwrap_err().to_string();
    assert_eq!(
        error,
        "the event stream has version 9, this program reads version 2: use the program that wrote it"
    );
}

#[test]
fn damage_is_named_with_its_place() {
    let first = written(&records()[..1]).len();
    let mut bytes = written(&records());
    bytes[first + 12] ^= 0x10;
    let (back, ending) = read(&bytes);
    assert_eq!(back.len(), 1, "what came before is good");
    let error = ending.unwrap_err().to_string();
    assert!(error.starts_with(&format!("the event stream is damaged at byte {first}: checksum ")), "{error}");

    let mut bytes = written(&records()[..1]);
    bytes.extend([0xff; 8]);
    let error = read(&bytes).1.unwrap_err().to_string();
    let expected = "a record of 4294967295 bytes, expected 1 to 268435456";
    assert_eq!(error, format!("the event stream is damaged at byte {first}: {expected}"));
}

proptest! {
    #[test]
    fn changed_bytes_never_panic_and_never_pass(at in 12_usize..4000, flip in 1_u8..=255) {
        let mut bytes = written(&records());
        let at = 12 + at % (bytes.len() - 12);
        bytes[at] ^= flip;
        let (back, ending) = read(&bytes);
        prop_assert!(back.len() < records().len());
        prop_assert!(!matches!(ending, Ok(Ending::Whole)));
        prop_assert_eq!(&back[..], &records()[..back.len()]);
    }
}
