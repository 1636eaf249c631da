// Tests of the parts of the VS Code extension that don't require VS Code.

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { build } from "esbuild";
import { program, repository, session } from "./client.mjs";
import { PX4, ROS2 } from "./workspaces.mjs";

const extension = path.join(repository, "xtask/editors/vscode");
const read = (name) => fs.readFileSync(path.join(extension, name), "utf8");

/** Compiles and loads a module of the extension. The stubs replace imported modules. */
async function load(name, stubs = {}) {
  globalThis.stubs = stubs;
  const plugin = {
    name: "stubs",
    setup({ onResolve, onLoad }) {
      const namespace = "stubs";
      onResolve({ filter: /^vscode/ }, (found) => (found.path in stubs ? { path: found.path, namespace } : undefined));
      onLoad({ filter: /.*/, namespace }, (found) => ({ contents: `module.exports = globalThis.stubs["${found.path}"];` }));
    },
  };
  const options = { entryPoints: [path.join(extension, "src", name)], bundle: true, platform: "node", format: "esm" };
  const { outputFiles } = await build({ ...options, plugins: [plugin], write: false });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

test("the page of layouts runs no scripts and loads nothing", async () => {
  const { page } = await load("page.ts");
  const html = page([{ name: '<img src="x">', svg: "<svg><script>alert(1)</script>é</svg>" }], "abc");
  const policy = `default-src 'none'; img-src data:; style-src 'nonce-abc'`;
  assert.ok(html.includes(`<meta http-equiv="Content-Security-Policy" content="${policy}">`));
  assert.doesNotMatch(html, /<script|<img src="x"|<svg/);
  const [, data] = /src="data:image\/svg\+xml;base64,([^"]*)"/.exec(html);
  assert.equal(Buffer.from(data, "base64").toString(), "<svg><script>alert(1)</script>é</svg>");
  assert.match(page([], "abc"), /no PX4 message with a memory layout/);
});

test("a missing or unsuitable program is reported with instructions", async () => {
  const { problemOf } = await load("program.ts");
  assert.equal(await problemOf(program), undefined);
  assert.match(await problemOf("uavspec-absent"), /not found.*cargo install --path conformance.*uavspec\.path/);
  assert.match(await problemOf(process.execPath), /can't be started: .*Update uavspec/);
});

test("the server can be restarted after it failed to start", async () => {
  const commands = new Map();
  const disposable = { dispose() {} };
  let starts = 0;
  class LanguageClient {
    async start() {
      starts += 1;
      throw new Error("the server has ended");
    }

    // As in the client of VS Code.
    async dispose() {
      throw new Error("the client is not running and can't be stopped");
    }
  }
  const vscode = {
    commands: {
      registerCommand(name, run) {
        commands.set(name, run);
        return disposable;
      },
    },
    workspace: {
      getConfiguration: () => ({ get: () => program }),
      onDidChangeConfiguration: () => disposable,
    },
  };
  const { activate } = await load("extension.ts", { vscode, "vscode-languageclient/node": { LanguageClient } });
  await activate({ subscriptions: [] });
  await commands.get("uavspec.restart")();
  assert.equal(starts, 2);
});

/** The text of a snippet with its default values. */
function expand(body) {
  const names = new Map();
  const expandOne = (_, number, choice, value, transform) => {
    const text = choice?.split(",")[0] ?? value ?? names.get(number) ?? "";
    names.set(number, names.get(number) ?? text);
    return transform === undefined ? text : names.get(number).toLowerCase();
  };
  const placeholder = /\$\{?(\d+)(?:\|([^}]*)\||:([^}]*)|(\/[^ ]*\/[^ ]*\/downcase\}\/))?\}?/g;
  return body.join("\n").replace(placeholder, expandOne);
}

const SNIPPETS = JSON.parse(read("snippets.json"));
const HEADER = "# Summary\n\nuint64 timestamp  # [us] Time since system start\n\n";
for (const [name, { body, prefix }] of Object.entries(SNIPPETS)) {
  test(`the snippet "${name}" is valid`, async () => {
    const text = expand(body);
    assert.doesNotMatch(text, /\$/);
    const isPart = ["enum", "flags", "field", "topics", "ignore"].includes(prefix);
    const [files, file] = isPart || prefix === "message"
      ? [PX4, "msg/Snippet.msg"]
      : [ROS2, `src/plane_msgs/${prefix === "service" ? "srv/Snippet.srv" : "action/Snippet.action"}`];
    await session({ ...files, [file]: isPart ? HEADER + text : text }, {}, async (client) => {
      await client.open(file);
      const [symbol] = await client.ask("documentSymbol", file);
      assert.ok(symbol.children.length > 0, "the fields of the message");
      assert.ok(await client.ask("formatting", file, undefined, { options: { tabSize: 2, insertSpaces: true } }));
    });
  });
}

test("the manifest names existing files, and covers the commands of the code", () => {
  const { contributes } = JSON.parse(read("package.json"));
  const { languages, grammars, snippets, commands } = contributes;
  const files = [...languages, ...grammars, ...snippets].map(({ configuration, path }) => configuration ?? path);
  files.forEach((file) => JSON.parse(read(file)));
  const registered = [...read("src/extension.ts").matchAll(/registerCommand\("([^"]*)"/g)];
  assert.deepEqual(commands.map(({ command }) => command).sort(), registered.map(([, name]) => name).sort());
});
