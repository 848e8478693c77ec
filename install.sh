#!/usr/bin/env bash
# Installs what is missing and builds the program: ./install.sh [--rerun] [--video] [--python] [--prefix DIR]
# Safe to run again: what is already installed is kept. With --prefix the programs are also copied to DIR/bin,
# with manual pages and completions. With --rerun also
# dsslam-rerun, which feeds the Rerun viewer (ten minutes more on two cores). With --video also dsslam-video, which decodes
# videos and cameras for it and needs OpenCV (about 1.5 GB). With --python only the Python module is built, as a wheel, and
# installed into the active virtual environment.
set -euo pipefail
cd "$(dirname "$0")"

usage() { sed -n '2,8s/^# //p' "$0"; }
fail() { echo "install.sh: $*" >&2; exit 1; }

prefix=
video=
rerun=
python=
while [ $# -gt 0 ]; do
  case $1 in
    --prefix) prefix=${2:?install.sh: --prefix needs a folder}; shift 2 ;;
    --prefix=*) prefix=${1#--prefix=}; shift ;;
    --video) video=yes; shift ;;
    --rerun) rerun=1; shift ;;
    --python) python=1; shift ;;
    -h|--help) usage; exit 0 ;;
    *) usage >&2; fail "unknown argument: $1" ;;
  esac
done

echo "[1/4] a C linker"
if command -v cc >/dev/null 2>&1; then
  echo "      there: $(command -v cc)"
elif command -v apt-get >/dev/null 2>&1; then
  sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
  echo "      installing the packages gcc and libc6-dev"
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends gcc libc6-dev >/dev/null
else
  fail "no C compiler ('cc') and no apt-get: install gcc with your package manager and try again"
fi

echo "[2/4] Rust"
if ! command -v cargo >/dev/null 2>&1; then
  for folder in "${CARGO_HOME:-$HOME/.cargo}/bin" /usr/local/cargo/bin; do
    [ -x "$folder/cargo" ] && PATH=$folder:$PATH && break
  done
fi
command -v cargo >/dev/null 2>&1 || fail "cargo not found. Get Rust (https://rustup.rs) with
    curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh
open a new shell and run ./install.sh again"
wanted=$(sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml)
found=$(rustc --version | awk '{ print $2 }')
[ "$(printf '%s\n%s\n' "$wanted" "$found" | sort -V | head -n 1)" = "$wanted" ] ||
  fail "Rust $found is too old, $wanted or newer is needed: rustup update stable"
echo "      there: Rust $found"

if [ -n "$python" ]; then
  [ -z "$prefix$video$rerun" ] || fail "--python goes alone"
  [ -n "${VIRTUAL_ENV:-}${CONDA_PREFIX:-}" ] || fail "no virtual environment is active: python3 -m venv .venv && . .venv/bin/activate"
  python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' || fail "$(python3 --version) is too old, 3.10 or newer is needed"
  wheels=${CARGO_TARGET_DIR:-target}/wheels
  echo "[3/4] the wheel"
  rm -rf "$wheels"
  python3 -m pip wheel --quiet --disable-pip-version-check --no-deps -w "$wheels" ./crates/python
  echo "[4/4] pip install"
  python3 -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/dsslam-*.whl
  python3 -m pip install --quiet --disable-pip-version-check "$wheels"/dsslam-*.whl
  python3 -m pip install --quiet --disable-pip-version-check "onnxruntime>=1.24" ||
    echo "      without ONNX Runtime the activation network runs on the built-in engine, several times slower" >&2
  echo "built and installed: $(ls "$wheels"/dsslam-*.whl)   (try: python3 -c 'import dsslam')"
  exit
fi

echo "[3/4] ONNX Runtime, which runs the activation network faster"
if message=$(crates/dsfeat/get-onnxruntime.sh 2>&1); then
  echo "      $message"
else
  echo "      not installed: $message" >&2
  echo "      Without it the network runs on the built-in engine, several times slower. To try again:" >&2
  echo "      crates/dsfeat/get-onnxruntime.sh, or pass a library with --onnxruntime FILE" >&2
fi

echo "[4/4] cargo build --release --locked"
cargo build --release --locked
target=${CARGO_TARGET_DIR:-target}
program=$target/release/dsslam
viewer=$target/release/dsslam-rerun
if [ -n "$rerun" ]; then
  echo "      cargo build --profile viewer -p dsslam-viewer --locked"
  cargo build --profile viewer -p dsslam-viewer --locked
  install -m 755 "$target/viewer/dsslam-rerun" "$viewer"
  command -v rerun >/dev/null 2>&1 ||
    echo "      the Rerun viewer itself is missing: pip install rerun-sdk==$(sed -n 's/^rerun = .*"=\([0-9.]*\)".*/\1/p' Cargo.toml)"
fi
if [ -n "$prefix" ]; then
  mkdir -p "$prefix/bin"
  install -m 755 "$program" "$prefix/bin/dsslam"
  if [ -n "$rerun" ]; then install -m 755 "$viewer" "$prefix/bin/dsslam-rerun"; fi
  program=$prefix/bin/dsslam
  "$program" --quiet shell man "$prefix/share/man/man1" >/dev/null
  mkdir -p "$prefix/share/bash-completion/completions" "$prefix/share/zsh/site-functions" "$prefix/share/fish/vendor_completions.d"
  "$program" shell completions bash > "$prefix/share/bash-completion/completions/dsslam"
  "$program" shell completions zsh > "$prefix/share/zsh/site-functions/_dsslam"
  "$program" shell completions fish > "$prefix/share/fish/vendor_completions.d/dsslam.fish"
fi
if [ -n "$video" ]; then
  echo "      dsslam-video"
  crates/cv/get-opencv.sh
  cargo build --release --locked -p dsslam-cv --features video --bin dsslam-video
  helper=${CARGO_TARGET_DIR:-target}/release/dsslam-video
  [ -z "$prefix" ] || install -m 755 "$helper" "$prefix/bin/dsslam-video"
fi
echo "built: $program   (try: $program demo)"
