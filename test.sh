#!/usr/bin/env bash
# Installs what the tests need and runs all of them: formatting, lints, tests, documentation.
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
missing=()
command -v g++ >/dev/null 2>&1 || missing+=(g++)
command -v pkg-config >/dev/null 2>&1 || missing+=(pkg-config)
command -v clang >/dev/null 2>&1 || missing+=(clang)
pkg-config --exists opencv4 2>/dev/null || missing+=(libopencv-dev)
if [ ${#missing[@]} -gt 0 ]; then
  echo "== installing ${missing[*]}"
  command -v apt-get >/dev/null 2>&1 || { echo "test.sh: no apt-get: install ${missing[*]} with your package manager" >&2; exit 1; }
  sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

# The activation network needs ONNX Runtime; without it its tests say that they were skipped.
crates/dsfeat/get-onnxruntime.sh || true

started=$SECONDS
step() {
  local begun=$SECONDS
  echo "== $*"
  "$@"
  echo "== done in $((SECONDS - begun)) s"
}

step cargo fmt --all --check
step cargo clippy --workspace --exclude viewer --all-targets --features cv/video --locked -- -D warnings
step cargo test --workspace --exclude viewer --features cv/video --locked
step env RUSTDOCFLAGS="-D warnings" cargo doc --workspace --exclude viewer --no-deps --locked
if [ -n "$viewer" ]; then
  step cargo clippy --profile viewer -p viewer --all-targets --locked -- -D warnings
  step cargo test --profile viewer -p viewer --locked
  step env RUSTDOCFLAGS="-D warnings" cargo doc --profile viewer -p viewer --no-deps --locked
fi
echo "== all passed in $((SECONDS - started)) s"
