// Adapter for json-schema-to-typescript: the TypeScript compiler checks each case as a constant of the generated type.

import { dirname } from "node:path";

import { compile } from "json-schema-to-typescript";
import ts from "typescript";

import { readJobs, text, versionOf, write } from "../protocol.js";

const OPTIONS = { strict: true, noEmit: true, target: ts.ScriptTarget.ES2022, types: [] };

const { documents, jobs } = readJobs();
write({ version: versionOf("json-schema-to-typescript") });

const modules = new Map();
for (const job of jobs) {
  try {
    modules.set(`/job${job.job}.ts`, await moduleOf(job));
  } catch (error) {
    write({ job: job.job, error: text(error) });
  }
}
const program = ts.createProgram([...modules.keys()], OPTIONS, host());
for (const [path, module] of modules) {
  report(module, program.getSourceFile(path));
}

/** The generated types of a schema, followed by one line for each case. */
async function moduleOf(job) {
  const [address, pointer] = job.schema.split("#");
  const { path, text } = documents.get(address);
  const reference = pointer ? { $defs: JSON.parse(text).$defs, $ref: `#${pointer}` } : { $ref: path };
  const { $defs, $ref } = reference;
  const wrapper = { $defs, type: "object", properties: { value: { $ref } }, required: ["value"] };
  const types = await compile(wrapper, "Wrapper", { bannerComment: "", format: false, cwd: `${dirname(path)}/` });
  const cases = job.cases.map((instance, index) => `export const case${index}: Wrapper["value"] = ${instance};`);
  return { job, start: types.split("\n").length, code: [types, ...cases].join("\n") };
}

/** Reads modules from memory, and the standard library from the disk. */
function host() {
  const found = ts.createCompilerHost(OPTIONS);
  const { getSourceFile, fileExists } = found;
  found.getSourceFile = (path, options) =>
    modules.has(path) ? ts.createSourceFile(path, modules.get(path).code, options) : getSourceFile(path, options);
  found.fileExists = (path) => modules.has(path) || fileExists(path);
  return found;
}

function report({ job, start }, source) {
  const errors = new Map();
  for (const diagnostic of [...program.getSyntacticDiagnostics(source), ...program.getSemanticDiagnostics(source)]) {
    const { line } = source.getLineAndCharacterOfPosition(diagnostic.start);
    errors.set(line - start, ts.flattenDiagnosticMessageText(diagnostic.messageText, " ").slice(0, 300));
  }
  const inTypes = [...errors].find(([line]) => line < 0);
  if (inTypes) {
    return write({ job: job.job, error: inTypes[1] });
  }
  write({ job: job.job });
  for (const index of job.cases.keys()) {
    write({ job: job.job, case: index, valid: !errors.has(index), message: errors.get(index) });
  }
}
