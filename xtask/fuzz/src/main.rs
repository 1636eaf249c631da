//! One program with all fuzz targets, so that it is linked only once. `cargo xtask fuzz` builds and runs the program.
//!
//! A target reads one kind of input and checks its properties. It panics if a property does not hold. Environment
//! variables select the action:
//!
//! - `UAVSPEC_FUZZ_TARGET`: the target to run. Without this variable, the program prints the names of all targets.
//! - `UAVSPEC_FUZZ_SEEDS`: a folder. The program writes the first inputs of the target to the folder, and ends.
#![no_main]

mod codecs;
mod definitions;
mod dynamic;
mod seeds;

use std::path::Path;
use std::sync::OnceLock;
use std::{env, fs, process};

use libfuzzer_sys::fuzz_target;
use uavspec_fuzzing::{TARGETS, Target};

/// The targets for definitions and codecs. The other targets are in `uavspec-fuzzing`.
const OWN_TARGETS: &[Target] = &[
    Target { name: "definitions", check: definitions::definitions, seeds: seeds::definitions },
    Target { name: "tables", check: definitions::tables, seeds: seeds::tables },
    Target { name: "events", check: definitions::events, seeds: seeds::events },
    Target { name: "format", check: definitions::format, seeds: seeds::files },
    Target { name: "fixes", check: definitions::fixes, seeds: seeds::files },
    Target { name: "dynamic", check: dynamic::dynamic, seeds: seeds::dynamic },
    Target { name: "uorb", check: codecs::uorb, seeds: seeds::payloads },
    Target { name: "cdr", check: codecs::cdr, seeds: seeds::payloads },
    Target { name: "json-types", check: codecs::json, seeds: seeds::json },
];

/// The selected target.
static TARGET: OnceLock<Target> = OnceLock::new();

fuzz_target!(init: select(), |data: &[u8]| {
    if let Some(target) = TARGET.get() {
        (target.check)(data);
    }
});

/// Selects the target that the environment names.
fn select() {
    let targets = || OWN_TARGETS.iter().chain(TARGETS);
    let Ok(name) = env::var("UAVSPEC_FUZZ_TARGET") else {
        targets().for_each(|target| println!("{}", target.name));
        process::exit(0);
    };
    let target =
        *targets().find(|target| target.name == name).unwrap_or_else(|| panic!("unknown target `{name}`"));
    if let Some(folder) = env::var_os("UAVSPEC_FUZZ_SEEDS") {
        write_seeds(target, Path::new(&folder));
        process::exit(0);
    }
    TARGET.get_or_init(|| target);
}

/// Writes the first inputs of a target to a folder.
fn write_seeds(target: Target, folder: &Path) {
    for (number, seed) in (target.seeds)().into_iter().enumerate() {
        let path = folder.join(format!("seed-{number}"));
        fs::write(&path, seed).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}
