// Connects VS Code with the language server of uavspec.

import * as vscode from "vscode";
import { LanguageClient, type LanguageClientOptions } from "vscode-languageclient/node";
import { LayoutPanel } from "./layout";
import type { Picture } from "./page";
import { problemOf, SERVER } from "./program";

/** The files that the server reads. Patterns also match if another extension gives the files another language. */
const SELECTOR = ["**/*.{msg,srv,action}", "**/*.{md,adoc,po}", "**/uavspec.toml"];

let client: LanguageClient | undefined;
const panels = new Map<string, LayoutPanel>();

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  context.subscriptions.push(
    vscode.commands.registerCommand("uavspec.showLayout", showLayout),
    vscode.commands.registerCommand("uavspec.restart", restart),
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("uavspec.path")) {
        void restart();
      }
    }),
    { dispose: () => panels.forEach((panel) => panel.dispose()) },
  );
  await start();
}

export async function deactivate(): Promise<void> {
  await stop();
}

async function start(): Promise<void> {
  const program = vscode.workspace.getConfiguration("uavspec").get("path", "uavspec");
  const problem = await problemOf(program);
  if (problem) {
    void report(problem);
    return;
  }
  const options: LanguageClientOptions = {
    documentSelector: SELECTOR.map((pattern) => ({ scheme: "file", pattern })),
  };
  client = new LanguageClient("uavspec", "uavspec", { command: program, args: SERVER }, options);
  // The client shows the reason if it can't start, and the command to restart it remains available.
  await client.start().catch(() => undefined);
}

async function stop(): Promise<void> {
  const stopping = client;
  client = undefined;
  // A client whose server failed to start can't be stopped, and must not prevent a restart.
  await stopping?.dispose().catch(() => undefined);
}

async function restart(): Promise<void> {
  await stop();
  await start();
  await Promise.all([...panels.values()].map((panel) => panel.update()));
}

/** Shows a problem with the program. */
async function report(problem: string): Promise<void> {
  const open = "Open Settings";
  if ((await vscode.window.showErrorMessage(problem, open)) === open) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "uavspec.path");
  }
}

/** Shows the memory layout of the messages in the active editor. */
function showLayout(): void {
  const document = vscode.window.activeTextEditor?.document.uri;
  if (!document) {
    void vscode.window.showInformationMessage("Open a .msg, .srv or .action file first.");
    return;
  }
  const key = document.toString();
  const panel = panels.get(key);
  if (panel) {
    panel.reveal();
  } else {
    panels.set(key, new LayoutPanel(document, requestLayout, () => panels.delete(key)));
  }
}

async function requestLayout(document: vscode.Uri): Promise<Picture[]> {
  if (!client) {
    throw new Error("the language server isn't running");
  }
  const uri = client.code2ProtocolConverter.asUri(document);
  return (await client.sendRequest<Picture[] | null>("uavspec/layout", { textDocument: { uri } })) ?? [];
}
