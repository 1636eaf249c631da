//! Links defmt's section at fixed addresses, because defmt truncates addresses to 16 bits.

fn main() {
    println!("cargo:rerun-if-changed=host.x");
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("a folder");
    println!("cargo:rustc-link-arg-bins=-T{folder}/host.x");
    println!("cargo:rustc-link-arg-bins=-no-pie");
}
