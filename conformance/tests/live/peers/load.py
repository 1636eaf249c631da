"""A publisher of many messages: load.py TRANSPORT PORT TYPE TOPICS RATE SIZE SECONDS

TRANSPORT is `dds`, `zenoh` or `foxglove`. PORT is the domain for DDS. TYPE is a ROS type, such as `px4_msgs/msg/EstimatorStates`.
RATE is in Hz for each topic, and SIZE is that of a payload in bytes. A payload consists of the time in µs, and zeros. Prints the number of messages that were sent in SECONDS, and the time that the computer took for them.
"""

import os
import struct
import sys
import time
from dataclasses import dataclass

TRANSPORT, PORT, TYPE = sys.argv[1], int(sys.argv[2]), sys.argv[3]
TOPICS, RATE, SIZE, SECONDS = map(int, sys.argv[4:8])
DDS_TYPE = "{}::{}::dds_::{}_".format(*TYPE.split("/"))
HEADER = b"\0\1\0\0"
NAMES = [f"/fmu/out/load_{index}" for index in range(TOPICS)]


def fields():
    """A message without the encapsulation header."""
    return struct.pack("<Q", time.monotonic_ns() // 1000) + bytes(SIZE - 12)


def dds():
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.types import array, uint8
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic

    @dataclass
    class Load(IdlStruct, typename=DDS_TYPE):
        data: array[uint8, SIZE - 4]

    participant = DomainParticipant(PORT)
    qos = Qos(Policy.Reliability.BestEffort, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
    writers = [DataWriter(participant, Topic(participant, f"rt{name}", Load), qos=qos) for name in NAMES]
    return [lambda writer=writer: writer.write(Load(fields())) for writer in writers]


def zenoh():
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": '"router"',
        "listen/endpoints": f'["tcp/127.0.0.1:{PORT}"]',
        "scouting/multicast/enabled": "false",
    }.items():
        config.insert_json5(key, value)
    session = zenoh.open(config)
    tokens, puts = [], []
    hash = "RIHS01_" + "0" * 64

    def put(publisher, attachment):
        number = 0
        while True:
            number += 1
            publisher.put(HEADER + fields(), attachment=struct.pack("<qq", number, time.time_ns()) + attachment)
            yield

    for index, name in enumerate(NAMES):
        token = f"@ros2_lv/0/{session.zid()}/0/{index}/MP/%/%/load/{name.replace('/', '%')}/{DDS_TYPE}/{hash}/2:1:,1:,:,:,,"
        tokens.append(session.liveliness().declare_token(token))
        publisher = session.declare_publisher(f"0{name}/{DDS_TYPE}/{hash}", congestion_control=zenoh.CongestionControl.BLOCK)
        puts.append(put(publisher, b"\x10" + os.urandom(16)))
    # The session must live as long as its publishers.
    return [lambda put=put, _=(session, tokens): next(put) for put in puts]


def foxglove():
    import foxglove
    from foxglove import Channel, Schema

    text = f"uint8[{SIZE - 4}] data\n".encode()
    schema = Schema(name=TYPE, encoding="ros2msg", data=text)
    channels = [Channel(name, schema=schema, message_encoding="cdr") for name in NAMES]
    server = foxglove.start_server(name="load", host="127.0.0.1", port=PORT)
    return [lambda channel=channel, _=server: channel.log(HEADER + fields()) for channel in channels]


publish = {"dds": dds, "zenoh": zenoh, "foxglove": foxglove}[TRANSPORT]()
print("ready", flush=True)
# The receiver starts now.
sys.stdin.readline()
start = time.monotonic()
rounds = SECONDS * RATE
for number in range(rounds):
    for send in publish:
        send()
    time.sleep(max(0, start + (number + 1) / RATE - time.monotonic()))
print(rounds * TOPICS, time.monotonic() - start, flush=True)
time.sleep(2)
# Zenoh's threads may not end by themselves.
os._exit(0)
