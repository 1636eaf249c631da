//! Generates types from the bundles with typify, and a function that returns the check for a type.
//!
//! If typify rejects a bundle, the function returns the error for all types in that bundle. Other bundles are still
//! used.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use schemars::schema::{RootSchema, Schema};
use typify::{TypeSpace, TypeSpaceSettings};

/// The packages with bundles.
const PACKAGES: [&str; 2] = ["flockwave", "px4"];

fn main() -> Result<(), Box<dyn Error>> {
    let schemas = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../generated/schemas");
    let mut code = String::new();
    let mut arms = String::new();
    for package in PACKAGES {
        let path = schemas.join(format!("{package}.bundle.schema.json"));
        println!("cargo::rerun-if-changed={}", path.display());
        let root: RootSchema = serde_json::from_str(&fs::read_to_string(&path)?)?;
        match types(&root) {
            Ok((module, names)) => {
                write!(code, "pub mod {package} {{\n{module}\n}}\n")?;
                for (definition, name) in names {
                    writeln!(arms, "({package:?}, {definition:?}) => check::<{package}::{name}>,")?;
                }
            }
            Err(error) => {
                writeln!(arms, "({package:?}, _) => return Err({:?}.into()),", error.to_string())?;
            }
        }
    }
    write!(
        code,
        "pub fn check_of(package: &str, definition: &str) -> Result<Check, Failure> {{\n\
         Ok(match (package, definition) {{\n{arms}\
         _ => return Err(\"typify supports only bundles\".into()),\n}})\n}}\n"
    )?;
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets it")?);
    fs::write(out.join("types.rs"), code)?;
    Ok(())
}

/// Generates the module of a bundle, and returns the type of each definition.
fn types(root: &RootSchema) -> Result<(String, BTreeMap<String, String>), Box<dyn Error>> {
    let mut space = TypeSpace::new(&TypeSpaceSettings::default());
    space.add_ref_types(root.definitions.clone())?;
    let mut names = BTreeMap::new();
    for definition in root.definitions.keys() {
        let id = space.add_type(&Schema::new_ref(format!("#/$defs/{definition}")))?;
        names.insert(definition.clone(), space.get_type(&id)?.name());
    }
    let module = prettyplease::unparse(&syn::parse2(space.to_stream())?);
    Ok((module, names))
}
