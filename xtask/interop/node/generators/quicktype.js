// Adapter for quicktype: the generated JavaScript, with run-time checks, reads each case.

import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

import { InputData, JSONSchemaInput, JSONSchemaStore, quicktype } from "quicktype-core";

import { readJobs, serve } from "../protocol.js";

const require = createRequire(import.meta.url);
const work = resolve(process.argv[3]);

/** Finds documents by their URL. */
class Store extends JSONSchemaStore {
  constructor(documents) {
    super();
    this.documents = documents;
  }

  async fetch(address) {
    const document = this.documents.get(address);
    return document && JSON.parse(document.text);
  }
}

await serve("quicktype-core", async (documents) => {
  const { jobs } = readJobs();
  const readers = new Map();
  for (const group of groups(jobs)) {
    const module = await generate(documents, group);
    group.forEach((job) => readers.set(job.job, module[`toJob${job.job}`]));
  }
  return (_, { job }) => {
    const read = readers.get(job);
    return (instance) => {
      try {
        read(instance);
        return { valid: true };
      } catch (error) {
        return { valid: false, message: String(error.message ?? error).slice(0, 300) };
      }
    };
  };
});

/** Jobs whose schemas are in the same folder, or in the same bundle. */
function groups(jobs) {
  const found = new Map();
  for (const job of jobs) {
    const [address, pointer] = job.schema.split("#");
    const key = pointer ? address : address.replace(/[^/]*$/, "");
    found.set(key, [...(found.get(key) ?? []), job]);
  }
  return found.values();
}

/** The module with a type for each job. */
async function generate(documents, jobs) {
  const input = new JSONSchemaInput(new Store(documents));
  for (const { job, schema } of jobs) {
    await input.addSource({ name: `Job${job}`, schema: JSON.stringify({ $ref: schema }) });
  }
  const inputData = new InputData();
  inputData.addInput(input);
  const rendererOptions = { "runtime-typecheck": "true" };
  const { lines } = await quicktype({ inputData, lang: "javascript", combineClasses: false, rendererOptions });
  const path = join(work, `jobs-${jobs[0].job}.cjs`);
  writeFileSync(path, lines.join("\n"));
  return require(path);
}
