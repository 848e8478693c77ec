//! `dsslam inspect vocab`: trained on rendered images, described, converted there and back; faults are named.

use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::program::{Call, command, dsslam, ended, text};
use crate::root;
use crate::sequence::{Copy, rendered};

fn train(images: &[&str], out: &Path, further: &[&str]) -> Call {
    let mut args = vec!["inspect", "vocab", "train", "-k", "6", "-l", "3", "--keep", "200", "-o", text(out)];
    args.extend(further);
    args.extend(images);
    dsslam(&args)
}

fn sha256(path: &Path) -> String {
    Sha256::digest(fs::read(path).unwrap()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The row of `dsslam inspect vocab info` that begins with this word.
#[track_caller]
fn row<'a>(call: &'a Call, name: &str) -> &'a str {
    let row = call.stdout.lines().find_map(|line| line.strip_prefix(name));
    row.unwrap_or_else(|| panic!("no row {name} in {call}")).trim()
}

#[test]
fn a_vocabulary_is_trained_described_and_converted() {
    let copy = Copy::of_first(4);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (left, right) = (copy.file("image_0"), copy.file("image_1/000002.png"));
    let trained = train(&[&left, &right], &at("new/a.dbow"), &[]);
    trained.expect_success();
    let info = dsslam(&["inspect", "vocab", "info", text(&at("new/a.dbow"))]);
    assert_eq!((info.code, &info.stdout), (0, &trained.stdout), "{info}");
    assert_eq!((row(&info, "branching"), row(&info, "levels")), ("6", "3"));
    let origin = row(&info, "trained on");
    assert!(origin.starts_with("5 images, ") && origin.ends_with(" descriptors, seed 0"), "{info}");
    assert!(row(&info, "SHA-256").starts_with(&sha256(&at("new/a.dbow"))), "{info}");

    // Text forgets the origin, so two ways that both went through it are compared.
    for (from, to) in [("new/a.dbow", "b.txt"), ("b.txt", "c.dbow"), ("c.dbow", "d.TXT")] {
        let call = dsslam(&["inspect", "vocab", "convert", text(&at(from)), text(&at(to))]);
        call.expect_success();
        assert_eq!(row(&call, "words"), row(&info, "words"));
    }
    assert_eq!(fs::read(at("b.txt")).unwrap(), fs::read(at("d.TXT")).unwrap());
    assert_eq!(row(&dsslam(&["inspect", "vocab", "info", text(&at("b.txt"))]), "format"), "ORB-SLAM2 text");
    assert_eq!(row(&dsslam(&["inspect", "vocab", "info", text(&at("c.dbow"))]), "trained on"), "unknown");
}

#[test]
fn equal_input_gives_equal_bytes_for_any_number_of_threads() {
    let copy = Copy::of_first(3);
    let folder = tempfile::tempdir().unwrap();
    let images = copy.file("image_0");
    let bytes = |threads: &str, seed: &str| {
        let out = folder.path().join(format!("{threads}-{seed}.dbow"));
        let args =
            ["inspect", "vocab", "train", &images, "-k", "5", "-l", "2", "--seed", seed, "-o", text(&out)];
        ended(command(&args).env("RAYON_NUM_THREADS", threads).output().unwrap()).expect_success();
        fs::read(out).unwrap()
    };
    assert_eq!(bytes("1", "0"), bytes("4", "0"));
    assert_ne!(bytes("1", "0"), bytes("1", "1"), "the seed is used");
}

#[test]
fn the_vocabulary_of_the_program_is_the_one_in_the_repository() {
    let info = dsslam(&["inspect", "vocab", "info"]);
    info.expect_success();
    let sha256 = sha256(&root().join("vocab/orb.dbow"));
    assert!(row(&info, "SHA-256").starts_with(&sha256), "{info}");
    let readme = fs::read_to_string(root().join("vocab/README.md")).unwrap();
    assert!(readme.contains(&sha256), "vocab/README.md does not state {sha256}");
}

#[test]
fn images_that_give_no_vocabulary_are_named() {
    let copy = Copy::of_first(2);
    let out = copy.path().join("v.dbow");
    let call = |images: &str| train(&[images], &out, &[]);
    let empty = copy.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let empty = text(&empty);
    call(empty).expect(2, &format!("error: {empty}: no images found, expected .png, .jpg or .jpeg files"));
    call("/nowhere.png").expect(2, "error: /nowhere.png: no such image");
    copy.write("image_0/000001.png", b"no image at all");
    let broken = copy.file("image_0/000001.png");
    let begins = "not an image: begins with";
    let call = call(&copy.file("image_0"));
    let line = format!("error: {broken}: {begins}");
    assert!(call.code == 2 && call.stderr.lines().any(|l| l.starts_with(&line)), "no {line} in {call}");
    assert!(!out.exists(), "nothing is written when an image is broken");
}

#[test]
fn options_out_of_range_are_refused() {
    let image = rendered().join("image_0/000000.png");
    for (further, part) in [
        (["-k", "1"], "1 is not in 2..=1000"),
        (["-l", "17"], "17 is not in 1..=16"),
        (["--keep", "10"], "10 is not in 50..=100000"),
    ] {
        let args =
            ["inspect", "vocab", "train", text(&image), "-o", "/tmp/never.dbow", further[0], further[1]];
        let call = dsslam(&args);
        assert!(call.code == 2 && call.stderr.contains(part), "no {part} in {call}");
    }
}

#[test]
fn a_file_that_is_no_vocabulary_and_one_that_cannot_be_written_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.dbow");
    let file = text(&path);
    let info = || dsslam(&["inspect", "vocab", "info", file]);
    info().expect(2, &format!("error: {file}: cannot be read: No such file or directory (os error 2)"));
    let expected = "expected a DSSLAM vocabulary or ORB-SLAM2's text format";
    fs::write(&path, "%YAML").unwrap();
    info().expect(2, &format!("error: {file}: not a vocabulary: found \"%YAML\", {expected}"));
    let built_in = root().join("vocab/orb.dbow");
    let bytes = fs::read(&built_in).unwrap();
    fs::write(&path, &bytes[..1000]).unwrap();
    info().expect(2, &format!("error: {file}: truncated: found 1000 bytes, expected {}", bytes.len()));
    let call = dsslam(&["inspect", "vocab", "convert", text(&built_in), "/proc/none/v.txt"]);
    call.expect(3, "error: /proc/none/v.txt: cannot be written: No such file or directory (os error 2)");
}
