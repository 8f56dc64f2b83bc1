//! Nothing to the left knows anything to the right: each room of the house imports only from the rooms before it.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms, in order. Rooms in one group may know each other.
const LAYERS: [&[&str]; 17] = [
    &["error"],
    &["memory"],
    &["simd"],
    &["math"],
    &["scene"],
    &["parallel"],
    &["columns", "tally"],
    &["neighbors"],
    &["matter"],
    &["integrators"],
    &["stability"],
    &["boundaries"],
    &["forces", "contacts"],
    &["systems"],
    &["audit"],
    &["plan"],
    &["simulation"],
];

fn layer(room: &str) -> usize {
    LAYERS.iter().position(|layer| layer.contains(&room)).unwrap_or_else(|| panic!("{room} has no place in LAYERS"))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

#[test]
fn every_room_imports_only_from_rooms_before_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut imports = 0;
    for path in sources(&root) {
        let room = path
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
        if room == "lib" {
            continue;
        }
        for line in fs::read_to_string(&path).unwrap().lines().filter(|line| !line.trim_start().starts_with("//")) {
            for import in line.split("crate::").skip(1) {
                let other: String = import.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
                imports += 1;
                assert!(layer(&other) <= layer(&room), "{} imports {other}: {line}", path.display());
            }
        }
    }
    assert!(imports > 100, "only {imports} imports were found");
}
