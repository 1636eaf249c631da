"""Reads files with a Python library. Prints the number of messages."""

import sys
from pathlib import Path


def pyulog(paths: list[str]) -> int:
    from pyulog import ULog

    return sum(len(topic.data["timestamp"]) for path in paths for topic in ULog(path).data_list)


def mcap(paths: list[str]) -> int:
    from mcap.reader import make_reader

    def read(path: str) -> int:
        with open(path, "rb") as file:
            return sum(1 for _ in make_reader(file).iter_messages(log_time_order=False))

    return sum(map(read, paths))


def rosbags(paths: list[str]) -> int:
    from rosbags.highlevel import AnyReader

    def read(path: str) -> int:
        with AnyReader([Path(path)]) as reader:
            return sum(
                reader.deserialize(payload, connection.msgtype) is not None
                for connection, _, payload in reader.messages()
            )

    return sum(map(read, paths))


if __name__ == "__main__":
    print(globals()[sys.argv[1]](sys.argv[2:]))
