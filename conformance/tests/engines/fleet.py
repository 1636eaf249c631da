"""Checks the same captures with the program, Python, Spark and Ray. Compares their tables, times and memory."""

import contextlib
import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import duckdb
import psutil

SETS = ["first", "second", "third"]
ENGINES = ["uavspec", "Python", "Spark", "Ray"]
TABLES = ["captures", "failures", "findings", "rules", "topics"]
INTERVAL = 0.2


def check(engine: str, folders: list[str], results: str) -> None:
    """Checks the captures in folders with an engine, in this process or one that it starts."""
    import uavspec

    started = time.perf_counter()
    if engine == "Python":
        import pyarrow
        from pyarrow import parquet

        found = pyarrow.table(uavspec.find(*folders))["capture"].to_pylist()
        results_of = (uavspec.check_files(found[start : start + 256]) for start in range(0, len(found), 256))
        for number, part in enumerate(results_of):
            for name in TABLES:
                Path(results, name).mkdir(parents=True, exist_ok=True)
                parquet.write_table(pyarrow.table(getattr(part, name)), f"{results}/{name}/{number}.parquet")
    elif engine == "Spark":
        import pyarrow
        import pyspark
        from pyspark.sql import SparkSession

        import uavspec.spark

        os.environ |= {"SPARK_HOME": os.path.dirname(pyspark.__file__), "PYSPARK_PYTHON": sys.executable}
        builder = SparkSession.builder.master("local-cluster[2,1,1024]").config("spark.ui.enabled", "false")
        spark = builder.config("spark.log.level", "ERROR").getOrCreate()
        found = pyarrow.table(uavspec.find(*folders))
        print("start", time.perf_counter() - started, flush=True)
        captures = spark.createDataFrame(found).repartition(max(4, found.num_rows // 50))
        uavspec.spark.write(captures, Path(results).absolute().as_uri())
        print("end", time.perf_counter() - started, flush=True)
        spark.stop()
    elif engine == "Ray":
        import pyarrow
        import ray

        import uavspec.ray

        ray.init(num_cpus=2, include_dashboard=False, logging_level="ERROR")
        ray.data.DataContext.get_current().enable_progress_bars = False
        print("start", time.perf_counter() - started, flush=True)
        captures = ray.data.from_arrow(pyarrow.table(uavspec.find(*folders)))
        uavspec.ray.write(captures, str(Path(results).absolute()))
        print("end", time.perf_counter() - started, flush=True)


WORKERS = {"uavspec": " check --report", "Python": "fleet.py check", "Spark": "pyspark.daemon", "Ray": "ray::Map"}
"""The text in the command line of a process that checks captures."""

KILLED = {"Spark": "CoarseGrainedExecutorBackend", "Ray": "ray::Map"}
"""The same for a process to kill."""

BUSY = 1.0
"""The processor time of a worker, in s, after which a process is killed."""


def measure(engine: str, program: str, folders: list[str], results: Path, kill: str = "") -> dict[str, float]:
    """Runs an engine. Returns its times in s and the most memory of a worker in MB. Can kill a process."""
    shutil.rmtree(results, ignore_errors=True)
    command = [sys.executable, __file__, "check", engine, str(results), *folders]
    if engine == "uavspec":
        command = [program, "check", "--report", f"parquet={results}", *folders]
    log = Path(f"{results}.log")
    started = time.perf_counter()
    with log.open("w") as errors:
        output = errors if engine == "uavspec" else subprocess.PIPE
        process = subprocess.Popen(command, stdout=output, stderr=errors, text=True)
    memory, processor, victim = 0, {}, None
    while process.poll() is None:
        for child in descendants(process.pid):
            with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                line = " ".join(child.cmdline()) or child.name()
                times = child.cpu_times()
                processor[child.pid, child.create_time()] = used = times.user + times.system
                if kill and kill in line and victim is None:
                    victim = child
                if WORKERS[engine] in line:
                    memory = max(memory, child.memory_info().rss - child.memory_info().shared)
                    if victim is not None and kill and used > BUSY:
                        victim.send_signal(signal.SIGKILL)
                        kill = ""
        time.sleep(INTERVAL)
    seconds = time.perf_counter() - started
    if process.returncode not in (0, 1) or kill:
        raise SystemExit(f"{engine} failed, or ended before a process was killed: {log.read_text()[-3000:]}")
    marks = dict(line.split() for line in process.stdout or () if line.startswith(("start ", "end ")))
    start, end = float(marks.get("start", 0)), float(marks.get("end", seconds))
    return {"start": start, "work": end - start, "processor": sum(processor.values()), "memory": memory / 1e6}


def descendants(process: int) -> list[psutil.Process]:
    """A process, and all that it started."""
    try:
        root = psutil.Process(process)
        return [root, *root.children(recursive=True)]
    except psutil.NoSuchProcess:
        return []


def compare(one: Path, other: Path) -> None:
    """Asserts that two folders contain the same tables."""
    for name in TABLES:
        rows = [f"SELECT * FROM '{folder}/{name}/*.parquet'" for folder in (one, other)]
        kinds = [duckdb.sql(f"DESCRIBE {query}").fetchall() for query in rows]
        assert kinds[0] == kinds[1], (name, kinds)
        for first, second in (rows, rows[::-1]):
            different = duckdb.sql(f"SELECT * FROM ({first} EXCEPT ALL {second}) LIMIT 5").fetchall()
            assert not different, (name, one, other, different)


def find_seeds(results: Path, folder: str, sets: list[str]) -> str:
    """Asserts that each seeded violation was found, and counts those that the source of the capture doesn't have."""
    with open(f"{folder}/seeds.csv") as file:
        rows = [{**row, "capture": str(Path(row["capture"]).absolute())} for row in csv.DictReader(file)]
    seeds = [row for row in rows if Path(row["capture"]).parent.name in sets]
    findings = f"'{results}/findings/*.parquet'"
    query = f"SELECT capture, rule, split_part(field, '.', 1) FROM {findings} WHERE verdict = 'fail'"
    found = set(duckdb.sql(query).fetchall())
    seeded = {(seed["capture"], seed["rule"], seed["topic"]): seed["source"] for seed in seeds if seed["rule"]}
    assert seeded.keys() <= found, sorted(seeded.keys() - found)[:5]
    sources = {seed["capture"]: seed["source"] for seed in seeds if not seed["rule"]}
    usual = {(sources[capture], rule, topic) for capture, rule, topic in found if capture in sources}
    unusual = [source for (_, rule, topic), source in seeded.items() if (source, rule, topic) not in usual]
    return f"{len(seeded)} seeded violations found, {len(unusual)} of them of rules and topics without other findings"


def main(folder: str, program: str) -> None:
    scales = os.environ.get("UAVSPEC_SETS", ",".join(SETS)).split(",")
    print("| captures | engine | start, s | work, s | ms per capture | processor, s | memory of a worker, MB |")
    print("|---|---|---|---|---|---|---|")
    for last in range(len(scales)):
        # Workers may have other current folders.
        folders = [str(Path(folder, "captures", name).absolute()) for name in scales[: last + 1]]
        count = sum(len(os.listdir(name)) for name in folders)
        for engine in ENGINES:
            results = Path(folder, engine)
            usage = measure(engine, program, folders, results)
            row = [f"{count:,}", engine, f"{usage['start']:.1f}", f"{usage['work']:.1f}"]
            row += [f"{1e3 * usage['work'] / count:.2f}", f"{usage['processor']:.1f}", f"{usage['memory']:.0f}"]
            print("|", " | ".join(row), "|", flush=True)
            if engine != ENGINES[0]:
                compare(Path(folder, ENGINES[0]), results)
        print(find_seeds(Path(folder, ENGINES[0]), folder, scales[: last + 1]), flush=True)
        if last == min(1, len(scales) - 1):
            for engine, text in KILLED.items():
                measure(engine, program, folders, Path(folder, "killed"), text)
                compare(Path(folder, ENGINES[0]), Path(folder, "killed"))
                print(f"{engine}: a worker was killed, and the tables are the same", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "check":
        check(sys.argv[2], sys.argv[4:], sys.argv[3])
    else:
        main(*sys.argv[1:])
