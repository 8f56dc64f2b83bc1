//! Data flows one way: each module imports only from the modules before it; its unit tests may use all of them.

use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the crate, in order. Those of one group may import each other.
const LAYERS: [&[&str]; 18] = [
    &["aligned", "error"],
    &["memory"],
    &["simd"],
    &["math"],
    &["scene"],
    &["parallel", "sparse"],
    &["history", "ledger"],
    &["adjacency", "columns", "grid", "tally"],
    &["neighbors"],
    &["matter"],
    &["integrators"],
    &["stability"],
    &["boundaries"],
    &["forces", "contacts", "rods"],
    &["self_contact"],
    &["plan"],
    &["systems"],
    &["simulation"],
];

fn layer(module: &str) -> usize {
    LAYERS.iter().position(|layer| layer.contains(&module)).unwrap_or_else(|| panic!("{module} has no place in LAYERS"))
}

/// The source files in a folder, without those of unit tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.file_stem().is_some_and(|name| name != "tests"))
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .collect()
}

#[test]
fn every_module_imports_only_from_modules_before_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut imports = 0;
    for path in sources(&root) {
        let module = path
            .strip_prefix(&root)
            .unwrap()
            .components()
            .next()
            .unwrap()
            .as_os_str()
            .to_str()
            .unwrap()
            .trim_end_matches(".rs")
            .to_owned();
        if module == "lib" {
            continue;
        }
        for line in fs::read_to_string(&path).unwrap().lines().filter(|line| !line.trim_start().starts_with("//")) {
            for import in line.split("crate::").skip(1) {
                let other: String = import.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
                imports += 1;
                assert!(layer(&other) <= layer(&module), "{} imports {other}: {line}", path.display());
            }
        }
    }
    assert!(imports > 100, "only {imports} imports were found");
}
