// Measures the time from a change of a document to the publication of its diagnostics.
//
//     cargo build --release -p uavspec
//     UAVSPEC=target/release/uavspec node xtask/editors/tests/latency.mjs FOLDER FILE [EDITS]
//
// FILE is the path of a definition in FOLDER. Each edit adds or removes a finding.

import { performance } from "node:perf_hooks";
import { Client } from "./client.mjs";

const [folder, name, edits = "40"] = process.argv.slice(2);
const started = performance.now();
const client = await Client.start(folder);
await client.open(name);
await client.ask("documentSymbol", name);
const opened = performance.now() - started;

const BROKEN = "\nunit8 latency\n";
const times = [];
for (let at = 0; at < Number(edits); at += 1) {
  const [old, text] = at % 2 === 0 ? ["", BROKEN] : [BROKEN, ""];
  const start = performance.now();
  const published = client.nextDiagnostics(name);
  await client.replace(name, old, text);
  await published;
  times.push(performance.now() - start);
}
await client.stop();

times.sort((left, right) => left - right);
const shown = (time) => `${time.toFixed(1)} ms`;
const median = times[Math.floor(times.length / 2)];
console.log(`opened after ${shown(opened)}`);
console.log(`${times.length} edits: median ${shown(median)}, maximum ${shown(times.at(-1))}`);
