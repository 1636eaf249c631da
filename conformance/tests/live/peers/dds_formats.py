"""A flight controller with Cyclone DDS that answers questions about message formats, as PX4 does.

    dds_formats.py DOMAIN FIELD...    FIELD is a line of the definition of ArmingCheckRequest: `uint8 request_id`
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

NAME = "arming_check_request"


@dataclass
class Question(IdlStruct, typename="px4_msgs::msg::dds_::MessageFormatRequest_"):
    timestamp: uint64
    protocol_version: uint16
    topic_name: array[uint8, 50]


@dataclass
class Answer(IdlStruct, typename="px4_msgs::msg::dds_::MessageFormatResponse_"):
    timestamp: uint64
    protocol_version: uint16
    topic_name: array[uint8, 50]
    success: bool
    message_hash: uint32


@dataclass
class Request(IdlStruct, typename="px4_msgs::msg::dds_::ArmingCheckRequest_"):
    timestamp: uint64
    request_id: uint8
    valid_registrations_mask: uint32


def fnv1a(text):
    value = 0x811C9DC5
    for byte in text.encode():
        value = (value ^ byte) * 0x01000193 % 2**32
    return value


participant = DomainParticipant(int(sys.argv[1]), qos=Qos(Policy.EntityName("/px4")))
message_hash = fnv1a("".join(f"{line}\n" for line in sys.argv[2:]))
offered = Qos(Policy.Reliability.BestEffort, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
requested = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(1))


def writer(name, kind):
    return DataWriter(participant, Topic(participant, f"rt/fmu/out/{name}", kind), qos=offered)


requests = writer(f"{NAME}_v1", Request)
answers = writer("message_format_response", Answer)
questions = DataReader(participant, Topic(participant, "rt/fmu/in/message_format_request", Question), qos=requested)
count = 0
while True:
    now = time.monotonic_ns() // 1000
    for question in questions.take(10):
        # Other items report that a publisher ended.
        if isinstance(question, Question):
            name = bytes(question.topic_name).split(b"\0")[0].decode()
            is_known = question.protocol_version == 1 and name.endswith(f"/{NAME}")
            answers.write(Answer(now, 1, question.topic_name, is_known, message_hash if is_known else 0))
    if count % 10 == 0:
        requests.write(Request(now, count // 10 % 256, 1))
    count += 1
    time.sleep(0.01)
