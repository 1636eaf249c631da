// Tests of the language server over the protocol.
//
//     cargo build -p uavspec && npm ci --prefix xtask/editors && npm test --prefix xtask/editors
//
// UAVSPEC is the path of the program (default: target/debug/uavspec).

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { TextDocument } from "vscode-languageserver-textdocument";
import { session } from "./client.mjs";
import { CONFIGURED, PX4, ROS2 } from "./workspaces.mjs";

const GLIDER = "msg/Glider.msg";
const TOW = "msg/Tow.msg";
const WIND = "msg/Wind.msg";
const CODES = "pages/codes.md";

/** A test with a separate session in a new workspace. */
const withClient = (name, files, body, options = {}) =>
  test(name, { timeout: 90_000 }, () => session(files, options, body));

const configured = (name, body, options) => withClient(name, CONFIGURED, body, options);

/** The whole document, for requests about a range. */
const ALL = { start: { line: 0, character: 0 }, end: { line: 9999, character: 0 } };

const FORMAT = { options: { tabSize: 2, insertSpaces: true } };

const actions = (client, name, only) =>
  client.ask("codeAction", name, undefined, { range: ALL, context: { diagnostics: [], only } });

/** The texts of locations, with their files: `msg/Glider.msg: PHASE_TOW`. */
async function shown(client, locations) {
  const texts = [locations].flat().map(({ uri, range }) => {
    const name = path.relative(client.folder, fileURLToPath(uri)).replaceAll("\\", "/");
    const lines = fs.readFileSync(path.join(client.folder, name), "utf8").split("\n");
    assert.equal(range.start.line, range.end.line, "a range in one line");
    return `${name}: ${lines[range.start.line].slice(range.start.character, range.end.character)}`;
  });
  return texts.sort();
}

const labels = (items) => items.map((item) => item.label);

// Diagnostics

configured("diagnostics follow the lines that are typed", async (client) => {
  await client.open(GLIDER);
  await client.replace(GLIDER, "", "\nunit8 flaps # [-] Position of the flaps\n");
  const [finding] = await client.diagnostics(GLIDER, "unknown-type");
  assert.equal(client.slice(GLIDER, finding.range), "unit8");
  assert.match(finding.message, /no message `unit8`/);
  assert.deepEqual([finding.severity, finding.source], [1, "uavspec"]);
  await client.replace(GLIDER, "unit8 flaps # [-] Position of the flaps\n", "uint8");
  const [half] = await client.diagnostics(GLIDER, "missing-name");
  assert.equal(client.slice(GLIDER, half.range), "uint8");
  await client.replace(GLIDER, "", " flaps # [-] Position of the flaps\n");
  await client.diagnostics(GLIDER);
});

configured("opening a document publishes the findings in its text", async (client) => {
  await client.open(GLIDER, CONFIGURED[GLIDER].replace("Wind[2]", "Wnd[2]"));
  await client.diagnostics(GLIDER, "unknown-type");
  await client.open(TOW, `${CONFIGURED[TOW]}x\n`);
  await client.diagnostics(TOW, "missing-name");
});

configured("a request directly after a change doesn't suppress the diagnostics", async (client) => {
  await client.open(GLIDER);
  for (const name of ["Wxnd", "Wynd", "Wznd"]) {
    const change = client.replace(GLIDER, "Wind[2]", `${name}[2]`);
    const answer = client.ask("hover", GLIDER, "phase");
    await Promise.all([change, answer]);
    const [finding] = await client.diagnostics(GLIDER, "unknown-type");
    assert.match(finding.message, new RegExp(name));
    await client.replace(GLIDER, `${name}[2]`, "Wind[2]");
    await client.diagnostics(GLIDER);
  }
});

configured("open documents take precedence over files until they are closed", async (client) => {
  await client.open(GLIDER);
  await client.open(TOW);
  const members = async () => (await client.ask("hover", TOW, "Glider.PHA|SE")).contents.value;
  assert.match(await members(), /PHASE_FREE/);
  await client.replace(GLIDER, "PHASE_FREE", "PHASE_LANDED");
  assert.match(await members(), /PHASE_LANDED/);
  assert.doesNotMatch(await members(), /PHASE_FREE/);
  await client.replace(GLIDER, "Wind[2]", "Wnd[2]");
  await client.diagnostics(GLIDER, "unknown-type");
  await client.close(GLIDER);
  await client.diagnostics(GLIDER);
  assert.match(await members(), /PHASE_FREE/);
});

