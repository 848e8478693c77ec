//! A rendered sequence, made once by the program itself, and cheap copies of its beginning that tests may break.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::program::{Call, dsslam, text};

/// Frames of the shared sequence.
pub(crate) const N_RENDERED: u32 = 40;

/// The shared sequence: `N_RENDERED` stereo frames of the town in KITTI's layout.
pub(crate) fn rendered() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("town");
        if folder.exists() {
            fs::remove_dir_all(&folder).unwrap();
        }
        let frames = N_RENDERED.to_string();
        dsslam(&["synth", text(&folder), "--preset", "town", "--frames", &frames]).expect_success();
        folder
    })
}

/// The first frames of the rendered sequence in a folder of their own.
pub(crate) struct Copy {
    folder: TempDir,
}

impl Copy {
    /// A copy of the first `n` frames; images are links, texts are files.
    pub(crate) fn of_first(n: usize) -> Self {
        let copy = Copy { folder: tempfile::tempdir().unwrap() };
        for camera in ["image_0", "image_1"] {
            fs::create_dir_all(copy.path().join(camera)).unwrap();
            for i in 0..n {
                let name = format!("{camera}/{i:06}.png");
                std::os::unix::fs::symlink(rendered().join(&name), copy.path().join(&name)).unwrap();
            }
        }
        fs::copy(rendered().join("calib.txt"), copy.path().join("calib.txt")).unwrap();
        for name in ["times.txt", "poses.txt"] {
            let whole = fs::read_to_string(rendered().join(name)).unwrap();
            let lines: Vec<&str> = whole.lines().take(n).collect();
            copy.write(name, lines.join("\n") + "\n");
        }
        copy
    }

    /// The sequence's folder.
    pub(crate) fn path(&self) -> PathBuf {
        self.folder.path().join("seq")
    }

    /// A path in the sequence, as messages show it.
    pub(crate) fn file(&self, name: &str) -> String {
        self.path().join(name).display().to_string()
    }

    /// The results folder of [`Copy::run`].
    pub(crate) fn results(&self) -> PathBuf {
        self.folder.path().join("results")
    }

    /// Replaces a file.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        self.remove(name);
        fs::write(self.path().join(name), content).unwrap();
    }

    /// Removes a file if it is there.
    pub(crate) fn remove(&self, name: &str) {
        let path = self.path().join(name);
        if path.symlink_metadata().is_ok() {
            fs::remove_file(path).unwrap();
        }
    }

    /// Changes a text file line by line.
    pub(crate) fn edit(&self, name: &str, change: impl Fn(usize, &str) -> Option<String>) {
        let text = fs::read_to_string(self.path().join(name)).unwrap();
        let lines: Vec<String> = text.lines().enumerate().filter_map(|(i, line)| change(i, line)).collect();
        self.write(name, lines.join("\n") + "\n");
    }

    /// The bytes of a file.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap()
    }

    /// Runs SLAM on it with further arguments.
    pub(crate) fn run(&self, args: &[&str]) -> Call {
        let (sequence, results) = (self.path(), self.results());
        let mut all = vec!["run", text(&sequence), "--out", text(&results)];
        all.extend(args);
        dsslam(&all)
    }
}
