"""A Foxglove server that publishes ArmingCheckRequest: foxglove_server.py PORT DEFINITION.

The messages in CDR conform. The request ids of the messages in JSON are out of range. One topic has no name of ROS. Messages of clients are sent back on
/echo, after the name of their topic.
"""

import struct
import sys
import time

import foxglove
from foxglove import Channel, Schema
from foxglove.websocket import Capability, ServerListener

TYPE = "px4_msgs/msg/ArmingCheckRequest"


class Echo(ServerListener):
    def __init__(self):
        self.channel = Channel("/echo", schema=Schema(name="a/msg/B", encoding="ros2msg", data=b""), message_encoding="cdr")
        self.topics = {}

    def on_client_advertise(self, client, channel):
        self.topics[channel.id] = channel.topic

    def on_message_data(self, client, client_channel_id, data):
        self.channel.log(self.topics[client_channel_id].encode() + b" " + bytes(data))


def main():
    port, definition = int(sys.argv[1]), sys.argv[2]
    with open(definition, "rb") as file:
        schema = Schema(name=TYPE, encoding="ros2msg", data=file.read())
    cdr = Channel("/fmu/out/arming_check_request", schema=schema, message_encoding="cdr")
    schema = Schema(name=TYPE, encoding="jsonschema", data=b'{"type": "object"}')
    json = Channel("/json/arming_check_request", schema=schema, message_encoding="json")
    other = Channel("wind", schema=schema, message_encoding="json")
    foxglove.start_server(
        name="peer",
        host="127.0.0.1",
        port=port,
        server_listener=Echo(),
        capabilities=[Capability.ClientPublish],
        supported_encodings=["cdr"],
    )
    number = 0
    while True:
        number += 1
        timestamp, request = 1_000_000 + 50_000 * number, number % 256
        cdr.log(struct.pack("<4BQB3xI", 0, 1, 0, 0, timestamp, request, 0))
        json.log({"timestamp": timestamp, "request_id": 300, "valid_registrations_mask": 0})
        other.log({})
        time.sleep(0.05)


main()
