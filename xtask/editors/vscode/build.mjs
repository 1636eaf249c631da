// Bundles the extension into `dist`, with the licences of the libraries that the bundle contains.

import fs from "node:fs";
import path from "node:path";
import { build } from "esbuild";

const { metafile } = await build({
  entryPoints: ["src/extension.ts"],
  outfile: "dist/extension.js",
  bundle: true,
  external: ["vscode"],
  metafile: true,
  minify: true,
  platform: "node",
  target: "node20",
});

/** The folder of the library that contains a file. */
const library = (file) => /^.*node_modules\/(@[^/]+\/)?[^/]+/.exec(file)?.[0];
const libraries = [...new Set(Object.keys(metafile.inputs).map(library).filter(Boolean))].sort();

function licence(folder) {
  const { name, version, license } = JSON.parse(fs.readFileSync(path.join(folder, "package.json"), "utf8"));
  const file = fs.readdirSync(folder).find((file) => /^licen[cs]e/i.test(file));
  if (!file) {
    throw new Error(`${folder} contains no licence`);
  }
  return `${name} ${version} (${license})\n\n${fs.readFileSync(path.join(folder, file), "utf8").trim()}\n`;
}

fs.writeFileSync("dist/licences.txt", libraries.map(licence).join(`\n${"-".repeat(80)}\n\n`));
