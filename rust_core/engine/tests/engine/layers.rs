//! Data flows one way: each module imports only from the modules before it. Unit tests of a module may use all of them.

use std::fs;
use std::path::{Path, PathBuf};

/// Crates, each with its own modules in order. Modules of one group may import each other. Cargo holds the order of crates.
const LAYERS: [(&str, &[&[&str]]); 5] = [
    (
        "base",
        &[
            &["aligned", "error"],
            &["memory"],
            &["simd"],
            &["math"],
            &["scene"],
            &["parallel"],
            &["history", "ledger"],
            &["adjacency", "columns", "grid", "tally"],
            &["integrators"],
            &["stability"],
            &["solvers"],
            &["plan"],
            &["systems"],
        ],
    ),
    ("fields", &[&["reaction_diffusion", "schrodinger", "wave"]]),
    ("matter", &[&["matter"], &["neighbors"], &["boundaries"], &["forces"], &["catalog"]]),
    ("fluids", &[&["particles"], &["weakly_compressible"]]),
    ("engine", &[&["sparse"], &["contacts"], &["systems"], &["simulation"]]),
];

/// Place of a module in its crate; None of another crate's module.
fn layer(layers: &[&[&str]], module: &str) -> Option<usize> {
    layers.iter().position(|layer| layer.contains(&module))
}

/// Source files in a folder, without those of unit tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.file_stem().is_some_and(|name| name != "tests"))
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .collect()
}

/// Name of the module that a file belongs to.
fn module_of(path: &Path, root: &Path) -> String {
    let inside = path.strip_prefix(root).unwrap().components().next().unwrap();
    inside.as_os_str().to_str().unwrap().trim_end_matches(".rs").to_owned()
}

#[test]
fn every_module_imports_only_from_modules_before_it() {
    let mut imports = 0;
    for (name, layers) in LAYERS {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src");
        for path in sources(&root) {
            let module = module_of(&path, &root);
            if ["lib", "scenes"].contains(&module.as_str()) {
                continue;
            }
            let own = layer(layers, &module).unwrap_or_else(|| panic!("{name}: {module} has no place in LAYERS"));
            for line in fs::read_to_string(&path).unwrap().lines().filter(|line| !line.trim_start().starts_with("//")) {
                for import in line.split("crate::").skip(1) {
                    let other: String = import.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
                    imports += 1;
                    let before = layer(layers, &other).is_none_or(|other| other <= own);
                    assert!(before, "{} imports {other}: {line}", path.display());
                }
            }
        }
    }
    assert!(imports > 100, "only {imports} imports were found");
}
