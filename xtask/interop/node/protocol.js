// Shared code of the JavaScript adapters. They read jobs, and write one JSON line for each schema and case; see
// xtask/interop/README.md.

import { readFileSync, writeSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);

/**
 * Runs all jobs in the file given on the command line.
 *
 * @param {string} name the tested package, whose version is written
 * @param {(documents: Map<string, Document>) => (schema: string, job: Job) => Check | Promise<Check>} prepare
 *   receives all documents by URL, and returns a function that compiles a schema; that function returns a function
 *   that checks the text of a case
 */
export async function serve(name, prepare) {
  const { documents, jobs } = readJobs();
  write({ version: versionOf(name) });
  const compile = await prepare(documents);
  for (const job of jobs) {
    await run(job, compile);
  }
}

/** Reads all jobs, and the path and text of all documents by URL. */
export function readJobs() {
  const lines = readFileSync(process.argv[2], "utf8").split("\n").filter(Boolean).map((line) => JSON.parse(line));
  const documents = lines
    .filter((line) => line.document)
    .map(({ document, path }) => [document, { path, text: readFileSync(path, "utf8") }]);
  return { documents: new Map(documents), jobs: lines.filter((line) => line.schema) };
}

/** The version of an installed package. Read from the disk, because some packages don't export their package.json. */
export function versionOf(name) {
  const folder = require.resolve.paths(name).map((path) => `${path}/${name}`);
  for (const path of folder) {
    try {
      return JSON.parse(readFileSync(`${path}/package.json`, "utf8")).version;
    } catch {
      // Try the next folder.
    }
  }
  return "unknown";
}

async function run(job, compile) {
  let check;
  try {
    check = await compile(job.schema, job);
  } catch (error) {
    return write({ job: job.job, error: text(error) });
  }
  write({ job: job.job });
  for (const [index, instance] of job.cases.entries()) {
    write({ job: job.job, case: index, ...(await verdict(check, instance)) });
  }
}

async function verdict(check, instance) {
  try {
    return await check(instance);
  } catch (error) {
    return { error: text(error) };
  }
}

/** The message of an error. */
export function text(error) {
  return String(error?.message ?? error).slice(0, 300);
}

/** Writes synchronously, so that verdicts before a crash are preserved. */
export function write(line) {
  let rest = Buffer.from(`${JSON.stringify(line)}\n`);
  while (rest.length > 0) {
    try {
      rest = rest.subarray(writeSync(1, rest));
    } catch (error) {
      // The pipe is full; try again.
      if (error.code !== "EAGAIN") throw error;
    }
  }
}
