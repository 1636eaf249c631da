//! Installs the packages in empty Debian systems without Rust and without a network, and runs the program.

mod system;

use std::path::Path;
use std::time::Instant;

use self::system::System;
use super::{VERSION, debian};
use crate::platform::Platform;

/// A way to install the program.
struct Method {
    name: &'static str,
    /// The shell commands that install the program from the folder `/dist`.
    install: String,
    /// The path of the installed program.
    program: &'static str,
    /// A shell command that checks the other contents of the package.
    check: &'static str,
}

/// A log with ten records of one topic, which conforms to the definitions of all releases.
const CPULOAD: &[u8] = include_bytes!("test/cpuload.ulg");

const MESSAGE: &str = "# Wind over ground\n\nuint64 timestamp   # [us] Time since system start\nfloat32 speed      # [m/s] [@range 0, 60] [@invalid NaN] Wind speed\n";

/// The commands that run the program, after `$program` is set to its path.
const RUN: &str = "set -e
if command -v cargo rustc; then exit 1; fi
test \"$($program --version)\" = \"uavspec $version\"
$program check /input/cpuload.ulg
$program lint --package demo --dialect px4 --input /input/msg";

fn methods(platform: &Platform) -> [Method; 5] {
    let Platform { target, .. } = platform;
    let npm = platform.npm_package().trim_start_matches('@').replace('/', "-");
    [
        Method {
            name: "archive",
            install: format!(
                "mkdir /archive && tar -xzf /dist/uavspec-{VERSION}-{target}.tar.gz -C /archive --strip-components 1"
            ),
            program: "/archive/uavspec",
            check: "test -s /archive/man/man1/uavspec-check.1 && test -s /archive/completions/_uavspec",
        },
        Method {
            name: "script",
            install: "sh /dist/install.sh --from /dist --prefix /opt/uavspec".to_owned(),
            program: "/opt/uavspec/bin/uavspec",
            check: "cd /opt/uavspec/share && test -s man/man1/uavspec-check.1 && test -s zsh/site-functions/_uavspec",
        },
        Method {
            name: "deb",
            install: format!("dpkg --install /dist/{}", debian::file_name(platform)),
            program: "/usr/bin/uavspec",
            check: "dpkg --verify uavspec && dpkg --remove uavspec && ! test -e /usr/bin/uavspec",
        },
        Method {
            name: "pip",
            install: "python3 -m venv /venv && /venv/bin/pip install --no-index --find-links /dist uavspec"
                .to_owned(),
            program: "/venv/bin/uavspec",
            check: "/venv/bin/python -c 'import uavspec, uavspec.data as data; data.schema(\"px4/Event\"); uavspec.check(\"/input/cpuload.ulg\")'",
        },
        Method {
            name: "npm",
            install: format!(
                "mkdir /npm && cd /npm && npm install --offline --no-audit --no-fund /dist/uavspec-{VERSION}.tgz /dist/{npm}-{VERSION}.tgz /dist/uavspec-types-{VERSION}.tgz"
            ),
            program: "/npm/node_modules/.bin/uavspec",
            check: "cd /npm && node -e 'require(\"uavspec-types/data\").schema(\"px4/Event\")'",
        },
    ]
}

/// Tests the packages in the folder `out`, and prints a table. Returns false if a test fails.
pub(super) fn run(out: &Path, platforms: &[&'static Platform]) -> Result<bool, String> {
    let mut rows = vec![["platform", "package", "install", "run", "result"].map(str::to_owned)];
    let mut passed = true;
    for platform in platforms {
        let system = match System::new(platform) {
            Ok(system) => system,
            Err(obstacle) => {
                eprintln!("dist: not tested on {}: {obstacle}", platform.debian);
                passed = false;
                continue;
            }
        };
        system.copy(out, "dist")?;
        system.write("input/cpuload.ulg", CPULOAD)?;
        system.write("input/msg/Wind.msg", MESSAGE.as_bytes())?;
        for method in methods(platform) {
            let (row, error) = test(&system, platform, &method);
            rows.push(row);
            if let Some(error) = error {
                eprintln!("dist: {} on {}: {error}", method.name, platform.debian);
                passed = false;
            }
        }
    }
    eprint!("{}", table(&rows));
    Ok(passed)
}

/// Installs and runs the program in a system. Returns a row of the table, and the error if the test fails.
fn test(system: &System, platform: &Platform, method: &Method) -> ([String; 5], Option<String>) {
    let timed = |script: &str| {
        let start = Instant::now();
        let result = system.run(script);
        (format!("{:.1} s", start.elapsed().as_secs_f64()), result)
    };
    let (install, installed) = timed(&method.install);
    let script = format!("program={} version={VERSION}\n{RUN}\n", method.program);
    let (run, ran) = timed(&script);
    let error = installed.and(ran).and_then(|()| system.run(method.check)).err();
    let result = if error.is_none() { "passed" } else { "failed" };
    ([platform.debian.to_owned(), method.name.to_owned(), install, run, result.to_owned()], error)
}

/// Aligns the cells of a table.
fn table(rows: &[[String; 5]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let line = |row: &[String; 5]| {
        let cells = row.iter().enumerate().map(|(column, cell)| format!("{cell:<0$}", width(column)));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}
