// Tests of the configurations in the guide. Neovim uses its configuration; it is skipped if it isn't installed.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { parse } from "smol-toml";
import { program, repository, workspace } from "./client.mjs";
import { CONFIGURED } from "./workspaces.mjs";

const guide = fs.readFileSync(path.join(repository, "xtask/site/guide/editors.md"), "utf8");
const driver = path.join(repository, "xtask/editors/tests/neovim.lua");
const nvim = process.env.UAVSPEC_NVIM ?? "nvim";

/** The code blocks of a language. */
function blocks(language) {
  return [...guide.matchAll(new RegExp("^```" + language + "\\n(.*?)^```$", "gms"))].map(([, text]) => text);
}

/** The version of Neovim, such as 0.11, or undefined if it isn't installed. */
function neovimVersion() {
  const { stdout } = spawnSync(nvim, ["--version"], { encoding: "utf8" });
  return stdout ? /v(\d+\.\d+)/.exec(stdout)[1] : undefined;
}

const version = neovimVersion();
const isOld = version !== undefined && Number(version.split(".")[1]) < 11 && version.startsWith("0.");
const [recent, older] = blocks("lua");
const CONFIGURATIONS = [
  ["Neovim 0.11 or later", recent, isOld ? `Neovim ${version} is older` : false],
  ["Neovim 0.7 to 0.10", older, false],
];
for (const [name, configuration, reason] of CONFIGURATIONS) {
  test(`${name} uses each feature`, { skip: version ? reason : `${nvim} isn't installed` }, () => {
    const folder = workspace({ ...CONFIGURED, "init.lua": configuration });
    const PATH = [path.dirname(program), process.env.PATH].join(path.delimiter);
    const options = ["--headless", "--clean", "-u", "init.lua", "-c", `luafile ${driver}`];
    const env = { ...process.env, PATH };
    const { status, stdout } = spawnSync(nvim, options, { cwd: folder, encoding: "utf8", env });
    console.log(stdout);
    fs.rmSync(folder, { recursive: true });
    assert.equal(status, 0, stdout);
    assert.match(stdout, /^shutdown +\|/m);
  });
}

test("the configuration of Helix connects the files with the server", () => {
  const [text] = blocks("toml");
  const { language, "language-server": servers } = parse(text);
  assert.deepEqual({ ...servers.uavspec }, { command: "uavspec", args: ["lsp"] });
  assert.deepEqual(language[0]["file-types"], ["msg", "srv", "action"]);
  assert.deepEqual(language[0]["language-servers"], Object.keys(servers));
});
