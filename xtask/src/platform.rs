//! The platforms that `cargo xtask dist` builds programs for.

use std::env::consts::ARCH;

use crate::archive::File;

/// A platform, with its name in each kind of package.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Platform {
    /// The processor, as in the targets of the Rust compiler.
    pub(crate) machine: &'static str,
    /// The target of the Rust compiler for static programs.
    pub(crate) target: &'static str,
    /// The architecture of Debian packages.
    pub(crate) debian: &'static str,
    /// The operating system and the processor, as in Node's `process.platform` and `process.arch`.
    pub(crate) node: (&'static str, &'static str),
}

/// The features of the programs, in addition to the default features.
pub(crate) const FEATURES: &str = "uavspec/live,uavspec/schemas,uavspec/stores,uavspec/tables";

/// All platforms. The programs are static, so they run on every Linux distribution.
pub(crate) static PLATFORMS: [Platform; 2] = [
    Platform {
        machine: "x86_64",
        target: "x86_64-unknown-linux-musl",
        debian: "amd64",
        node: ("linux", "x64"),
    },
    Platform {
        machine: "aarch64",
        target: "aarch64-unknown-linux-musl",
        debian: "arm64",
        node: ("linux", "arm64"),
    },
];

/// The platform of a machine with macOS or Windows. There is only an archive for it.
pub(crate) static NATIVE: Platform = Platform {
    machine: ARCH,
    target: if cfg!(windows) {
        "x86_64-pc-windows-msvc"
    } else if cfg!(target_arch = "aarch64") {
        "aarch64-apple-darwin"
    } else {
        "x86_64-apple-darwin"
    },
    debian: "",
    node: ("", ""),
};

impl Platform {
    /// The file name of the program.
    pub(crate) fn program(&self) -> &'static str {
        if self.target.contains("windows") { "uavspec.exe" } else { "uavspec" }
    }

    /// The target of the Rust compiler for Python modules, which are linked with a C library: `gnu` or `musl`.
    pub(crate) fn module_target(&self, library: &str) -> String {
        format!("{}-unknown-linux-{library}", self.machine)
    }

    /// The name of the npm package with the program.
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
    /// The licences of third-party code that is linked into the program.
    pub(crate) third_party: Vec<File>,
}

impl Program {
    /// The executable file in an archive.
    pub(crate) fn file(&self, path: &str) -> File {
        File::binary(path, self.bytes.clone()).executable()
    }
}
