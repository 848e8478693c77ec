//! End-to-end, replay, golden and architecture tests (`tests/suite`) and benchmarks (`benches`); there is no library here.
