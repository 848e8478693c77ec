//! Programs of their own that work beside this one: decoders of videos, the viewer.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program beside this one, or in a folder of `PATH`.
pub fn find_program(name: &str) -> Option<PathBuf> {
    let beside = env::current_exe().ok().and_then(|program| Some(program.parent()?.to_owned()));
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = beside.into_iter().chain(env::split_paths(&path));
    folders.map(|folder| folder.join(name)).find(|file| is_program(file))
}

fn is_program(file: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.metadata().is_ok_and(|data| data.is_file() && data.permissions().mode() & 0o111 != 0)
    }
    #[cfg(not(unix))]
    file.is_file()
}

/// Keeps Ctrl-C at the terminal, which is meant for this program, away from another one.
pub fn shield(command: &mut Command) -> &mut Command {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_a_file_that_may_be_run() {
        let here = env::current_exe().unwrap();
        let name = here.file_name().unwrap().to_str().unwrap();
        assert_eq!(find_program(name), Some(here.clone()));
        assert_eq!(find_program("no-such-program"), None);
        assert!(!is_program(here.parent().unwrap()), "a folder");
        assert!(!is_program(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")), "not to be run");
    }
}
