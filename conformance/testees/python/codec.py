"""Codecs of two PX4 messages in uORB and CDR format; uses the standard library only.

A field is (name, format of `struct`, number of elements or None, allowed values or None).
"""

import struct

SIZES = {"Q": 8, "I": 4, "H": 2, "B": 1, "?": 1}
LIMITS = {"Q": 2**64, "I": 2**32, "H": 2**16, "B": 2**8}


def fields(form, names, known=None):
    return [(name, form, None, known) for name in names.split()]


EVENT = [
    ("timestamp", "Q", None, None),
    ("id", "I", None, None),
    ("event_sequence", "H", None, None),
    ("arguments", "B", 25, None),
    ("log_levels", "B", None, None),
]

FAILSAFE_FLAGS = [
    *fields("Q", "timestamp"),
    *fields("I", "mode_req_angular_velocity mode_req_attitude mode_req_local_alt mode_req_local_position"),
    *fields("I", "mode_req_local_position_relaxed mode_req_global_position mode_req_mission"),
    *fields("I", "mode_req_offboard_signal mode_req_home_position mode_req_wind_and_flight_time_compliance"),
    *fields("I", "mode_req_prevent_arming mode_req_manual_control mode_req_other"),
    *fields("?", "angular_velocity_invalid attitude_invalid local_altitude_invalid local_position_invalid"),
    *fields("?", "local_position_invalid_relaxed local_velocity_invalid global_position_invalid"),
    *fields("?", "auto_mission_missing offboard_control_signal_lost home_position_invalid"),
    *fields("?", "manual_control_signal_lost gcs_connection_lost"),
    *fields("B", "battery_warning", (0, 1, 2, 3, 4, 6, 7, 10)),
    *fields("?", "battery_low_remaining_time battery_unhealthy geofence_breached mission_failure"),
    *fields("?", "vtol_fixed_wing_system_failure wind_limit_exceeded flight_time_limit_exceeded"),
    *fields("?", "local_position_accuracy_low fd_critical_failure fd_esc_arming_failure"),
    *fields("?", "fd_imbalanced_prop fd_motor_failure"),
]

TYPES = {"px4/Event": EVENT, "px4/FailsafeFlags": FAILSAFE_FLAGS}


class Rejected(Exception):
    """The input is invalid."""


def decode(message, form, data):
    """Decodes a payload to a dictionary."""
    order = "<"
    if form == "cdr":
        order = {b"\x00\x01": "<", b"\x00\x00": ">"}.get(data[:2])
        if order is None or len(data) < 4:
            raise Rejected("unknown encapsulation")
        data = data[4:]
    places, end = layout(message, form)
    whole = -end % (4 if form == "cdr" else alignment(message)) + end
    is_right = end <= len(data) <= whole if form == "cdr" else len(data) in (end, whole)
    if not is_right:
        raise Rejected(f"{len(data)} bytes instead of {end}")
    value = {}
    for name, letter, count, _ in message:
        code = "B" if letter == "?" else letter
        items = struct.unpack_from(f"{order}{count or 1}{code}", data, places[name])
        if letter == "?":
            if items[0] > 1:
                raise Rejected(f"{name} is neither 0 nor 1")
            items = [items[0] == 1]
        value[name] = items[0] if count is None else list(items)
    return value


def encode(message, form, value):
    """Encodes a dictionary as a little-endian payload."""
    check(message, value)
    places, end = layout(message, form)
    data = bytearray(end if form == "cdr" else end + -end % alignment(message))
    for name, letter, count, _ in message:
        items = [value[name]] if count is None else value[name]
        struct.pack_into(f"<{len(items)}{letter}", data, places[name], *items)
    return (b"\x00\x01\x00\x00" if form == "cdr" else b"") + bytes(data)


def check(message, value, is_strict=False):
    """Raises if the fields are wrong or, in strict mode, if any rule is violated."""
    if not isinstance(value, dict) or set(value) != {field[0] for field in message}:
        raise Rejected("other fields")
    for name, letter, count, known in message:
        items = [value[name]] if count is None else value[name]
        if not isinstance(items, list) or len(items) != (count or 1):
            raise Rejected(f"{name} has the wrong length")
        for item in items:
            # In Python, a bool is an int.
            is_right = type(item) is bool if letter == "?" else type(item) is int and 0 <= item < LIMITS[letter]
            if not is_right:
                raise Rejected(f"{name} has the wrong type")
            if is_strict and known is not None and item not in known:
                raise Rejected(f"{name} is undocumented")


def layout(message, form):
    """The offsets of the fields, and the end of the last field. PX4 sorts fields in memory by size."""
    order = message if form == "cdr" else sorted(message, key=lambda field: -SIZES[field[1]])
    places, end = {}, 0
    for name, letter, count, _ in order:
        places[name] = end + -end % SIZES[letter]
        end = places[name] + SIZES[letter] * (count or 1)
    return places, end


def alignment(message):
    return max(SIZES[field[1]] for field in message)
