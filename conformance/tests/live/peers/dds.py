"""A node with Cyclone DDS.

    dds.py DOMAIN publish RELIABILITY   publishes ArmingCheckRequest ten times per second
    dds.py DOMAIN truncate RELIABILITY  does so without the last field
    dds.py DOMAIN subscribe RELIABILITY subscribes to it
    dds.py DOMAIN store RELIABILITY     publishes it once, and stores it for new subscribers
    dds.py DOMAIN relay RELIABILITY     publishes what it receives from /fmu/in/arming_check_request_v1

RELIABILITY is `best_effort` or `reliable`. A fourth argument is the partition.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import uint8, uint32, uint64
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration

TYPE = "px4_msgs::msg::dds_::ArmingCheckRequest_"
HASH = b"typehash=RIHS01_e4d6be7c8f4d5e08cd19e344ba59a76295dbcf71a6a29ed9efd44d6ea588a5eb;"


@dataclass
class Request(IdlStruct, typename=TYPE):
    timestamp: uint64
    request_id: uint8
    valid_registrations_mask: uint32


@dataclass
class TruncatedRequest(IdlStruct, typename=TYPE):
    timestamp: uint64
    request_id: uint8


domain, action, reliability = int(sys.argv[1]), sys.argv[2], sys.argv[3]
is_reliable = reliability == "reliable"
policies = [
    Policy.Reliability.Reliable(duration(seconds=1)) if is_reliable else Policy.Reliability.BestEffort,
    Policy.History.KeepLast(5),
]
partition = Qos(Policy.Partition(sys.argv[4:]))
participant = DomainParticipant(domain, qos=Qos(Policy.EntityName(f"/{action}")))


def topic(direction, kind=Request):
    return Topic(participant, f"rt/fmu/{direction}/arming_check_request_v1", kind)


def writer(kind=Request):
    qos = Qos(*policies, Policy.Durability.TransientLocal, Policy.Userdata(HASH))
    return DataWriter(Publisher(participant, qos=partition), topic("out", kind), qos=qos)


def reader(direction):
    return DataReader(Subscriber(participant, qos=partition), topic(direction), qos=Qos(*policies, Policy.Durability.Volatile))


def now():
    return time.monotonic_ns() // 1000


if action == "publish":
    output = writer()
    for count in range(1_000_000):
        output.write(Request(now(), count % 256, 1))
        time.sleep(0.1)
elif action == "truncate":
    output = writer(TruncatedRequest)
    for count in range(1_000_000):
        output.write(TruncatedRequest(now(), count % 256))
        time.sleep(0.1)
elif action == "store":
    output = writer()
    output.write(Request(now(), 42, 1))
    time.sleep(100_000)
elif action == "relay":
    output, source = writer(), reader("in")
    while True:
        for message in source.take(10):
            # Other items report that the publisher ended.
            if isinstance(message, Request):
                output.write(message)
        time.sleep(0.01)
else:
    source = reader("out")
    while True:
        source.take(100)
        time.sleep(0.05)
