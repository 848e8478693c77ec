#!/usr/bin/env bash
# Tests the Python module: crates/python/test.sh [ARGUMENTS OF PYTEST]
# Builds it with the crates that the Rust tests have built, puts it into a virtual environment of its own and runs pytest.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target}
folder=$(mkdir -p "$target/python" && cd "$target/python" && pwd)
python=$folder/venv/bin/python

fail() { echo "crates/python/test.sh: $*" >&2; exit 1; }

if ! "$python" -c '' 2>/dev/null; then
  if ! python3 -m venv "$folder/venv" >/dev/null 2>&1; then
    command -v apt-get >/dev/null 2>&1 || fail "python3 with venv and pip not found; install it with your package manager"
    sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
    echo "installing the packages python3-venv and python3-pip"
    $sudo apt-get update -qq
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3-venv python3-pip >/dev/null
    python3 -m venv "$folder/venv"
  fi
fi
wanted=crates/python/tests/requirements.txt
if ! cmp -s "$wanted" "$folder/requirements.txt"; then
  "$python" -m pip install --quiet --disable-pip-version-check -r "$wanted"
  cp "$wanted" "$folder/requirements.txt"
fi

cargo build --workspace --exclude dsslam-viewer --features dsslam-cv/video --locked
rm -rf "$folder/dsslam"
cp -r crates/python/python/dsslam "$folder/dsslam"
cp "$target/debug/lib_dsslam.so" "$folder/dsslam/_dsslam.abi3.so"
PYTHONPATH=$folder exec "$python" -m pytest -q -p no:cacheprovider crates/python/tests "$@"
