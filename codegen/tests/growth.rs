//! The size of the output grows with the size of the definitions, in each dimension.

use std::fmt::Write as _;
use std::fs;

use uavspec_codegen::emit::EMITTERS;
use uavspec_codegen::generate;
use walkdir::WalkDir;

/// The files of a package.
type Files = Vec<(String, String)>;

/// The size of the output of each emitter, in bytes.
fn sizes(files: &Files) -> Vec<(&'static str, u64)> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut config =
        "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n[output]\n".to_owned();
    for emitter in EMITTERS {
        writeln!(config, "{0} = \"out/{0}\"", emitter.name).expect("a string");
    }
    let path = folder.path().join("uavspec.toml");
    fs::write(&path, config).expect("a file");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    generate(&path).expect("valid definitions");
    let size = |name: &str| {
        let entries = WalkDir::new(folder.path().join("out").join(name)).into_iter();
        entries.map(|entry| entry.and_then(|entry| entry.metadata()).expect("a file").len()).sum()
    };
    EMITTERS.iter().map(|emitter| (emitter.name, size(emitter.name))).collect()
}

fn message(lines: impl Iterator<Item = String>) -> Files {
    vec![("Wind.msg".to_owned(), format!("uint64 timestamp  # [us] Time\n{}", lines.collect::<String>()))]
}

fn fields(count: usize) -> Files {
    message((0..count).map(|number| format!("uint8 wind_{number:05}  # [m/s] Speed\n")))
}

fn constants(count: usize) -> Files {
    let constants = (0..count).map(|number| format!("uint16 WIND_{number:05} = {number}  # A wind\n"));
    message(constants.chain(["uint16 wind  # [@enum WIND] The wind\n".to_owned()]))
}

fn length_of_names(length: usize) -> Files {
    message(["a", "b"].iter().map(|name| format!("uint8 {}  # [m/s] Speed\n", name.repeat(length))))
}

fn files(count: usize) -> Files {
    (0..count)
        .map(|number| (format!("Wind{number:05}.msg"), "uint64 timestamp  # [us] Time\n".to_owned()))
        .collect()
}

#[test]
fn outputs_grow_linearly_with_the_definitions() {
    for (name, count, files) in [
        ("fields", 2_000, fields as fn(usize) -> Files),
        ("constants", 2_000, constants),
        ("names", 50, length_of_names),
        ("files", 40, self::files),
    ] {
        for ((emitter, once), (_, twice)) in sizes(&files(count)).into_iter().zip(sizes(&files(2 * count))) {
            assert!(
                once > 0 && twice * 10 <= once * 22,
                "{emitter}, twice the {name}: {once} and {twice} bytes"
            );
        }
    }
}
