#!/usr/bin/env bash
# Runs the fuzz targets for a given time each, on a stable compiler: fuzz/run.sh [SECONDS [TARGET...]]
# Each is a process of its own, so that memory is told by target. DSSLAM_FUZZ_SEED=N takes other mutations.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-60}
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  for file in fuzz/fuzz_targets/*.rs; do targets+=("$(basename "$file" .rs)"); done
fi
cargo test -q -p dsslam-tests --test suite --no-run
for target in "${targets[@]}"; do
  DSSLAM_FUZZ_TARGET=$target DSSLAM_FUZZ_SECONDS=$seconds \
    cargo test -q -p dsslam-tests --test suite fuzzing::mutated -- --nocapture | grep -E "inputs|panicked|FAILED"
done
