// What all adapters of JavaScript share: they read the jobs, and write a line of JSON for each schema and each case.
// xtask/interop/README.md describes both.

import { readFileSync, writeSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);

/**
 * Runs all jobs of the file that the command line names.
 *
 * @param {string} name the package that does the work, whose version is written
 * @param {(documents: Map<string, Document>) => (schema: string, job: Job) => Judge | Promise<Judge>} prepare
 *   takes all documents by their address, and gives the function that compiles a schema, which in turn gives the
 *   function that judges the text of a case
 */
export async function serve(name, prepare) {
  const { documents, jobs } = readJobs();
  write({ version: versionOf(name) });
  const compile = await prepare(documents);
  for (const job of jobs) {
    await run(job, compile);
  }
}

/** All jobs, and all documents with their path and text by their address. */
export function readJobs() {
  const lines = readFileSync(process.argv[2], "utf8").split("\n").filter(Boolean).map((line) => JSON.parse(line));
  const documents = lines
    .filter((line) => line.document)
    .map(({ document, path }) => [document, { path, text: readFileSync(path, "utf8") }]);
  return { documents: new Map(documents), jobs: lines.filter((line) => line.schema) };
}

/** The version of an installed package. Not all packages export their package.json, so it is read from the disk. */
export function versionOf(name) {
  const folder = require.resolve.paths(name).map((path) => `${path}/${name}`);
  for (const path of folder) {
    try {
      return JSON.parse(readFileSync(`${path}/package.json`, "utf8")).version;
    } catch {
      // It is in one of the other folders.
    }
  }
  return "unknown";
}

async function run(job, compile) {
  let judge;
  try {
    judge = await compile(job.schema, job);
  } catch (error) {
    return write({ job: job.job, error: text(error) });
  }
  write({ job: job.job });
  for (const [index, instance] of job.cases.entries()) {
    write({ job: job.job, case: index, ...(await verdict(judge, instance)) });
  }
}

async function verdict(judge, instance) {
  try {
    return await judge(instance);
  } catch (error) {
    return { error: text(error) };
  }
}

/** What an error says. */
export function text(error) {
  return String(error?.message ?? error).slice(0, 300);
}

/** Writes at once, so that what was judged before a crash is known. */
export function write(line) {
  let rest = Buffer.from(`${JSON.stringify(line)}\n`);
  while (rest.length > 0) {
    try {
      rest = rest.subarray(writeSync(1, rest));
    } catch (error) {
      // The pipe is full: the reader will empty it.
      if (error.code !== "EAGAIN") throw error;
    }
  }
}
