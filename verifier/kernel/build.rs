//! Embeds a hash of the crate's sources, so that Python can tell a kernel built from other sources.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// The files that decide what the kernel computes, relative to the crate.
fn sources(root: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = ["Cargo.toml", "Cargo.lock", "build.rs"].map(PathBuf::from).into();
    let mut folders = vec![PathBuf::from("src")];
    while let Some(folder) = folders.pop() {
        println!("cargo:rerun-if-changed={}", folder.display());
        for entry in std::fs::read_dir(root.join(&folder)).expect("src can be listed") {
            let path = folder.join(entry.expect("src can be listed").file_name());
            if root.join(&path).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found
}

/// SHA-256 over each path, its length in bytes and its content, sorted by path; `interval.py` computes the same.
fn hash(root: &Path) -> String {
    let mut named: Vec<(String, PathBuf)> =
        sources(root).into_iter().map(|path| (path.to_string_lossy().replace('\\', "/"), path)).collect();
    named.sort();
    let mut digest = Sha256::new();
    for (name, path) in named {
        println!("cargo:rerun-if-changed={name}");
        let content = std::fs::read(root.join(path)).expect("a source can be read");
        digest.update(format!("{name}\0{}\0", content.len()));
        digest.update(content);
    }
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the crate's folder"));
    println!("cargo:rustc-env=KERNEL_SOURCE_HASH={}", hash(&root));
    println!("cargo:rerun-if-env-changed=TARGET_CPU");
    let baseline = std::env::var("TARGET_CPU").is_ok_and(|cpu| cpu == "default");
    assert!(baseline, "build from the project's folder: its .cargo/config.toml keeps core-math on the baseline CPU");
}
