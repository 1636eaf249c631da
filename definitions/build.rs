//! Rebuilds the crate when the embedded folders change. Cargo doesn't notice new files in them by itself.

fn main() {
    for folder in ["flockwave", "i18n", "px4", "releases"] {
        println!("cargo:rerun-if-changed={folder}");
    }
}
