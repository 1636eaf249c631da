"""Runs a command, and writes its peak memory to a file, in MB.

The system counts the memory of the process that starts a command as memory of the command. This script is small, so it
can measure small commands. It also writes the peak of a command that needs almost none, which is the least that it can
measure.
"""

import os
import sys


def run(command: list[str]) -> tuple[int, float]:
    """Runs a command. Returns its exit status and its peak memory."""
    _, status, usage = os.wait4(os.posix_spawnp(command[0], command, os.environ), 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6


status, peak = run(sys.argv[2:])
with open(sys.argv[1], "w") as file:
    print(peak, run(["true"])[1], file=file)
sys.exit(status)
