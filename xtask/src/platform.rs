//! The platforms that `cargo xtask dist` builds programs for.

use crate::archive::File;

/// A platform, with its name in each kind of package.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Platform {
    /// The target of the Rust compiler.
    pub(crate) target: &'static str,
    /// The processor, as in the names of GNU's tools, and of Debian's folders for musl.
    pub(crate) machine: &'static str,
    /// The architecture of Debian packages.
    pub(crate) debian: &'static str,
    /// The operating system and the processor, as in Node's `process.platform` and `process.arch`.
    pub(crate) node: (&'static str, &'static str),
    /// The platform tags of wheels. A static program runs with glibc and musl, so the tags name the oldest versions
    /// for which pip has tags.
    pub(crate) wheel: &'static str,
}

/// The features of the programs, in addition to the default ones.
pub(crate) const FEATURES: &str = "live,schemas,stores,tables";

/// All platforms. The programs are static, so they run on every Linux distribution.
pub(crate) static PLATFORMS: [Platform; 2] = [
    Platform {
        target: "x86_64-unknown-linux-musl",
        machine: "x86_64",
        debian: "amd64",
        node: ("linux", "x64"),
        wheel: "manylinux_2_17_x86_64.manylinux2014_x86_64.musllinux_1_1_x86_64",
    },
    Platform {
        target: "aarch64-unknown-linux-musl",
        machine: "aarch64",
        debian: "arm64",
        node: ("linux", "arm64"),
        wheel: "manylinux_2_17_aarch64.manylinux2014_aarch64.musllinux_1_1_aarch64",
    },
];

impl Platform {
    /// The npm package with the program.
    pub(crate) fn npm_package(&self) -> String {
        let (system, processor) = self.node;
        format!("@uavspec/{system}-{processor}")
    }
}

/// A program for a platform.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) platform: &'static Platform,
    pub(crate) bytes: Vec<u8>,
    /// The licences of the project, and of all code that is linked into the program.
    pub(crate) licences: Vec<File>,
}

impl Program {
    /// The executable file in an archive.
    pub(crate) fn file(&self, path: &str) -> File {
        File::binary(path, self.bytes.clone()).executable()
    }
}