configured("the server reads files that changed", async (client) => {
  const registration = await client.registration;
  assert.equal(registration.method, "workspace/didChangeWatchedFiles");
  assert.match(registration.registerOptions.watchers[0].globPattern, /\*\.msg.*uavspec\.toml/);
  const notify = (name, type) => {
    const changes = [{ uri: client.uri(name), type }];
    return client.connection.sendNotification("workspace/didChangeWatchedFiles", { changes });
  };
  const file = path.join(client.folder, WIND);
  fs.renameSync(file, `${file}.old`);
  await notify(WIND, 3);
  await client.diagnostics(GLIDER, "unknown-type");
  fs.renameSync(`${file}.old`, file);
  await notify(WIND, 1);
  await client.diagnostics(GLIDER);
});

configured("an invalid configuration file is reported, and its correction restores the project", async (client) => {
  await client.open(GLIDER);
  await client.open("uavspec.toml");
  await client.replace("uavspec.toml", 'dialect = "px4"', 'dialect = "px5"');
  const [finding] = await client.diagnostics("uavspec.toml", "");
  assert.match(finding.message, /unknown variant `px5`/);
  await client.replace("uavspec.toml", "px5", "px4");
  await client.diagnostics("uavspec.toml");
  assert.ok(await client.ask("hover", GLIDER, "si|nk"), "the text about a field");
});

configured("a document outside the project doesn't affect the project", async (client) => {
  await client.open(GLIDER);
  await client.open("README.md", "# Gliders\n");
  assert.equal(await client.ask("hover", "README.md", "Gl|iders"), null);
  assert.ok(await client.ask("hover", GLIDER, "si|nk"), "the text about a field");
});

// Edits

