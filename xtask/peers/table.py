"""Compares whole processes of uavspec and other libraries on the same inputs. Prints one table."""

import contextlib
import importlib.metadata
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
SCHEMAS = HERE.parents[1] / "generated/schemas"

ROUNDS = int(os.environ.get("ROUNDS", "5"))
"""The number of timed runs of each contestant."""

COPIES = 20
"""The number of copies of each capture."""

DECODED = 20_000_000
"""The number of times that a codec decodes a message."""

EVENT = 44
"""The size of this message, in bytes."""

PYTHON = ["empy==3.3.4", "mcap==1.6.0", "pyros-genmsg==0.5.8", "pyulog==1.3.0", "rosbags==0.11.9"]
PYTHON += ["sourcemeta-jsonschema==17.3.0"]
NODE = ["ajv@8.20.0"]

PINS = hasattr(os, "sched_setaffinity")
"""True if the system can pin a process to cores."""

HEADER = """
| work | messages | MB | program | time, ms | MB/s | ns per message | peak memory, MB | times as fast |
|---|---|---|---|---|---|---|---|---|"""

NOTES = """
The time is the median of {rounds} runs, in which the contestants take turns; one marked with * is timed once. The last
column says how many times as fast uavspec is as the peer: the median of the ratios of all turns. An earlier run, which
isn't timed, measures the memory."""

MISSING = """
Skipped: {}. The peers in Python require the module `venv` and access to PyPI. ajv requires Node.js and npm. PX4's
generator requires a checkout of PX4-Autopilot, which the environment variable `PX4` names."""


@dataclass
class Contestant:
    """A command that does the work of a row."""

    name: str
    command: list[str | Path]
    label: str = ""
    """The text in the table, with {} in place of the version. By default the name and the version."""
    cores: int = 0
    """The number of cores that the process may use. 0 means all."""
    rounds: int = ROUNDS
    statuses: tuple[int, ...] = (0,)
    counts_lines: bool = False
    """True if the command counts the lines of a session, not its messages."""
    cleared: Path | None = None
    """A folder to delete before each run."""
    stops_at_output: bool = False
    """True if the time ends with the first byte of output."""
    times: list[float] = field(default_factory=list)
    """The time of each run, in s."""
    memory: str = ""
    messages: int = 0

    def run(self, *prefix: str | Path) -> float:
        """Runs the command, which may be the argument of another one. Returns its time, in s."""
        if self.cleared:
            shutil.rmtree(self.cleared, ignore_errors=True)
        command = [*prefix, *self.command]
        pin = self.pin if self.cores and PINS else None
        with tempfile.TemporaryFile() as errors:
            start = time.perf_counter()
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, preexec_fn=pin) as process:
                assert process.stdout
                output = process.stdout.read(1)
                first = time.perf_counter()
                output += process.stdout.read()
            end = first if self.stops_at_output else time.perf_counter()
            if process.returncode not in self.statuses:
                errors.seek(0)
                text = (output + errors.read()).decode(errors="replace")[-3000:]
                raise SystemExit(f"{self.name}: exit status {process.returncode}\n{text}")
        self.messages = count(output.decode())
        return end - start

    def pin(self) -> None:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-self.cores :])

    def measure_memory(self) -> None:
        """Runs the command without timing it. Its files are in the cache of the system afterwards."""
        with tempfile.NamedTemporaryFile("r") as result:
            self.run(sys.executable, "-I", "-S", HERE / "memory.py", result.name)
            peak, least = map(float, result.read().split())
        self.memory = f"{peak:.0f}" if peak > least else f"≤ {least:.0f}"


def count(output: str) -> int:
    """The number of messages in an output: in `29,663 of 50,836 records`, in `100 validated`, or as the only text."""
    found = re.findall(r"(?:of\s+|\A)([\d,]+)(?:\s+records|\s+validated|\s*\Z)", output)
    return sum(int(number.replace(",", "")) for number in found)


