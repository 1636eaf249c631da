#!/usr/bin/env node
"use strict";
// A testee for `uavspec test`; uses no packages.
//
//     uavspec test -- node conformance/testees/node/testee.js

const { TYPES, Rejected, alignment, check, decode, encode, layout, padding } = require("./codec.js");

/** Tags integers that other JSON parsers would round. */
function toWire(value) {
  if (typeof value === "bigint") {
    const isExact = value >= Number.MIN_SAFE_INTEGER && value <= Number.MAX_SAFE_INTEGER;
    return isExact ? Number(value) : { [value > 0n ? "$u64" : "$i64"]: value.toString() };
  }
  if (Array.isArray(value)) return value.map(toWire);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, toWire(item)]));
}

const TAGS = { $u64: BigInt, $i64: BigInt, $f: (text) => Number(text.replace("inf", "Infinity")) };

function fromWire(value) {
  if (Array.isArray(value)) return value.map(fromWire);
  if (value === null || typeof value !== "object") return value;
  const [tag, ...others] = Object.keys(value);
  if (others.length === 0 && Object.hasOwn(TAGS, tag)) return TAGS[tag](value[tag]);
  return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, fromWire(item)]));
}

const BINARY = ["uorb", "cdr"];
const FORMATS = { decode: BINARY, encode: BINARY, roundtrip: BINARY, validate: [undefined], layout: ["uorb"] };
const HELLO = {
  op: "hello", protocol: 1, name: "node", version: "1", ops: Object.keys(FORMATS), types: [...TYPES.keys()],
};

function member(request, name) {
  if (!Object.hasOwn(request, name)) throw new Error(`${name} is missing`);
  return request[name];
}

function answer(request) {
  const op = member(request, "op");
  const message = TYPES.get(member(request, "type"));
  const form = request.format;
  if (!message || !Object.hasOwn(FORMATS, op) || !FORMATS[op].includes(form)) return { unsupported: true };
  if (op === "validate") return check(message, fromWire(member(request, "value")), true) && { ok: null };
  if (op === "layout") {
    const { places, end } = layout(message, form);
    return { ok: { size: end + padding(end, alignment(message)), size_no_padding: end, offsets: places } };
  }
  if (op === "encode") return { ok: encode(message, form, fromWire(member(request, "value"))).toString("base64") };
  const value = decode(message, form, Buffer.from(member(request, "bytes"), "base64"));
  return { ok: op === "decode" ? toWire(value) : encode(message, form, value).toString("base64") };
}

/** The response to a line, or undefined for a line that is not a request and therefore has no id. */
function reply(line) {
  let request;
  try { request = JSON.parse(line); } catch { return undefined; }
  if (request?.op === "hello") return HELLO;
  if (typeof request?.id !== "number") return undefined;
  try { return { id: request.id, ...answer(request) }; } catch (error) {
    return { id: request.id, [error instanceof Rejected ? "rejected" : "error"]: error.message };
  }
}

// Input is split into lines as bytes: a chunk may contain several lines, or part of one.
let parts = [];
process.stdin.on("data", (chunk) => {
  for (let end = chunk.indexOf(10); end >= 0; end = chunk.indexOf(10)) {
    const response = reply(Buffer.concat([...parts, chunk.subarray(0, end)]).toString());
    if (response !== undefined) process.stdout.write(`${JSON.stringify(response)}\n`);
    [parts, chunk] = [[], chunk.subarray(end + 1)];
  }
  parts.push(chunk);
});
