// Validates each line of a file with a JSON Schema. Prints the number of lines.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const [modules, file, schema, ...referenced] = process.argv.slice(2);
const { default: Ajv } = createRequire(resolve(modules, "package.json"))("ajv/dist/2020.js");
const read = (path) => JSON.parse(readFileSync(path, "utf8"));
const validate = new Ajv({ strict: false, schemas: referenced.map(read) }).compile(read(schema));
const lines = readFileSync(file, "utf8").trimEnd().split("\n");
for (const line of lines) {
  if (!validate(JSON.parse(line))) {
    throw new Error(JSON.stringify(validate.errors));
  }
}
console.log(lines.length);