def compare(work: str, size: int, contestants: list[Contestant], versions: dict[str, str]) -> None:
    """Runs the contestants of a row in turns, and prints a line for each. The first one is uavspec."""
    for contestant in contestants:
        contestant.measure_memory()
    for turn in range(ROUNDS):
        for contestant in contestants:
            if turn < contestant.rounds:
                contestant.times.append(contestant.run())
    counts = {contestant.messages for contestant in contestants if not contestant.counts_lines} - {0}
    if len(counts) > 1:
        raise SystemExit(f"{work}: the numbers of messages differ: {sorted(counts)}")
    for contestant in contestants:
        label = (contestant.label or f"{contestant.name} {{}}").format(versions[contestant.name])
        seconds = statistics.median(contestant.times)
        cells = [work, f"{max(counts):,}" if size else "", digits(size / 1e6) if size else ""]
        cells += [label + " *" * (contestant.rounds == 1), digits(1e3 * seconds)]
        cells += [digits(size / seconds / 1e6), digits(1e9 * seconds / max(counts))] if size else ["", ""]
        turns = zip(contestant.times, contestants[0].times, strict=False)
        ratio = f"{statistics.median(peer / own for peer, own in turns):.2f}"
        cells += [contestant.memory, "" if contestant is contestants[0] else ratio]
        print("|", " | ".join(cells), "|", flush=True)


def digits(number: float) -> str:
    return f"{number:,.0f}" if number >= 100 else f"{number:.3g}"


def install(folder: Path) -> None:
    """Installs the peers from PyPI and npm, unless they are there. The table is printed without those that fail."""
    pip: list[str | Path] = [folder / "python/bin/pip", "install", "--quiet", "--disable-pip-version-check", *PYTHON]
    npm: list[str | Path] = ["npm", "install", "--silent", "--no-save", "--prefix", folder / "node", *NODE]
    (folder / "node").mkdir(exist_ok=True)
    if not (folder / "python/bin/pip").exists():
        subprocess.run([sys.executable, "-m", "venv", folder / "python"], check=False)
    for command in [pip, npm]:
        with contextlib.suppress(OSError):
            subprocess.run(command, check=False)


def find_versions(folder: Path, uavspec: str) -> dict[str, str]:
    """The versions of the contestants that are present."""
    lock = tomllib.loads((HERE / "Cargo.lock").read_text())
    versions = {package["name"]: package["version"] for package in lock["package"]}
    versions["plain structs"] = "with derives"
    versions["uavspec"] = subprocess.check_output([uavspec, "--version"], text=True).split()[-1]
    site_packages = map(str, folder.glob("python/lib/python*/site-packages"))
    for package in importlib.metadata.distributions(path=list(site_packages)):
        versions[f"Python {package.name.replace('_', '-')}"] = package.version
    with contextlib.suppress(OSError):
        versions["ajv"] = json.loads((folder / "node/node_modules/ajv/package.json").read_text())["version"]
    if checkout := os.environ.get("PX4"):
        describe = ["git", "-C", checkout, "describe", "--always", "--tags"]
        version = subprocess.run(describe, capture_output=True, text=True).stdout.strip()
        versions["PX4's generator"] = version or "without a version"
    return versions


def compilations(generated: Path, plain: Path, features: list[str]) -> Iterator[tuple[str, int, list[Contestant]]]:
    """The rows for the compile times of the generated crate and of plain structs with derives."""
    script = 'touch "$0/src/lib.rs" && CARGO_INCREMENTAL=0 cargo check --quiet --manifest-path "$0/Cargo.toml" --features "$1"'
    for selected in [[], features]:
        own = ",".join(f"uavspec-runtime/{feature}" for feature in selected)
        work = f"`cargo check` of PX4 main, {'all features' if selected else 'no features'}"
        crates = [("uavspec", generated, own), ("plain structs", plain, ",".join(selected))]
        yield work, 0, [Contestant(name, ["sh", "-c", script, folder, text]) for name, folder, text in crates]


