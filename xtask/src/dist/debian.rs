//! Builds Debian packages. A package is an `ar` archive with two compressed tar archives.

use std::collections::BTreeSet;

use super::documents::{BASH, Documents, FISH, ZSH};
use super::{VERSION, notices};
use crate::archive::{File, gzip, tar_gz};
use crate::package::Package;
use crate::platform::{Platform, Program};

const CONTROL: &str = "Package: uavspec
Version: {version}
Architecture: {architecture}
Maintainer: uavspec contributors <{homepage}>
Installed-Size: {size}
Recommends: ca-certificates
Section: devel
Priority: optional
Homepage: {homepage}
Description: generator and checker for drone interface definitions
 uavspec generates Rust, TypeScript and Python code, JSON Schemas and
 documentation from definitions of PX4 and ROS 2 messages. It checks logs,
 bags, codecs and servers against these definitions.
";

const COPYRIGHT: &str = "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: uavspec
Source: {homepage}
Comment: The licences of the third-party code in the program are in
 THIRD-PARTY-LICENSES.txt.gz and RUST-LIBRARY-LICENSES.html.gz in this folder.

Files: *
Copyright: uavspec contributors
License: MIT or Apache-2.0

License: Apache-2.0
 On Debian systems, the text of this licence is in the file
 /usr/share/common-licenses/Apache-2.0.

License: MIT
{mit}";

/// The exceptions from Debian's policy.
const OVERRIDES: &str = "# The program runs on every distribution.
uavspec: shared-library-lacks-prerequisites [usr/bin/uavspec]
uavspec: statically-linked-binary [usr/bin/uavspec]
# The changes are in CHANGELOG.md.gz.
uavspec: no-changelog *
uavspec: wrong-name-for-upstream-changelog *
";

const HOMEPAGE: &str = env!("CARGO_PKG_HOMEPAGE");

/// Builds the package.
pub(super) fn package(program: &Program, documents: &Documents, time: u64) -> Result<Package, String> {
    let files = files(program, documents)?;
    let architecture = program.platform.debian;
    let members = [
        ("debian-binary", b"2.0\n".to_vec()),
        ("control.tar.gz", tar_gz(&control(&files, architecture), time)?),
        ("data.tar.gz", tar_gz(&with_folders(&files), time)?),
    ];
    Ok(Package { file_name: file_name(program.platform), count: files.len(), bytes: ar(&members, time) })
}

/// The name of the package's file.
pub(super) fn file_name(platform: &Platform) -> String {
    format!("uavspec_{}_{}.deb", version(), platform.debian)
}

/// The version with a revision. Debian sorts `1.0~rc.1` before `1.0`.
fn version() -> String {
    format!("{}-1", VERSION.replace('-', "~"))
}

/// The installed files, without folders.
fn files(program: &Program, documents: &Documents) -> Result<Vec<File>, String> {
    let compressed =
        |path: String, file: &File| Ok::<_, String>(File::binary(path + ".gz", gzip(&file.bytes)?));
    let documentation = "usr/share/doc/uavspec";
    let mut files = vec![
        program.file("usr/bin/uavspec"),
        File::new(format!("{documentation}/copyright"), &copyright(&program.licences)),
        File::new("usr/share/lintian/overrides/uavspec", OVERRIDES),
        compressed(format!("{documentation}/CHANGELOG.md"), &documents.changes)?,
    ];
    for file in program.licences.iter().filter(|file| notices::FILES.contains(&&*file.path)) {
        files.push(compressed(format!("{documentation}/{}", file.path), file)?);
    }
    for page in &documents.man_pages {
        files.push(compressed(format!("usr/share/man/man1/{}", page.path), page)?);
    }
    for (name, path) in [
        (BASH, "usr/share/bash-completion/completions/uavspec"),
        (FISH, "usr/share/fish/vendor_completions.d/uavspec.fish"),
        (ZSH, "usr/share/zsh/vendor-completions/_uavspec"),
    ] {
        files.extend(documents.completion(name).map(|file| file.at(path)));
    }
    files.sort_by(|left, right| left.path.cmp(&right.path));
    Ok(files)
}

fn copyright(licences: &[File]) -> String {
    let mit = licences.iter().find(|file| file.path == "LICENSE-MIT");
    let mit = mit.map(|file| String::from_utf8_lossy(&file.bytes).into_owned()).unwrap_or_default();
    // An empty line is a dot, and all other lines are indented.
    let line = |line: &str| if line.is_empty() { " .\n".to_owned() } else { format!(" {line}\n") };
    let mit: String = mit.lines().map(line).collect();
    COPYRIGHT.replace("{homepage}", HOMEPAGE).replace("{mit}", &mit)
}

/// The control files.
fn control(files: &[File], architecture: &str) -> Vec<File> {
    let size: usize = files.iter().map(|file| file.bytes.len().div_ceil(1024)).sum();
    let control = CONTROL
        .replace("{version}", &version())
        .replace("{architecture}", architecture)
        .replace("{homepage}", HOMEPAGE)
        .replace("{size}", &size.to_string());
    vec![File::new("control", &control)]
}

/// Adds the folders of all files, because dpkg doesn't create them on its own.
fn with_folders(files: &[File]) -> Vec<File> {
    let mut folders = BTreeSet::new();
    for file in files {
        let slashes = file.path.match_indices('/');
        folders.extend(slashes.map(|(end, _)| &file.path[..=end]));
    }
    folders.into_iter().map(File::folder).chain(files.iter().cloned()).collect()
}

/// Creates an `ar` archive: a header of 60 characters for each member, and members at even offsets.
fn ar(members: &[(&str, Vec<u8>)], time: u64) -> Vec<u8> {
    let mut archive = b"!<arch>\n".to_vec();
    for (name, bytes) in members {
        let header = format!("{name:<16}{time:<12}{:<6}{:<6}{:<8}{:<10}`\n", 0, 0, "100644", bytes.len());
        archive.extend(header.as_bytes());
        archive.extend(bytes);
        archive.resize(archive.len().next_multiple_of(2), b'\n');
    }
    archive
}
