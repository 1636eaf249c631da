//! Writes a software bill of materials in `CycloneDX` 1.6: every crate that is compiled into the `uavspec` program, with
//! its version, licence and checksum.
//!
//! The document depends only on the manifests and `Cargo.lock`: it contains no time, and its serial number is derived
//! from its content. cargo-cyclonedx (0.5.9) adds the crates of features that only other packages of the workspace
//! enable, and paths of the machine. The tool also writes a separate document for each package, and supports
//! `CycloneDX` 1.5. Therefore, this module writes the document.

mod crates;

use std::fs;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use self::crates::Crate;
pub(crate) use self::crates::Crates;
use crate::paths::{repository, shown};

/// Arguments of `sbom`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// File to write [default: target/uavspec.cdx.json]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes the document and prints a summary.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let crates = Crates::read(repository())?;
    let text = format!("{:#}\n", document(&crates));
    let path = arguments.out.unwrap_or_else(|| repository().join("target/uavspec.cdx.json"));
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(failed)?;
    fs::write(&path, text).map_err(failed)?;
    eprintln!("sbom: {} ({} crates)", shown(&path).display(), crates.dependencies.len());
    Ok(true)
}

/// The document.
fn document(crates: &Crates) -> Value {
    let components: Vec<Value> =
        crates.dependencies.iter().map(|found| component(found, "library")).collect();
    let all = crates.dependencies.iter().chain([&crates.program]);
    let edges = all.map(|found| json!({ "ref": found.purl(), "dependsOn": found.uses }));
    let mut document = json!({
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": { "component": component(&crates.program, "application") },
        "components": components,
        "dependencies": edges.collect::<Vec<_>>(),
    });
    document["serialNumber"] = serial_number(&document.to_string()).into();
    document
}

fn component(found: &Crate, kind: &str) -> Value {
    let purl = found.purl();
    let mut component = json!({
        "type": kind,
        "bom-ref": purl,
        "name": found.name,
        "version": found.version,
        "purl": purl,
        "licenses": [{ "expression": found.license() }],
    });
    if let Some(checksum) = &found.checksum {
        component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
    }
    if let Some(repository) = &found.repository {
        component["externalReferences"] = json!([{ "type": "vcs", "url": repository }]);
    }
    component
}

/// A UUID of version 8 (RFC 9562), which is derived from a text.
fn serial_number(text: &str) -> String {
    let mut bytes = [0; 16];
    bytes.iter_mut().zip(Sha256::digest(text)).for_each(|(byte, digest)| *byte = digest);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex = data_encoding::HEXLOWER.encode(&bytes);
    format!("urn:uuid:{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serial_numbers_are_derived_from_the_content() {
        // SHA-256 of the empty text, with the version and the variant.
        assert_eq!(serial_number(""), "urn:uuid:e3b0c442-98fc-8c14-9afb-f4c8996fb924");
        assert_ne!(serial_number("a"), serial_number("b"));
    }

    #[test]
    fn lists_what_is_compiled_into_the_program() {
        let crates = Crates::read(repository()).expect("the crates");
        let found = document(&crates);
        assert_eq!(found, document(&Crates::read(repository()).expect("the crates")), "reproducible");
        let names: Vec<&str> = found["components"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(|it| it["name"].as_str())
            .collect();
        for name in ["mcap", "paste", "ring", "uavspec-codegen", "uavspec-definitions"] {
            assert!(names.contains(&name), "{name} is missing");
        }
        for name in ["proptest", "libfuzzer-sys", "uavspec", "tar"] {
            assert!(!names.contains(&name), "{name} is not part of the program");
        }
        let component = |name: &str| {
            let all = found["components"].as_array().expect("a list");
            all.iter().find(|it| it["name"] == name).expect(name).clone()
        };
        assert_eq!(component("mcap")["hashes"][0]["content"].as_str().map(str::len), Some(64));
        assert!(component("uavspec-codegen").get("hashes").is_none(), "has no published archive");
    }
}