def rows(folder: Path, uavspec: str, peers: str, corpus: Path) -> Iterator[tuple[str, int, list[Contestant]]]:
    """The rows of the table: the work, the size of its input in bytes if the speed matters, and the contestants."""
    python, modules = folder / "python/bin/python", folder / "node"

    def check(*arguments: str | Path, **options: Any) -> Contestant:
        # 1 and 6 are the statuses of captures with findings and of logs from another release.
        return Contestant("uavspec", [uavspec, "check", *arguments], statuses=(0, 1, 6), **options)

    def crate(name: str, *arguments: str | Path, **options: Any) -> Contestant:
        return Contestant(name, [peers, *arguments], **options)

    def read(library: str, *files: Path, **options: Any) -> Contestant:
        return Contestant(f"Python {library}", [python, HERE / "readers.py", library, *files], rounds=1, **options)

    def validators(file: Path, schema: Path, *referenced: Path) -> Iterator[Contestant]:
        # The script that the package installs would add the time that Python takes to start.
        program = f"jsonschema-{platform.system()}-{platform.machine()}".lower().replace("aarch64", "arm64")
        path = next(folder.glob(f"python/lib/python*/site-packages/sourcemeta_jsonschema/{program}"), Path(program))
        references = [argument for path in referenced for argument in ("--resolve", path)]
        command = [path, "validate", "--fast", *references, schema, file]
        yield Contestant("Python sourcemeta-jsonschema", command, "Blaze (sourcemeta-jsonschema {})")
        yield Contestant("ajv", ["node", HERE / "ajv.mjs", modules, file, schema, *referenced])

    for source in sorted((corpus / "ulog").iterdir()):
        logs = copies(source, folder)
        peers_of_ulog = [crate("px4-ulog", "ulog", *logs, cores=1), read("pyulog", *logs, cores=1)]
        yield f"ULog, {COPIES} × {source.name}", total(*logs), [check(*logs, cores=1), *peers_of_ulog]
        cores = [check(*logs, cores=count, label=f"uavspec {{}}, cores: {count}") for count in [2, 1]]
        yield f"ULog, {COPIES} × {source.name}", total(*logs), cores
        yield f"ULog, {source.name}", total(source), [check(source, cores=1), crate("px4-ulog", "ulog", source, cores=1)]

    for compression in ["plain", "zstd", "lz4"]:
        bags = copies(folder / f"{compression}.mcap", folder)
        readers = [crate("mcap", "mcap", *bags, cores=1), read("mcap", *bags, cores=1), read("rosbags", *bags, cores=1)]
        yield f"MCAP of the same log, {compression}, {COPIES} ×", total(*bags), [check(*bags, cores=1), *readers]

    sessions = copies(corpus / "flockwave/main.jsonl", folder)
    skip = crate("serde_json", "skip", *sessions, cores=1, counts_lines=True, label="serde_json {}, skipping")
    yield f"session, {COPIES} × main.jsonl", total(*sessions), [check(*sessions, cores=1), skip]

    lines, schema = folder / "FailsafeFlags.jsonl", SCHEMAS / "px4/FailsafeFlags.schema.json"
    skip = crate("serde_json", "skip", lines, label="serde_json {}, skipping")
    yield "JSON Lines", total(lines), [check("--type", "px4/FailsafeFlags", lines), skip, *validators(lines, schema)]

    for uavs in [1, 50]:
        reports = folder / f"reports-{uavs}.jsonl"
        skip = crate("serde_json", "skip", reports, label="serde_json {}, skipping")
        schemas = HERE / "record.schema.json", SCHEMAS / "flockwave.bundle.schema.json"
        work = f"status reports, UAVs in each: {uavs}"
        yield work, total(reports), [check(reports), skip, *validators(reports, *schemas)]

    codecs = [crate(name, name, str(DECODED)) for name in ["uavspec", "cdr", "cdr-encoding"]]
    yield "decode `Event` from CDR", DECODED * EVENT, codecs

    one = folder / "one.jsonl"
    with lines.open() as file:
        one.write_text(file.readline())
    log = min((corpus / "ulog").iterdir(), key=lambda path: path.stat().st_size)
    start = check("--type", "px4/FailsafeFlags", one, stops_at_output=True)
    yield "start to first output, one line of JSON", 0, [start]
    yield "start to first output, small log", 0, [check(log, stops_at_output=True)]

    messages = (corpus / "px4/main/msg").resolve()
    files = sorted(messages.glob("*.msg"))
    unchanged, empty = (configure(folder / name, messages) for name in ["unchanged", "empty"])
    yield "`codegen` of PX4 main, unchanged", 0, [Contestant("uavspec", [uavspec, "codegen", "--config", unchanged])]
    # 1 is the status of definitions with findings.
    lint = Contestant("uavspec", [uavspec, "lint", "--config", unchanged], statuses=(0, 1))
    yield "`lint` of PX4 main", 0, [lint]

    package = folder / "ros/px4_msgs"
    package.mkdir(parents=True, exist_ok=True)
    (package / "msg").unlink(missing_ok=True)
    (package / "msg").symlink_to(messages)
    (package / "package.xml").write_text('<package format="3"><name>px4_msgs</name></package>\n')
    own = Contestant("uavspec", [uavspec, "codegen", "--config", empty], cleared=empty.parent / "src")
    roslibrust = crate("roslibrust_codegen", "roslibrust", package.parent)
    tools, output = Path(os.environ.get("PX4", ""), "Tools/msg"), folder / "px4"
    # PX4's build runs the generator twice as well.
    script = 'for kind in --headers --sources; do "$@" "$kind" || exit; done'
    command: list[str | Path] = ["sh", "-c", script, "sh", python, tools / "px_generate_uorb_topic_files.py"]
    command += ["-i", messages, "-e", tools / "templates/uorb", "-o", output, "-f", *files]
    generators = [
        own,
        roslibrust,
        Contestant("PX4's generator", command, "PX4's generator, {}, to C++", cleared=output),
    ]
    yield f"generate code from {len(files)} messages", 0, generators


