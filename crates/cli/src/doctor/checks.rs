//! The list of what is looked at.

use std::env;
use std::path::Path;

use bow::Vocabulary;
use dsfeat::Runner;

use super::{Finding, probe};

/// Version of the Rerun viewer that `dsslam-rerun` was made for; the same as in `Cargo.toml`.
const RERUN_VERSION: &str = "0.36.3";

/// Everything, in the order in which it is printed.
pub(super) fn all() -> Vec<Finding> {
    vec![program(), processor(), vocabulary(), results(), data(), onnx_runtime(), video(), feeder(), viewer()]
}

fn program() -> Finding {
    let place = env::current_exe().map_or_else(|_| String::new(), |file| format!(", {}", file.display()));
    Finding::ok("program", format!("dsslam {}{place}", env!("CARGO_PKG_VERSION")))
}

fn processor() -> Finding {
    let name = probe::processor_name().map_or_else(String::new, |name| format!("{name}, "));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    Finding::ok("processor", format!("{name}{threads} threads, {}", probe::vector_instructions()))
}

fn vocabulary() -> Finding {
    match Vocabulary::built_in() {
        Ok(vocabulary) => Finding::ok("vocabulary", format!("built in, {} words", vocabulary.n_words())),
        Err(error) => Finding::missing(
            "vocabulary",
            format!("the built-in vocabulary is damaged: {error}"),
            "rebuild the program (./install.sh), or pass --vocab FILE",
        ),
    }
}

/// `dsslam run` writes below the folder that it is called in.
fn results() -> Finding {
    let here = Path::new(".");
    let shown = env::current_dir().map_or_else(|_| ".".to_owned(), |dir| dir.display().to_string());
    match io::create_output_folder(here) {
        Ok(()) => Finding::ok("results folder", format!("{shown}/results is writable")),
        Err(error) => Finding::optional(
            "results folder",
            error.to_string(),
            "run the program in another folder, or pass --out DIR",
        ),
    }
}

fn data() -> Finding {
    const REMEDY: &str =
        "not needed: `dsslam demo` renders its own data; the tests and suites look in $DSSLAM_DATA";
    match env::var_os("DSSLAM_DATA").filter(|folder| !folder.is_empty()) {
        None => Finding::optional("data", "DSSLAM_DATA is not set", REMEDY),
        Some(folder) => {
            let n = probe::sequences_in(Path::new(&folder));
            let found = format!("{n} sequences in {} (DSSLAM_DATA)", Path::new(&folder).display());
            if n > 0 { Finding::ok("data", found) } else { Finding::optional("data", found, REMEDY) }
        }
    }
}

fn onnx_runtime() -> Finding {
    let found = |what: &str| format!("{what}: the network runs without it, several times slower");
    let (text, is_used) = match (dsfeat::find_library(), dsfeat::runner(None)) {
        (Some(library), Ok(Runner::OnnxRuntime)) => (library.display().to_string(), true),
        (Some(library), Ok(Runner::BuiltIn)) => {
            (found(&format!("{} cannot be used", library.display())), false)
        }
        (None, _) => (found("not found"), false),
        (_, Err(dsfeat::Error::BadLibrary { path, reason })) => {
            (format!("{}: {reason} (ORT_DYLIB_PATH)", path.display()), false)
        }
        (_, Err(error)) => (error.to_string(), false),
    };
    if is_used {
        Finding::ok("ONNX Runtime", text)
    } else {
        Finding::optional(
            "ONNX Runtime",
            text,
            format!("{}\nor set ORT_DYLIB_PATH to a library", dsfeat::INSTALL),
        )
    }
}

fn video() -> Finding {
    const MISSING: &str =
        "neither dsslam-video nor ffmpeg found: only .y4m videos can be read, no other videos and no cameras";
    one_of("video", &["dsslam-video", "ffmpeg"], MISSING, "./install.sh --video (OpenCV), or install ffmpeg")
}

fn feeder() -> Finding {
    const MISSING: &str = "not found: runs cannot be shown in Rerun";
    one_of("dsslam-rerun", &["dsslam-rerun"], MISSING, "./install.sh --rerun")
}

/// The first of programs that do the same.
fn one_of(name: &'static str, programs: &[&str], missing: &str, remedy: &str) -> Finding {
    match programs.iter().find_map(|program| dsslam::find_program(program)) {
        Some(program) => Finding::ok(name, program.display().to_string()),
        None => Finding::optional(name, missing, remedy),
    }
}

fn viewer() -> Finding {
    let remedy = format!("pip install rerun-sdk=={RERUN_VERSION}");
    let Some(program) = dsslam::find_program("rerun") else {
        return Finding::optional(
            "Rerun viewer",
            "`rerun` not found: no viewer window can be opened",
            remedy,
        );
    };
    let version = probe::version_of(&program).unwrap_or_else(|| "unknown version".to_owned());
    let found = format!("{version}, {}", program.display());
    if version == RERUN_VERSION {
        Finding::ok("Rerun viewer", found)
    } else {
        Finding::optional("Rerun viewer", format!("found {found}, expected {RERUN_VERSION}"), remedy)
    }
}
