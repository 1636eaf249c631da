// A client of the language server, made of the libraries that VS Code uses.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import {
  createProtocolConnection,
  ExitNotification,
  InitializedNotification,
  InitializeRequest,
  PublishDiagnosticsNotification,
  RegistrationRequest,
  ShutdownRequest,
  StreamMessageReader,
  StreamMessageWriter,
} from "vscode-languageserver-protocol/node";
import { TextDocument } from "vscode-languageserver-textdocument";

export const repository = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../../..");

/** The program under test. */
export const program = path.resolve(process.env.UAVSPEC ?? path.join(repository, "target/debug/uavspec"));

/** The time limit for an expected message, in milliseconds. It ends tests that fail. */
const LIMIT = 30_000;

/** Writes files into a new folder. The keys are paths. */
export function workspace(files) {
  const folder = fs.realpathSync(fs.mkdtempSync(path.join(os.tmpdir(), "uavspec-lsp-")));
  for (const [name, text] of Object.entries(files)) {
    const file = path.join(folder, name);
    fs.mkdirSync(path.dirname(file), { recursive: true });
    fs.writeFileSync(file, text);
  }
  return folder;
}

/** Starts a client in a new workspace for a test, and ends the session. */
export async function session(files, options, body) {
  const client = await Client.start(workspace(files), options);
  try {
    await body(client);
    assert.equal(await client.stop(), 0, "the exit status of the server");
  } finally {
    client.process.kill();
    fs.rmSync(client.folder, { recursive: true });
  }
}

/** A client with open documents in one folder. */
export class Client {
  documents = new Map();
  #published = new Map();
  #listeners = new Set();

  /** Starts the server and initializes it. */
  static async start(folder, { positionEncodings = ["utf-16"], resourceOperations = ["rename"] } = {}) {
    const client = new Client();
    client.folder = folder;
    client.process = spawn(program, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
    client.exit = new Promise((resolve) => client.process.once("exit", resolve));
    const { stdin, stdout } = client.process;
    const connection = createProtocolConnection(new StreamMessageReader(stdout), new StreamMessageWriter(stdin));
    client.connection = connection;
    connection.onNotification(PublishDiagnosticsNotification.type, ({ uri, diagnostics }) => {
      client.#published.set(uri, diagnostics);
      client.#listeners.forEach((listener) => listener());
    });
    client.registration = new Promise((resolve) => {
      connection.onRequest(RegistrationRequest.type, ({ registrations }) => resolve(registrations[0]));
    });
    connection.listen();
    const answer = await connection.sendRequest(InitializeRequest.type, {
      processId: process.pid,
      rootUri: null,
      workspaceFolders: [{ name: "test", uri: pathToFileURL(folder).href }],
      capabilities: {
        general: { positionEncodings },
        textDocument: { completion: { completionItem: { snippetSupport: true } } },
        workspace: {
          didChangeWatchedFiles: { dynamicRegistration: true },
          workspaceEdit: { documentChanges: true, resourceOperations },
        },
      },
    });
    client.capabilities = answer.capabilities;
    await connection.sendNotification(InitializedNotification.type, {});
    return client;
  }

  /** Ends the session. Returns the exit status of the server. */
  async stop() {
    await this.registration;
    await this.connection.sendRequest(ShutdownRequest.type);
    await this.connection.sendNotification(ExitNotification.type);
    const status = await this.exit;
    this.connection.dispose();
    return status;
  }

  uri(name) {
    return pathToFileURL(path.join(this.folder, name)).href;
  }

  /** Opens a document with the text of its file or another text. */
  async open(name, text = fs.readFileSync(path.join(this.folder, name), "utf8")) {
    const uri = this.uri(name);
    this.documents.set(name, TextDocument.create(uri, "ros.msg", 1, text));
    const textDocument = { uri, languageId: "ros.msg", version: 1, text };
    await this.connection.sendNotification("textDocument/didOpen", { textDocument });
  }

  /** Replaces the first occurrence of a text in an open document. An empty text is the end of the document. */
  async replace(name, old, text) {
    const document = this.documents.get(name);
    const start = old ? this.position(name, old) : document.positionAt(document.getText().length);
    const end = document.positionAt(document.offsetAt(start) + old.length);
    await this.change(name, [{ range: { start, end }, text }]);
  }

  async change(name, contentChanges) {
    const version = this.documents.get(name).version + 1;
    this.documents.set(name, TextDocument.update(this.documents.get(name), contentChanges, version));
    const textDocument = { uri: this.uri(name), version };
    await this.connection.sendNotification("textDocument/didChange", { textDocument, contentChanges });
  }

  async close(name) {
    this.documents.delete(name);
    await this.connection.sendNotification("textDocument/didClose", { textDocument: { uri: this.uri(name) } });
  }

  text(name) {
    return this.documents.get(name).getText();
  }

  /** The position of `|` in a part of a document, such as `uint8 mo|de`, or of the start of the part. */
  position(name, marked) {
    const mark = Math.max(marked.indexOf("|"), 0);
    const part = marked.slice(0, mark) + marked.slice(mark).replace("|", "");
    const start = this.text(name).indexOf(part);
    assert.notEqual(start, -1, `${name} lacks ${part}`);
    return this.documents.get(name).positionAt(start + mark);
  }

  /** Sends a request about a document and, if `marked` is given, about a position in it. */
  async ask(method, name, marked, more = {}) {
    const position = marked === undefined ? {} : { position: this.position(name, marked) };
    const textDocument = { uri: this.uri(name) };
    return this.connection.sendRequest(`textDocument/${method}`, { textDocument, ...position, ...more });
  }

  /** The text of an error response. */
  async refusal(method, name, marked, more) {
    const answer = await this.ask(method, name, marked, more).catch((error) => error);
    assert.ok(answer instanceof Error, `an error, found ${JSON.stringify(answer)}`);
    return answer.message;
  }

  /** The text of a document after edits. */
  edited(name, edits) {
    return TextDocument.applyEdits(this.documents.get(name), edits);
  }

  /** The part of a document within a range. */
  slice(name, range) {
    return this.documents.get(name).getText(range);
  }

  /** Waits for the next publication about a document. */
  async nextDiagnostics(name) {
    const before = this.#published.get(this.uri(name));
    await this.#until(() => this.#published.get(this.uri(name)) !== before, () => `${name}: no diagnostics`);
  }

  /** Waits until the published diagnostics of a document have these codes. Returns them. */
  async diagnostics(name, ...codes) {
    const uri = this.uri(name);
    const current = () => this.#published.get(uri);
    const found = () => current()?.map((diagnostic) => diagnostic.code ?? "");
    const isExpected = () => JSON.stringify(found()?.sort()) === JSON.stringify([...codes].sort());
    await this.#until(isExpected, () => `${name}: expected [${codes}], found [${found()}]`);
    return current();
  }

  /** Waits until a condition about the published diagnostics holds. */
  async #until(condition, message) {
    await new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(message())), LIMIT);
      const listener = () => {
        if (condition()) {
          this.#listeners.delete(listener);
          clearTimeout(timer);
          resolve();
        }
      };
      this.#listeners.add(listener);
      listener();
    });
  }
}
