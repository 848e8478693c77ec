//! Writes the seeds of all targets, and the inputs that once failed, to where cargo-fuzz looks for them: `corpus/TARGET`.

use std::error::Error;
use std::fs;
use std::path::Path;

use dsslam_fuzz::TARGETS;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for target in TARGETS {
        let folder = root.join("corpus").join(target.name);
        fs::create_dir_all(&folder)?;
        for (i, seed) in (target.seeds)().iter().enumerate() {
            fs::write(folder.join(format!("seed-{i}")), seed)?;
        }
    }
    for entry in fs::read_dir(root.join("regressions"))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some(target) = TARGETS.iter().find(|target| name.starts_with(&format!("{}-", target.name))) {
            fs::copy(&path, root.join("corpus").join(target.name).join(name))?;
        }
    }
    Ok(())
}
