"use strict";
// Codecs of two PX4 messages in uORB and CDR format; uses no packages.
//
// A field is [name, letter, number of elements or null, allowed values or null]. The letters are those of Python's
// `struct`. 64-bit fields are BigInt in JavaScript; all others are numbers.

const KINDS = {
  Q: { size: 8, most: 2n ** 64n - 1n, read: "getBigUint64", write: "setBigUint64" },
  I: { size: 4, most: 2 ** 32 - 1, read: "getUint32", write: "setUint32" },
  H: { size: 2, most: 2 ** 16 - 1, read: "getUint16", write: "setUint16" },
  B: { size: 1, most: 2 ** 8 - 1, read: "getUint8", write: "setUint8" },
  "?": { size: 1, read: "getUint8", write: "setUint8" },
};

const fields = (letter, names, known = null) => names.split(" ").map((name) => [name, letter, null, known]);

const EVENT = [
  ["timestamp", "Q", null, null],
  ["id", "I", null, null],
  ["event_sequence", "H", null, null],
  ["arguments", "B", 25, null],
  ["log_levels", "B", null, null],
];

const FAILSAFE_FLAGS = [
  ...fields("Q", "timestamp"),
  ...fields("I", "mode_req_angular_velocity mode_req_attitude mode_req_local_alt mode_req_local_position"),
  ...fields("I", "mode_req_local_position_relaxed mode_req_global_position mode_req_mission"),
  ...fields("I", "mode_req_offboard_signal mode_req_home_position mode_req_wind_and_flight_time_compliance"),
  ...fields("I", "mode_req_prevent_arming mode_req_manual_control mode_req_other"),
  ...fields("?", "angular_velocity_invalid attitude_invalid local_altitude_invalid local_position_invalid"),
  ...fields("?", "local_position_invalid_relaxed local_velocity_invalid global_position_invalid"),
  ...fields("?", "auto_mission_missing offboard_control_signal_lost home_position_invalid"),
  ...fields("?", "manual_control_signal_lost gcs_connection_lost"),
  ...fields("B", "battery_warning", [0, 1, 2, 3, 4, 6, 7, 10]),
  ...fields("?", "battery_low_remaining_time battery_unhealthy geofence_breached mission_failure"),
  ...fields("?", "vtol_fixed_wing_system_failure wind_limit_exceeded flight_time_limit_exceeded"),
  ...fields("?", "local_position_accuracy_low fd_critical_failure fd_esc_arming_failure"),
  ...fields("?", "fd_imbalanced_prop fd_motor_failure"),
];

const TYPES = new Map([["px4/Event", EVENT], ["px4/FailsafeFlags", FAILSAFE_FLAGS]]);

/** The input is invalid. */
class Rejected extends Error {}

const padding = (end, size) => (size - (end % size)) % size;

/** A payload as an object. */
function decode(message, form, data) {
  let isLittle = true;
  if (form === "cdr") {
    if (data.length < 4 || data[0] !== 0 || data[1] > 1) throw new Rejected("unknown encapsulation");
    isLittle = data[1] === 1;
    data = data.subarray(4);
  }
  const { places, end } = layout(message, form);
  const whole = end + padding(end, form === "cdr" ? 4 : alignment(message));
  const isRight = form === "cdr" ? end <= data.length && data.length <= whole : [end, whole].includes(data.length);
  if (!isRight) throw new Rejected(`${data.length} bytes instead of ${end}`);
  const view = new DataView(data.buffer, data.byteOffset, data.length);
  const value = {};
  for (const [name, letter, count] of message) {
    const { size, read } = KINDS[letter];
    const item = (_, index) => {
      const raw = view[read](places[name] + index * size, isLittle);
      if (letter === "?" && raw > 1) throw new Rejected(`${name} is neither 0 nor 1`);
      return letter === "?" ? raw === 1 : raw;
    };
    const items = Array.from({ length: count ?? 1 }, item);
    value[name] = count === null ? items[0] : items;
  }
  return value;
}

/** Encodes an object as a little-endian payload. */
function encode(message, form, value) {
  const whole = check(message, value);
  const { places, end } = layout(message, form);
  const head = form === "cdr" ? [0, 1, 0, 0] : [];
  const data = Buffer.alloc(head.length + end + (form === "cdr" ? 0 : padding(end, alignment(message))));
  data.set(head);
  const view = new DataView(data.buffer, data.byteOffset, data.length);
  for (const [name, letter] of message) {
    const { size, write } = KINDS[letter];
    whole[name].forEach((item, index) => view[write](head.length + places[name] + index * size, item, true));
  }
  return data;
}

/** Returns the items of every field. Throws if the fields are wrong or, in strict mode, if any rule is violated. */
function check(message, value, isStrict = false) {
  if (value === null || typeof value !== "object" || Array.isArray(value)) throw new Rejected("not an object");
  const has = (name) => Object.hasOwn(value, name);
  if (Object.keys(value).length !== message.length || !message.every(([name]) => has(name))) {
    throw new Rejected("other fields");
  }
  const whole = {};
  for (const [name, letter, count, known] of message) {
    const items = count === null ? [value[name]] : value[name];
    if (!Array.isArray(items) || items.length !== (count ?? 1)) throw new Rejected(`${name} has the wrong length`);
    whole[name] = items.map((item) => {
      const isRight = letter === "?" ? typeof item === "boolean" : isWhole(item) && item >= 0 && item <= KINDS[letter].most;
      if (!isRight) throw new Rejected(`${name} has the wrong type`);
      if (isStrict && known !== null && !known.includes(item)) throw new Rejected(`${name} is undocumented`);
      return letter === "Q" ? BigInt(item) : Number(item);
    });
  }
  return whole;
}

const isWhole = (item) => typeof item === "bigint" || Number.isInteger(item);

/** The offsets of the fields, and the end of the last field. PX4 sorts fields in memory by size. */
function layout(message, form) {
  const order = [...message];
  if (form !== "cdr") order.sort((left, right) => KINDS[right[1]].size - KINDS[left[1]].size);
  const places = {};
  let end = 0;
  for (const [name, letter, count] of order) {
    const { size } = KINDS[letter];
    places[name] = end + padding(end, size);
    end = places[name] + size * (count ?? 1);
  }
  return { places, end };
}

const alignment = (message) => Math.max(...message.map(([, letter]) => KINDS[letter].size));

module.exports = { TYPES, Rejected, alignment, check, decode, encode, layout, padding };
