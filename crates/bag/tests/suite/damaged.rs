//! Bags that end early, are broken, or are something else. Nothing panics; what can be read is read, and it is said how far.

use std::fs;
use std::path::Path;

use dsslam_bag::Bag;

use super::kinds::drive;
use super::written::{Message, mcap, ros1};

/// Images that can be read, and what is said.
fn read(path: &Path) -> Result<(usize, Vec<String>), String> {
    let bag = Bag::open(path, None).map_err(|error| error.to_string())?;
    let n = bag.topics().iter().filter(|topic| topic.kind.is_image()).map(|topic| topic.count).sum();
    Ok((n, bag.remarks().to_vec()))
}

#[test]
fn a_bag_cut_anywhere_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let (whole_mcap, whole_ros1) = (folder.path().join("a.mcap"), folder.path().join("a.bag"));
    mcap(&whole_mcap, &drive(), None);
    ros1(&whole_ros1, &drive(), ("none", <[u8]>::to_vec));
    for whole in [whole_mcap, whole_ros1] {
        let bytes = fs::read(&whole).unwrap();
        let cut = folder.path().join("cut");
        let mut last = 0;
        for length in (20..bytes.len()).step_by(7) {
            fs::write(&cut, &bytes[..length]).unwrap();
            let (n, remarks) = read(&cut).unwrap();
            assert!(n >= last, "a longer file holds no less");
            // A ROS 1 bag may end after any record.
            assert!(
                n == 20 || !remarks.is_empty() || whole.ends_with("a.bag"),
                "{length} bytes: nothing is said"
            );
            last = n;
        }
        assert_eq!((last >= 17, read(&whole).unwrap()), (true, (20, Vec::new())));
    }
}

#[test]
fn changed_bytes_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("a.bag");
    for make in [(|path: &Path| mcap(path, &drive(), None)) as fn(&Path), |path: &Path| {
        ros1(path, &drive(), ("none", <[u8]>::to_vec))
    }] {
        make(&whole);
        let bytes = fs::read(&whole).unwrap();
        let changed = folder.path().join("changed");
        for at in (14..bytes.len().min(4000)).step_by(11) {
            for value in [0, 0xff, bytes[at] ^ 0x41] {
                let mut other = bytes.clone();
                other[at] = value;
                fs::write(&changed, &other).unwrap();
                let Ok(mut bag) = Bag::open(&changed, None) else { continue };
                for topic in 0..bag.topics().len() {
                    for stamp in bag.stamps(topic).to_vec() {
                        let _ = bag.image(topic, stamp, false);
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_not_a_bag_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.bag");
    for (bytes, found) in
        [(&b""[..], "found an empty file"), (b"#ROSBAG V1.2\nxx", "begins with \"#ROSBAG V1.2\\nxx\"")]
    {
        fs::write(&file, bytes).unwrap();
        let error = read(&file).unwrap_err();
        assert!(error.contains(found) && error.contains("x.bag"), "{error}");
    }
    let error = read(&folder.path().join("none.bag")).unwrap_err();
    assert!(error.contains("No such file"), "{error}");
    let empty = tempfile::tempdir().unwrap();
    assert!(read(empty.path()).unwrap_err().contains("a folder without bag files"));
}

#[test]
fn a_missing_file_of_a_folder_and_a_broken_list_are_told() {
    let folder = tempfile::tempdir().unwrap();
    mcap(&folder.path().join("a.mcap"), &drive(), None);
    let list = folder.path().join("metadata.yaml");
    fs::write(&list, "rosbag2_bagfile_information:\n  relative_file_paths: [a.mcap, b.mcap]\n").unwrap();
    let (n, remarks) = read(folder.path()).unwrap();
    assert_eq!((n, remarks.len()), (20, 1));
    assert!(remarks[0].ends_with("b.mcap: missing, although metadata.yaml names it"));
    fs::write(&list, "{ broken").unwrap();
    let (n, remarks) = read(folder.path()).unwrap();
    assert!(n == 20 && remarks[0].ends_with("the files are taken by name"), "{remarks:?}");
}

#[test]
fn repeated_stamps_and_broken_images_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mcap");
    let image = |t_ns, bytes| Message::image("/a", t_ns, 8, 6, vec![1; bytes]);
    mcap(&file, &[image(5, 48), image(5, 48), image(6, 30)], None);
    let mut bag = Bag::open(&file, None).unwrap();
    assert_eq!(bag.remarks(), ["/a: 1 messages repeat the stamp of another one and are left out"]);
    let stamps = bag.stamps(0).to_vec();
    assert_eq!(stamps.len(), 2);
    assert!(bag.image(0, stamps[0], false).is_ok());
    assert_eq!(
        bag.image(0, stamps[1], false).unwrap_err().to_string(),
        "/a: message at 6 ns: an image of 8 x 6 pixels with rows of 5 bytes, which needs at least 48 bytes, and has 30"
    );
    let depth = bag.image(0, stamps[0], true).unwrap_err().to_string();
    assert_eq!(depth, "/a: message at 5 ns: depth with encoding mono8, expected 16UC1 or 32FC1");
}