configured("changes count UTF-16 code units", async (client) => {
  await client.open(GLIDER);
  await client.replace(GLIDER, "𝟎 °C", "𝟏 °C 🛩");
  await client.replace(GLIDER, " 🛩”", "” [m]");
  await client.replace(GLIDER, "# Behind", "# «𝟐» Behind");
  const edits = await client.ask("formatting", GLIDER, undefined, FORMAT);
  const text = edits.map(({ newText }) => newText).join("");
  assert.match(text, /Sink rate in air “at 𝟏 °C” \[m\]\n/);
  assert.match(text, /# «𝟐» Behind a tow plane\n/);
});

const utf8 = { positionEncodings: ["utf-8", "utf-16"] };
const countsBytes = async (client) => {
  assert.equal(client.capabilities.positionEncoding, "utf-8");
  await client.open(GLIDER);
  const lines = PX4[GLIDER].split("\n");
  const line = lines.findIndex((line) => line.includes("𝟎"));
  const character = Buffer.byteLength(lines[line].split("𝟎")[0]);
  const range = { start: { line, character }, end: { line, character: character + Buffer.byteLength("𝟎") } };
  const textDocument = { uri: client.uri(GLIDER), version: 2 };
  const contentChanges = [{ range, text: "9" }];
  await client.connection.sendNotification("textDocument/didChange", { textDocument, contentChanges });
  const [message] = await client.ask("documentSymbol", GLIDER);
  assert.equal(message.children.length, 6);
  const edits = await client.ask("formatting", GLIDER, undefined, FORMAT);
  const text = edits.map(({ newText }) => newText).join("");
  assert.ok(text.includes("“at 9 °C”"), text);
};
withClient("positions count bytes if the client offers them", PX4, countsBytes, utf8);

configured("a change of several parts is applied in order", async (client) => {
  await client.open(WIND);
  const start = { line: 0, character: 0 };
  await client.change(WIND, [
    { range: { start, end: start }, text: "# é\n" },
    { range: { start: { line: 0, character: 2 }, end: { line: 0, character: 3 } }, text: "Air" },
    { range: { start: { line: 0, character: 5 }, end: { line: 1, character: 1 } }, text: ":" },
  ]);
  assert.match(client.text(WIND), /^# Air: Wind over ground\n/);
  const [symbol] = await client.ask("documentSymbol", WIND);
  assert.equal(symbol.detail, "Air: Wind over ground");
  await client.change(WIND, [{ text: PX4[TOW] }]);
  assert.equal((await client.ask("documentSymbol", WIND))[0].detail, "State of a tow plane");
});

configured("a quick fix corrects one finding, and the fix of all corrects all", async (client) => {
  const broken = CONFIGURED[GLIDER].replace("[@enum PHASE]", "[enum PHASE]").replace("float32 sink", "float32  sink");
  await client.open(GLIDER, broken);
  await client.diagnostics(GLIDER, "annotation-near-miss", "repeated-white-space");
  const fixes = await actions(client, GLIDER, ["quickfix"]);
  const codes = fixes.map((fix) => fix.diagnostics[0].code).sort();
  assert.deepEqual(codes, ["annotation-near-miss", "repeated-white-space"]);
  const fix = fixes.find((fix) => fix.title.includes("annotation-near-miss"));
  const text = client.edited(GLIDER, fix.edit.changes[client.uri(GLIDER)]);
  assert.equal(text, broken.replace("[enum PHASE]", "[@enum PHASE]"));
  const [all, ...others] = await actions(client, GLIDER, ["source.fixAll"]);
  assert.deepEqual([all.kind, others], ["source.fixAll.uavspec", []]);
  assert.equal(client.edited(GLIDER, all.edit.changes[client.uri(GLIDER)]), CONFIGURED[GLIDER]);
});

configured("formatting aligns comments, and keeps a document with errors", async (client) => {
  await client.open(GLIDER);
  const formatted = client.edited(GLIDER, await client.ask("formatting", GLIDER, undefined, FORMAT));
  assert.match(formatted, /\nuint8 PHASE_TOW = 0   # Behind.*\nuint8 PHASE_FREE = 1  # Released\n/);
  await client.change(GLIDER, [{ text: formatted }]);
  assert.deepEqual(await client.ask("formatting", GLIDER, undefined, FORMAT), []);
  await client.replace(GLIDER, "Wind[2]", "Wind[2");
  assert.equal(await client.ask("formatting", GLIDER, undefined, FORMAT), null);
});

// Texts

configured("hover texts state the type, the unit, the range and the offset of a field", async (client) => {
  await client.open(GLIDER);
  const { contents, range } = await client.ask("hover", GLIDER, "si|nk");
  assert.equal(client.slice(GLIDER, range), "sink");
  const facts = ["`float32 sink`", "Sink rate in air", "unit: m/s (metres per second)", "offset 8, 4 of 48 bytes"];
  facts.forEach((fact) => assert.ok(contents.value.includes(fact), `${fact} in ${contents.value}`));
  assert.match(contents.value, /range: \\?-5 to 20/);
});

configured("hover texts about other items", async (client) => {
  await client.open(GLIDER);
  await client.open(CODES);
  const text = async (name, marked) => (await client.ask("hover", name, marked)).contents.value;
  const message = await text(GLIDER, "Wi|nd[2]");
  assert.match(message, /`gliders\/Wind`[^]*Wind over ground[^]*topics: `wind`[^]*16 bytes[^]*hash: 0x[0-9a-f]{8}\n/);
  assert.match(message, /type hash: RIHS01_[0-9a-f]{64}/);
  assert.match(await text(GLIDER, "PHASE_TO|W"), /`PHASE_TOW = 0`[^]*Behind a tow plane[^]*`phase`/);
  assert.match(await text(GLIDER, "[@enum PHA|SE]"), /PHASE_TOW[^]*PHASE_FREE/);
  assert.match(await text(GLIDER, "[m/|s]"), /metres per second/);
  assert.match(await text(CODES, "code 13|0"), /`130 LOWBAT`[^]*Battery critical[^]*severity: error[^]*`64 LOWBAT`/);
  assert.equal(await client.ask("hover", GLIDER, "in a|ir"), null);
});

configured("inlay hints show offsets and padding, in the requested lines", async (client) => {
  await client.open(GLIDER);
  const hints = await client.ask("inlayHint", GLIDER, undefined, { range: ALL });
  const shown = hints.map(({ position, label }) => {
    const line = client.text(GLIDER).split("\n")[position.line];
    return `${line.slice(0, position.character)} ${label}`;
  });
  // The largest fields come first in memory.
  const expected = ["uint64 timestamp @0", "uint8 phase @12, then 3 padding", "float32 sink @8", "Wind[2] winds @16"];
  assert.deepEqual(shown, expected);
  const range = { start: { line: 7, character: 0 }, end: { line: 8, character: 0 } };
  assert.deepEqual(labels(await client.ask("inlayHint", GLIDER, undefined, { range })), ["@8"]);
});

configured("the pictures of layouts follow the text", async (client) => {
  await client.open(GLIDER);
  const textDocument = { uri: client.uri(GLIDER) };
  const pictures = () => client.connection.sendRequest("uavspec/layout", { textDocument });
  const [picture, ...others] = await pictures();
  assert.deepEqual([picture.name, others], ["Glider", []]);
  assert.match(picture.svg, /<svg [^]*48 bytes[^]*winds[^]*<\/svg>/);
  await client.replace(GLIDER, "Wind[2] winds", "Wind[3] gusts");
  assert.match((await pictures())[0].svg, /64 bytes[^]*gusts/);
  await client.open(CODES);
  const page = { uri: client.uri(CODES) };
  assert.deepEqual(await client.connection.sendRequest("uavspec/layout", { textDocument: page }), []);
});

// Navigation

configured("definitions and references lead to the places of names", async (client) => {
  await client.open(GLIDER);
  await client.open(TOW);
  await client.open(CODES);
  const definition = async (name, marked) => shown(client, await client.ask("definition", name, marked));
  const context = { includeDeclaration: true };
  const references = async (name, marked) => shown(client, await client.ask("references", name, marked, { context }));
  assert.deepEqual(await definition(GLIDER, "Wi|nd[2]"), [`${WIND}: `], "the start of the file");
  assert.deepEqual(await definition(TOW, "Gl|ider.PHASE"), [`${GLIDER}: `]);
  assert.deepEqual(await definition(CODES, "code 13|0"), [`${CODES}: 130`]);
  const prefixes = [`${GLIDER}: PHASE`, `${GLIDER}: PHASE_TOW`, `${TOW}: PHASE`];
  assert.deepEqual(await references(GLIDER, "PHASE_TO|W"), prefixes);
  assert.deepEqual(await references(GLIDER, "Wi|nd[2]"), [`${GLIDER}: Wind`, `${WIND}: `]);
  assert.deepEqual(await references(CODES, "  1|30 "), [`${CODES}: 130`, `${CODES}: 130`]);
});

configured("highlights are the occurrences in the document", async (client) => {
  await client.open(GLIDER);
  const found = await client.ask("documentHighlight", GLIDER, "PHASE_TO|W");
  const texts = found.map(({ range, kind }) => [client.slice(GLIDER, range), kind]);
  assert.deepEqual(texts, [["PHASE_TOW", 3], ["PHASE", 2]]);
});

configured("symbols of documents and of the workspace", async (client) => {
  await client.open(GLIDER);
  await client.open(CODES);
  const [message] = await client.ask("documentSymbol", GLIDER);
  const children = message.children.map(({ name, detail }) => `${name}: ${detail}`);
  assert.deepEqual([message.name, message.detail], ["Glider", "State of a glider"]);
  const expected = ["timestamp: uint64 [us]", "PHASE_TOW: 0", "PHASE_FREE: 1", "phase: uint8"];
  assert.deepEqual(children, [...expected, "sink: float32 [m/s]", "winds: Wind[2]"]);
  const [page] = await client.ask("documentSymbol", CODES);
  const codes = page.children.flatMap(({ name, children }) => children.map((code) => `${name}: ${code.name}`));
  assert.deepEqual(codes, ["Warnings (codes 64-127): 64", "Errors (codes 128-191): 130"]);
  const search = async (query) => {
    const found = await client.connection.sendRequest("workspace/symbol", { query });
    return found.map(({ name, containerName }) => `${containerName}/${name}`);
  };
  assert.deepEqual(await search("lowbat"), ["codes/64 LOWBAT", "codes/130 LOWBAT"]);
  assert.deepEqual(await search("wind"), ["Glider/winds", "gliders/Wind"]);
});

configured("semantic tokens name types, fields, constants and annotations", async (client) => {
  await client.open(GLIDER);
  const { tokenTypes } = client.capabilities.semanticTokensProvider.legend;
  const { data } = await client.ask("semanticTokens/full", GLIDER);
  const found = new Map();
  let [line, character] = [0, 0];
  for (let at = 0; at < data.length; at += 5) {
    character = data[at] === 0 ? character + data[at + 1] : data[at + 1];
    line += data[at];
    const range = { start: { line, character }, end: { line, character: character + data[at + 2] } };
    found.set(client.slice(GLIDER, range), tokenTypes[data[at + 3]]);
  }
  const expected = { uint64: "type", timestamp: "property", PHASE_TOW: "enumMember", Wind: "struct", 1: "number" };
  for (const [text, type] of Object.entries({ ...expected, "[m/s]": "decorator", "# Released": "comment" })) {
    assert.equal(found.get(text), type, text);
  }
  assert.equal(found.get(" Sink rate in air “at 𝟎 °C”"), "comment", "text after non-ASCII characters");
});

configured("folds are blocks of declarations, and sections of pages", async (client) => {
  await client.open(GLIDER);
  await client.open(CODES);
  const folds = async (name) =>
    (await client.ask("foldingRange", name)).map(({ startLine, endLine, kind }) => [startLine, endLine, kind]);
  assert.deepEqual(await folds(GLIDER), [[4, 8, "region"]]);
  const sections = (await folds(CODES)).map(([start]) => client.text(CODES).split("\n")[start]);
  assert.deepEqual(sections, ["# Codes of a fleet", "## Warnings (codes 64-127)", "## Errors (codes 128-191)"]);
});

// Completion

configured("completion offers what fits the text before the cursor", async (client) => {
  await client.open(GLIDER);
  await client.open(TOW);
  await client.open(CODES);
  const complete = async (name, marked) => client.ask("completion", name, marked);
  const types = labels(await complete(GLIDER, "|float32"));
  for (const type of ["uint8", "float64", "Wind", "Tow"]) {
    assert.ok(types.includes(type), type);
  }
  assert.ok(!types.includes("string"), "PX4 has no strings");
  const units = await complete(GLIDER, "[|m/s]");
  assert.equal(units.find(({ label }) => label === "m/s").detail, "metres per second");
  const range = (await complete(GLIDER, "[@ra|nge")).find(({ label }) => label === "@range");
  assert.equal(client.slice(GLIDER, range.textEdit.range), "@ra");
  assert.match(range.textEdit.newText, /^@range \$\{1:\w+\}, \$\{2:\w+\}$/);
  assert.deepEqual(labels(await complete(GLIDER, "[@enum |PHASE")), ["PHASE", "Glider.", "Tow."]);
  assert.deepEqual(labels(await complete(TOW, "[@enum Glider.|PHASE")), ["PHASE"]);
  assert.deepEqual(labels(await complete(GLIDER, "# TOPICS |glider")), ["glider"]);
  const codes = await complete(CODES, "use code |130");
  assert.deepEqual(codes.map(({ label, detail }) => [label, detail]), [["64", "LOWBAT"], ["130", "LOWBAT"]]);
});

configured("completion works in lines that can't be parsed", async (client) => {
  await client.open(GLIDER);
  await client.replace(GLIDER, "", "\nWi");
  assert.ok(labels(await client.ask("completion", GLIDER, "\nWi|")).includes("Wind"));
  await client.replace(GLIDER, "\nWi", "\nuint8 flaps # [");
  assert.ok(labels(await client.ask("completion", GLIDER, "flaps # [|")).includes("rad"));
  await client.replace(GLIDER, "flaps # [", "flaps # uavspec:ignore un");
  assert.ok(labels(await client.ask("completion", GLIDER, "ignore un|")).includes("unit-missing"));
});

// Renaming

/** Applies a rename to the files on disk. */
function applyRename(client, { documentChanges }) {
  const { folder } = client;
  for (const change of documentChanges) {
    if (change.kind === "rename") {
      fs.renameSync(fileURLToPath(change.oldUri), fileURLToPath(change.newUri));
      continue;
    }
    const file = fileURLToPath(change.textDocument.uri);
    const document = TextDocument.create(change.textDocument.uri, "ros.msg", 1, fs.readFileSync(file, "utf8"));
    fs.writeFileSync(file, TextDocument.applyEdits(document, change.edits));
  }
  return (name) => fs.readFileSync(path.join(folder, name), "utf8");
}

configured("a field is renamed, with the names in annotations", async (client) => {
  const name = "msg/Flaps.msg";
  const fields = (array) => `uint8 used  # [@count ${array}] Used entries\nfloat32[4] ${array}  # [rad] Angles\n`;
  fs.writeFileSync(path.join(client.folder, name), `# Flaps\n\n${fields("angles")}`);
  await client.open(name);
  const { range, placeholder } = await client.ask("prepareRename", name, "ang|les  #");
  assert.deepEqual([client.slice(name, range), placeholder], ["angles", "angles"]);
  const edit = await client.ask("rename", name, "ang|les  #", { newName: "deflections" });
  assert.equal(applyRename(client, edit)(name), `# Flaps\n\n${fields("deflections")}`);
});

configured("a constant is renamed", async (client) => {
  await client.open(GLIDER);
  const edit = await client.ask("rename", GLIDER, "PHASE_TO|W", { newName: "PHASE_TOWED" });
  assert.equal(applyRename(client, edit)(GLIDER), PX4[GLIDER].replace("PHASE_TOW", "PHASE_TOWED"));
});

configured("a message is renamed together with its file", async (client) => {
  await client.open(GLIDER);
  const read = applyRename(client, await client.ask("rename", GLIDER, "Wi|nd[2]", { newName: "Breeze" }));
  assert.equal(read(GLIDER), PX4[GLIDER].replace("Wind[2]", "Breeze[2]"));
  assert.equal(read("msg/Breeze.msg"), PX4[WIND]);
  assert.ok(!fs.existsSync(path.join(client.folder, WIND)));
});

configured("a rename that would change the meaning is refused with the reason", async (client) => {
  for (const name of [GLIDER, TOW, CODES]) {
    await client.open(name);
  }
  const refusals = [
    [TOW, "uint8 ph|ase", "state", /version is still 1: raise MESSAGE_VERSION to 2/],
    [GLIDER, "[@enum PHA|SE]", "STAGE", /a prefix belongs to several constants/],
    [GLIDER, "PHASE_TO|W", "TOW", /no longer belong to the same enums/],
    [GLIDER, "si|nk", "phase", /duplicate field phase/],
    [GLIDER, "si|nk", "1x", /`1x` is not a valid name/],
    [GLIDER, "Wi|nd[2]", "Tow", /Tow\.msg exists/],
    [CODES, "code 13|0", "131", /can't be renamed/],
    [GLIDER, "in a|ir", "x", /no name here/],
  ];
  for (const [name, marked, newName, reason] of refusals) {
    assert.match(await client.refusal("rename", name, marked, { newName }), reason);
  }
});

const withoutFiles = { resourceOperations: [] };
const refusesFile = async (client) => {
  await client.open(GLIDER);
  const refusal = await client.refusal("rename", GLIDER, "Wi|nd[2]", { newName: "Breeze" });
  assert.match(refusal, /this editor can't rename files/);
};
withClient("a message isn't renamed if the editor can't rename files", PX4, refusesFile, withoutFiles);

// Projects without a configuration file

withClient("a folder of PX4 messages requires no configuration file", PX4, async (client) => {
  await client.open(GLIDER);
  assert.deepEqual(await shown(client, await client.ask("definition", GLIDER, "Wi|nd[2]")), [`${WIND}: `]);
  assert.match((await client.ask("hover", GLIDER, "si|nk")).contents.value, /offset 8, 4 of 48 bytes/);
  await client.replace(GLIDER, "Wind[2]", "Wnd[2]");
  await client.diagnostics(GLIDER, "unknown-type");
});

const PAGE = { ...PX4, [CODES]: CONFIGURED[CODES] };
withClient("an open page with error codes requires no configuration file", PAGE, async (client) => {
  await client.open(CODES);
  assert.match((await client.ask("hover", CODES, "code 13|0")).contents.value, /Battery critical/);
});

const PLANE = "src/plane_msgs/msg/Plane.msg";
const TRIM = "src/plane_msgs/srv/Trim.srv";
const FLAP = "src/wing_msgs/msg/Flap.msg";

withClient("packages of a ROS 2 workspace refer to each other", ROS2, async (client) => {
  await client.open(PLANE);
  assert.deepEqual(await shown(client, await client.ask("definition", PLANE, "Fl|ap")), [`${FLAP}: `]);
  assert.match((await client.ask("hover", PLANE, "Fl|ap")).contents.value, /`wing_msgs\/Flap`[^]*RIHS01_/);
  const types = labels(await client.ask("completion", PLANE, "|string"));
  assert.ok(types.includes("wing_msgs/Flap") && types.includes("wstring"), types.join(" "));
  assert.deepEqual(await client.ask("inlayHint", PLANE, undefined, { range: ALL }), [], "ROS 2 has no uORB layout");
  await client.replace(PLANE, "wing_msgs/Flap", "wing_msgs/Flp");
  await client.diagnostics(PLANE, "unknown-type");
});

withClient("a reference to an unknown package is a note", ROS2, async (client) => {
  await client.open(PLANE);
  await client.replace(PLANE, "wing_msgs/Flap", "tail_msgs/Flap");
  const [finding] = await client.diagnostics(PLANE, "unknown-package");
  assert.equal(finding.severity, 3);
});

withClient("both parts of a service contain names", ROS2, async (client) => {
  await client.open(TRIM);
  const parts = await client.ask("documentSymbol", TRIM);
  assert.deepEqual(parts.map(({ children }) => children.map(({ name }) => name)), [["flap"], ["success"]]);
  assert.deepEqual(await shown(client, await client.ask("definition", TRIM, "Fl|ap flap")), [`${FLAP}: `]);
  assert.match((await client.ask("hover", TRIM, "succ|ess")).contents.value, /True if it moved/);
});

withClient("a message is renamed in all packages, messages and services", ROS2, async (client) => {
  await client.open(PLANE);
  const context = { includeDeclaration: false };
  const references = await client.ask("references", PLANE, "Fl|ap", { context });
  assert.deepEqual(await shown(client, references), [`${PLANE}: Flap`, `${TRIM}: Flap`]);
  const read = applyRename(client, await client.ask("rename", PLANE, "Fl|ap", { newName: "Spoiler" }));
  assert.equal(read(PLANE), ROS2[PLANE].replace("wing_msgs/Flap", "wing_msgs/Spoiler"));
  assert.equal(read(TRIM), ROS2[TRIM].replace("wing_msgs/Flap", "wing_msgs/Spoiler"));
  assert.equal(read("src/wing_msgs/msg/Spoiler.msg"), ROS2[FLAP]);
});

// The protocol

configured("an unknown or malformed request is an error, and the session continues", async (client) => {
  const answer = (method, params) => client.connection.sendRequest(method, params).catch((error) => error);
  const code = async (method, params) => (await answer(method, params)).code;
  assert.equal(await code("uavspec/unknown", {}), -32601);
  assert.equal(await code("textDocument/hover", { textDocument: 1 }), -32602);
  await client.connection.sendNotification("textDocument/didOpen", { textDocument: {} });
  await client.open(GLIDER);
  assert.ok(await client.ask("hover", GLIDER, "si|nk"));
});
