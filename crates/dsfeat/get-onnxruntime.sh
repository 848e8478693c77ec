#!/usr/bin/env bash
# Fetches ONNX Runtime, which runs the activation network several times faster than the built-in engine: crates/dsfeat/get-onnxruntime.sh [FOLDER]
# Puts libonnxruntime.so into FOLDER, by default where dsslam looks for it (~/.local/share/dsslam). What is there is kept.
set -euo pipefail

version=1.24.4
sha256=2d518e11c7767f9fdc4413bdbeb45acf30db504ff76a82fc19d9238a3f9f6c24
folder=${1:-${XDG_DATA_HOME:-$HOME/.local/share}/dsslam}
name=libonnxruntime.so.$version

fail() { echo "get-onnxruntime.sh: $*" >&2; exit 1; }

matches() { [ -f "$1" ] && echo "$sha256  $1" | sha256sum --check --status; }

if matches "$folder/$name"; then
  echo "there: $folder/$name"
  exit 0
fi
[ "$(uname -sm)" = "Linux x86_64" ] ||
  fail "this script supports only Linux on x86_64; install ONNX Runtime 1.24 or newer and pass it with --onnxruntime FILE"
if ! python3 -m pip --version >/dev/null 2>&1; then
  command -v apt-get >/dev/null 2>&1 || fail "python3 with pip not found; it fetches the package onnxruntime"
  echo "installing the package python3-pip"
  sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get update -qq && $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3-pip >/dev/null ||
    fail "python3-pip cannot be installed; it fetches the package onnxruntime"
fi

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# The library is in the Python package; any Python may fetch it.
python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --python-version 3.12 \
  --implementation cp --abi cp312 --platform manylinux_2_28_x86_64 --platform manylinux_2_27_x86_64 \
  -d "$scratch" "onnxruntime==$version" || fail "the package onnxruntime $version cannot be downloaded"
python3 -m zipfile -e "$scratch"/*.whl "$scratch"
found=$scratch/onnxruntime/capi/$name
matches "$found" || fail "the library fetched is not the expected one: $(sha256sum "$found")"
mkdir -p "$folder"
cp "$found" "$folder/.$name.new"
mv "$folder/.$name.new" "$folder/$name"
echo "installed: $folder/$name"