def copies(path: Path, folder: Path) -> list[Path]:
    """Copies of a capture, as if it were an archive."""
    folder = folder / "copies" / path.stem
    folder.mkdir(parents=True, exist_ok=True)
    made = [folder / f"{number:02}{path.suffix}" for number in range(COPIES)]
    for copy in made:
        shutil.copy(path, copy)
    return made


def total(*files: Path) -> int:
    return sum(path.stat().st_size for path in files)


def configure(folder: Path, messages: Path) -> Path:
    """Writes the configuration that generates Rust from a folder of messages."""
    folder.mkdir(exist_ok=True)
    path = folder / "uavspec.toml"
    package = f'[[package]]\nname = "px4"\ndialect = "px4"\ninclude = ["{messages}/*.msg"]\n'
    path.write_text(f'[output]\nrust = {{ path = "src", root = "lib.rs" }}\n\n{package}')
    return path


def main(folder: Path, uavspec: str, peers: str, corpus: Path, crates: list[Path], features: list[str]) -> None:
    install(folder)
    versions = find_versions(folder, uavspec)
    model = platform.processor()
    with contextlib.suppress(OSError):
        model = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())[0]
    print(f"{model}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}")
    print(HEADER)
    missing = set()
    for work, size, contestants in chain(rows(folder, uavspec, peers, corpus), compilations(*crates, features)):
        present = [contestant for contestant in contestants if contestant.name in versions]
        missing |= {contestant.name for contestant in contestants} - versions.keys()
        compare(work, size, present, versions)
    print(NOTES.format(rounds=ROUNDS))
    if missing:
        print(MISSING.format(", ".join(sorted(missing))))


if __name__ == "__main__":
    paths = list(map(Path, sys.argv[4:7]))
    main(Path(sys.argv[1]), sys.argv[2], sys.argv[3], paths[0], paths[1:], sys.argv[7:])
