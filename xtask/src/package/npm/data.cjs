"use strict";

const { readFileSync } = require("node:fs");
const { join } = require("node:path");

/** Reads a file of the package. Each call returns a new object, so callers can modify it. */
function read(...path) {
  return JSON.parse(readFileSync(join(__dirname, ...path), "utf8"));
}

function find(kind, name, ending) {
  if (!manifest()[kind].includes(name)) {
    throw new RangeError(`${JSON.stringify(name)} is not among the ${kind}; manifest().${kind} lists them`);
  }
  return read(kind === "bundles" ? "schemas" : kind, `${name}${ending}`);
}

function manifest() {
  return read("manifest.json");
}

exports.manifest = manifest;

exports.schema = function schema(name) {
  return find("schemas", name, ".schema.json");
};

exports.bundle = function bundle(name) {
  return find("bundles", name, ".bundle.schema.json");
};

exports.vectors = function vectors(name) {
  return find("vectors", name, ".vectors.json");
};
