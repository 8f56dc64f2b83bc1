//! Benchmarks: `cargo bench -p physcore-benches`.
