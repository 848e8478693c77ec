//! Questions to the machine.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a program calls its version: the second word of what it prints.
pub(super) fn version_of(program: &Path) -> Option<String> {
    let output = Command::new(program).arg("--version").output().ok()?;
    String::from_utf8_lossy(&output.stdout).split_whitespace().nth(1).map(str::to_owned)
}

/// The processor's name, where `/proc` tells it.
pub(super) fn processor_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// The widest vector instructions that the program has kernels for.
pub(super) fn vector_instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        return "AVX2";
    }
    if cfg!(target_arch = "x86_64") {
        "SSE2"
    } else if cfg!(target_arch = "aarch64") {
        "NEON"
    } else {
        "no vector instructions"
    }
}

/// Sequences directly in a folder, or one and two levels below it.
pub(super) fn sequences_in(folder: &Path) -> usize {
    let is_sequence = |folder: &Path| io::open_sequence(folder, None).is_ok();
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let entries = folder.read_dir().into_iter().flatten();
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()).collect()
    };
    if is_sequence(folder) {
        return 1;
    }
    let count = |folder: PathBuf| {
        if is_sequence(&folder) { 1 } else { inside(&folder).iter().filter(|path| is_sequence(path)).count() }
    };
    inside(folder).into_iter().map(count).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_tells_its_version() {
        assert_eq!(version_of(Path::new("/no/such/program")), None);
        let version = version_of(&dsslam::find_program("cargo").unwrap()).unwrap();
        assert!(version.starts_with("1."), "{version}");
    }
}
