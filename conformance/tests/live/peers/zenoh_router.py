"""A Zenoh router with nodes of ROS 2, as rmw_zenoh makes them: zenoh_router.py PORT [HASH]

Publishes ArmingCheckRequest messages of PX4, and declares hostile tokens. Without HASH, only connects others.
"""

import itertools
import os
import struct
import sys
import time

import zenoh
from zenoh import ext

PORT, HASH = (*sys.argv[1:], None)[:2]
TYPE = "px4_msgs::msg::dds_::ArmingCheckRequest_"
QOS = "2:1:,1:,:,:,,"
RELIABLE = "1::,5:,:,:,,"

config = zenoh.Config()
for key, value in {
    "mode": '"router"',
    "listen/endpoints": f'["tcp/127.0.0.1:{PORT}"]',
    "scouting/multicast/enabled": "false",
}.items():
    config.insert_json5(key, value)
session = zenoh.open(config)
kept = []


def declare(token):
    kept.append(session.liveliness().declare_token(token))


def announce(kind, name, hash=HASH, qos=QOS):
    """Declares the token of an endpoint."""
    start = f"@ros2_lv/0/{session.zid()}/0/{len(kept)}/{kind}/%/%/px4"
    declare(f"{start}/{name.replace('/', '%')}/{TYPE}/{hash}/{qos}")


def message(number):
    now = time.monotonic_ns() // 1000
    return b"\0\1\0\0" + struct.pack("<QB3xI", now, number % 256, 1)


class Publisher:
    """A publisher with the attachments of rmw_zenoh."""

    def __init__(self, name, hash=HASH, is_durable=False):
        key = f"0{name}/{TYPE}/{hash}"
        if is_durable:
            cache = ext.CacheConfig(1)
            self.publisher = ext.declare_advanced_publisher(session, key, cache=cache, publisher_detection=True)
        else:
            self.publisher = session.declare_publisher(key)
        self.id, self.sequence = os.urandom(16), 0
        announce("MP", name, hash)

    def put(self, payload):
        self.sequence += 1
        attachment = struct.pack("<qq", self.sequence, time.time_ns()) + b"\x10" + self.id
        self.publisher.put(payload, attachment=attachment)


def declare_hostile_tokens():
    start = f"@ros2_lv/0/{session.zid()}"
    for end in ("", "/0/1/ZZ/%/%/n", "/0/1/MP/%/%/n/%t/T/H/9:9:9", "/0/1/MP/%/%/n/%x/*/H/::,", "/" + "a" * 9000):
        declare(start + end)


if HASH is None:
    time.sleep(100_000)
announce("MS", "/fmu/out/request", qos=RELIABLE)
declare_hostile_tokens()
healthy, gaps, corrupt = (Publisher(f"/fmu/out/{name}") for name in ("request", "gaps", "corrupt"))
humble = Publisher("/fmu/out/humble", hash="TypeHashNotSupported")
latched = Publisher("/fmu/out/latched", is_durable=True)
latched.put(message(1))
Publisher("/fmu/out/types")
Publisher("/fmu/out/types", hash="RIHS01_" + "0" * 64)
print("ready", flush=True)
for number in itertools.count():
    healthy.put(message(number))
    humble.put(message(number))
    gaps.sequence += 2
    gaps.put(message(number))
    corrupt.put(message(number)[: number % 20])
    time.sleep(0.02)
