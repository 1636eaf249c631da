//! Compresses the definitions of all releases, which are loaded only when they are needed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// The level of the compression: the highest that is fast.
const LEVEL: u8 = 9;

fn main() -> io::Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("OUT_DIR is not set"))?);
    // The crate embeds these folders, and cargo doesn't notice new files in them by itself.
    for folder in ["flockwave", "i18n", "px4", "releases"] {
        println!("cargo:rerun-if-changed={folder}");
    }
    let fingerprints = packed(Path::new("releases/fingerprints.tsv"), &out, "fingerprints")?;
    let mut list = String::new();
    for family in ["px4", "ros2"] {
        let files = fs::read_dir(Path::new("releases").join(family))?;
        let mut paths: Vec<PathBuf> = files.map(|file| Ok(file?.path())).collect::<io::Result<_>>()?;
        paths.sort();
        for path in paths {
            let Some(name) = path.file_stem().and_then(|stem| stem.to_str()) else { continue };
            let packed = packed(&path, &out, &format!("{family}-{name}"))?;
            let _ = writeln!(list, "Release {{ family: {family:?}, name: {name:?}, packed: {packed} }},");
        }
    }
    let code = format!(
        "/// All releases.\npub static RELEASES: &[Release] = &[\n{list}];\n\nstatic FINGERPRINTS: &[u8] = {fingerprints};\n"
    );
    fs::write(out.join("releases.rs"), code)
}

/// Compresses a file. Returns an expression with its bytes.
fn packed(path: &Path, out: &Path, name: &str) -> io::Result<String> {
    let name = format!("{name}.deflate");
    fs::write(out.join(&name), miniz_oxide::deflate::compress_to_vec(&fs::read(path)?, LEVEL))?;
    Ok(format!("include_bytes!(concat!(env!(\"OUT_DIR\"), \"/\", {name:?}))"))
}
