#!/usr/bin/env bash
# Installs what the tests need and runs all of them: formatting, lints, tests of Rust and Python, documentation.
# Real sequences are tested where DSSLAM_DATA names a folder with them; without it those tests say that they were skipped.
# ./test.sh --viewer also checks crates/viewer, which needs Rerun: ten minutes more on two cores the first time.
set -euo pipefail
cd "$(dirname "$0")"

viewer=
case "${1:-}" in
  "") ;;
  --viewer) viewer=1 ;;
  *) echo "test.sh: unknown argument: $1; only --viewer is known" >&2; exit 2 ;;
esac

# The OpenCV reference (crates/cv) needs Debian's packages; the program itself does not.
crates/cv/get-opencv.sh

# ONNX Runtime runs the activation network faster; without it the tests compare nothing with it.
crates/dsfeat/get-onnxruntime.sh || true

started=$SECONDS
step() {
  local begun=$SECONDS
  echo "== $*"
  "$@"
  echo "== done in $((SECONDS - begun)) s"
}

step cargo fmt --all --check
step cargo clippy --workspace --exclude dsslam-viewer --all-targets --features dsslam-cv/video --locked -- -D warnings
step cargo test --workspace --exclude dsslam-viewer --features dsslam-cv/video --locked
step crates/python/test.sh
step env RUSTDOCFLAGS="-D warnings" cargo doc --workspace --exclude dsslam-viewer --no-deps --locked
if [ -n "$viewer" ]; then
  step cargo clippy --profile viewer -p dsslam-viewer --all-targets --locked -- -D warnings
  step cargo test --profile viewer -p dsslam-viewer --locked
  step env RUSTDOCFLAGS="-D warnings" cargo doc --profile viewer -p dsslam-viewer --no-deps --locked
fi
echo "== all passed in $((SECONDS - started)) s"
