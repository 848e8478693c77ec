//! Files: opened by content, written whole, errors that name them.

use super::support::{images, small_vocabulary};
use dsslam_bow::tool::{self, Format, Info, convert, open, open_with_format, save};
use dsslam_bow::{Vocabulary, VocabularyError};
use features::ExtractorConfig;
use geometry::Raster;
use std::fs;
use std::path::Path;

#[test]
fn conversion_there_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Once through text, which forgets the origin: then both directions keep everything.
    let vocabulary = Vocabulary::from_text(&small_vocabulary().to_text()).unwrap();
    save(&vocabulary, &at("a.dbow"), Format::Binary).unwrap();
    let done = convert(&at("a.dbow"), &at("b.txt")).unwrap();
    assert_eq!((done.from, done.to), (Format::Binary, Format::Text));
    assert_eq!(done.info, Info::of(&vocabulary));
    let done = convert(&at("b.txt"), &at("c.dbow")).unwrap();
    assert_eq!((done.from, done.to), (Format::Text, Format::Binary));
    assert_eq!(fs::read(at("a.dbow")).unwrap(), fs::read(at("c.dbow")).unwrap());
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.dbow", "b.txt", "c.dbow"], "no temporary file is left");
}

#[test]
fn the_format_is_told_by_the_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("vocabulary.dat");
    for format in [Format::Text, Format::Binary] {
        save(&small_vocabulary(), &path, format).unwrap();
        let (vocabulary, found) = open_with_format(&path).unwrap();
        assert_eq!(found, format);
        assert_eq!(vocabulary.n_words(), small_vocabulary().n_words());
    }
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.dbow");
    let name = path.display();
    assert!(matches!(open(&path), Err(VocabularyError::Unreadable { .. })));
    let message = |content: &[u8]| {
        fs::write(&path, content).unwrap();
        open(&path).unwrap_err().to_string()
    };
    let neither = "expected a DSSLAM vocabulary or ORB-SLAM2's text format";
    assert_eq!(message(b""), format!("{name}: not a vocabulary: found nothing, {neither}"));
    assert_eq!(message(b"\x7fELF"), format!("{name}: not a vocabulary: found \"\\x7fELF\", {neither}"));
    let expected = "expected levels from 1 to 16";
    assert_eq!(message(b"10\n"), format!("{name}: line 1: found the end of the line, {expected}"));
    assert_eq!(message(b"10 6 0 0\n0 1 \xff"), format!("{name}: line 2: found \"\\xff\", expected text"));
    let bytes = small_vocabulary().as_bytes().to_vec();
    let cut = message(&bytes[..100]);
    assert_eq!(cut, format!("{name}: truncated: found 100 bytes, expected {}", bytes.len()));
    let nowhere = folder.path().join("missing").join("v.dbow");
    let error = save(&small_vocabulary(), &nowhere, Format::Binary).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{}: cannot be written: ", nowhere.display())), "{error}");
}

#[test]
fn a_failed_conversion_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let (bad, good) = (folder.path().join("bad.txt"), folder.path().join("good.dbow"));
    save(&small_vocabulary(), &good, Format::Binary).unwrap();
    fs::write(&bad, "10 6 0 0\n0 1 7").unwrap();
    assert!(convert(&bad, &good).is_err());
    assert_eq!(open(&good).unwrap(), small_vocabulary());
}

#[test]
fn a_file_in_use_can_be_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.dbow");
    save(&small_vocabulary(), &path, Format::Binary).unwrap();
    let opened = open(&path).unwrap();
    let other = dsslam_bow::train(&images(3, 50, 10, 7), &super::support::options(2, 2)).unwrap();
    save(&other, &path, Format::Binary).unwrap();
    assert_eq!(opened, small_vocabulary());
    assert_eq!(open(&path).unwrap(), other);
}

#[test]
fn info_of_the_built_in_vocabulary() {
    let vocabulary = Vocabulary::built_in().unwrap();
    let info = Info::of(&vocabulary);
    assert_eq!((info.branching, info.levels), (10, 5));
    assert_eq!(info.words_by_level.iter().sum::<u32>(), info.n_words);
    assert!(info.n_bytes < 10_000_000, "{} bytes", info.n_bytes);
    assert!(info.n_words > 50_000 && info.weight_range.0 > 0.0);
    assert!(info.to_string().starts_with("branching    10\nlevels       5\nnodes        "));
    assert_eq!(Format::of_name(Path::new("ORBvoc.txt")), Format::Text);
    assert_eq!(Format::of_name(Path::new("orb.dbow")), Format::Binary);
}

#[test]
fn images_are_described_in_order_and_the_first_error_wins() {
    let config = ExtractorConfig { keep: 50, ..ExtractorConfig::default() };
    let image = |i: usize| {
        let pixel = |x: usize, y: usize| ((x / 9 * 31 + y / 9 * 17) * (i + 3) % 251) as u8;
        let data = (0..120 * 160).map(|p| pixel(p % 160, p / 160)).collect();
        Raster::from_vec(160, 120, data).unwrap()
    };
    let described = tool::describe_images(8, &config, |i| Ok::<_, usize>(image(i))).unwrap();
    for (i, descriptors) in described.iter().enumerate() {
        let alone = features::Extractor::new(config.clone()).extract(&image(i)).descriptors;
        assert!(!alone.is_empty());
        assert_eq!(descriptors, &alone);
    }
    let failed = tool::describe_images(8, &config, |i| if i >= 3 { Err(i) } else { Ok(image(i)) });
    assert_eq!(failed.unwrap_err(), 3);
}

#[test]
fn folders_stand_for_their_images() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("b")).unwrap();
    for name in ["z.png", "a.JPG", "notes.txt", "b/2.jpeg", "b/1.png", "b/times"] {
        fs::write(at(name), "").unwrap();
    }
    let found = tool::find_images(&[at("z.png"), folder.path().to_path_buf(), at("anything")]).unwrap();
    assert_eq!(found, ["z.png", "a.JPG", "b/1.png", "b/2.jpeg", "z.png", "anything"].map(at));
    assert!(tool::find_images(&[]).unwrap().is_empty());
}
