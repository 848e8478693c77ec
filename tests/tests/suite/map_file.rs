//! A program that saves maps without pause is killed at random moments: the file is always the old map or the new one.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Kills per run.
const KILLS: u64 = 20;

/// The example of this package: `cargo test` builds it.
fn saver() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let saver = tests.ancestors().nth(2).unwrap().join("examples/map_file");
    assert!(saver.exists(), "{} is not built: cargo build -p dsslam-tests --examples", saver.display());
    saver
}

/// Starts saving, kills in the middle of it; returns the digests of the versions that are saved in turn.
fn save_and_kill(path: &Path, pause: Duration) -> Vec<u64> {
    let mut child = Command::new(saver())
        .arg("save")
        .arg(path)
        .stdout(Stdio::piped())
        .spawn()
        .expect("the example starts");
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let digests = lines.next().unwrap().unwrap();
    assert_eq!(lines.next().unwrap().unwrap(), "saved");
    std::thread::sleep(pause);
    child.kill().unwrap();
    child.wait().unwrap();
    digests.split(' ').map(|d| d.parse().unwrap()).collect()
}

/// Removes what killed programs left under temporary names; says how many there were.
fn remove_parts(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let parts: Vec<PathBuf> = entries.filter(|p| p.extension().is_some_and(|e| e == "part")).collect();
    parts.iter().for_each(|p| fs::remove_file(p).unwrap());
    parts.len()
}

#[test]
fn a_killed_program_leaves_the_old_map_or_the_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("street.dsmap");
    let mut n_found = [0; 2];
    let mut n_interrupted = 0;
    for kill in 0..KILLS {
        // Anywhere within some savings.
        let pause = Duration::from_micros(geometry::mix_seed(1, kill, 0) % 60_000);
        let digests = save_and_kill(&path, pause);
        let (map, _) =
            map::file::decode(&fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("kill {kill}: {e}"));
        let version = digests.iter().position(|&d| d == map.digest());
        n_found[version.expect("the digest of one of the versions")] += 1;
        n_interrupted += remove_parts(folder.path());
    }
    println!("found {n_found:?} of the two versions, {n_interrupted} of {KILLS} savings interrupted");
    assert!(n_interrupted > 0, "no kill came in the middle of saving");
}
