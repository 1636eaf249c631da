#!/usr/bin/env node
"use strict";
// A testee for `uavspec test`, with the standard library only.
//
//     uavspec test -- node conformance/testees/node/testee.js

const { TYPES, Rejected, alignment, check, decode, encode, layout, padding } = require("./codec.js");

/** Integers that readers of JSON would lose are tagged. */
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

function member(question, name) {
  if (!Object.hasOwn(question, name)) throw new Error(`no ${name}`);
  return question[name];
}

function answer(question) {
  const op = member(question, "op");
  const message = TYPES.get(member(question, "type"));
  const form = question.format;
  if (!message || !Object.hasOwn(FORMATS, op) || !FORMATS[op].includes(form)) return { unsupported: true };
  if (op === "validate") return check(message, fromWire(member(question, "value")), true) && { ok: null };
  if (op === "layout") {
    const { places, end } = layout(message, form);
    return { ok: { size: end + padding(end, alignment(message)), size_no_padding: end, offsets: places } };
  }
  if (op === "encode") return { ok: encode(message, form, fromWire(member(question, "value"))).toString("base64") };
  const value = decode(message, form, Buffer.from(member(question, "bytes"), "base64"));
  return { ok: op === "decode" ? toWire(value) : encode(message, form, value).toString("base64") };
}

/** What is said to a line; nothing to what is no question, as it has no id that could be answered. */
function reply(line) {
  let question;
  try { question = JSON.parse(line); } catch { return undefined; }
  if (question?.op === "hello") return HELLO;
  if (typeof question?.id !== "number") return undefined;
  try { return { id: question.id, ...answer(question) }; } catch (error) {
    return { id: question.id, [error instanceof Rejected ? "rejected" : "error"]: error.message };
  }
}

// Lines are parted as bytes: what comes at once may be many of them, or a part of one.
let parts = [];
process.stdin.on("data", (chunk) => {
  for (let end = chunk.indexOf(10); end >= 0; end = chunk.indexOf(10)) {
    const said = reply(Buffer.concat([...parts, chunk.subarray(0, end)]).toString());
    if (said !== undefined) process.stdout.write(`${JSON.stringify(said)}\n`);
    [parts, chunk] = [[], chunk.subarray(end + 1)];
  }
  parts.push(chunk);
});
