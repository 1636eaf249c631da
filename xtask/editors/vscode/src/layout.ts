// The panel next to the editor that shows the memory layout of a document's messages.

import { randomBytes } from "node:crypto";
import * as vscode from "vscode";
import { page, type Picture } from "./page";

/** The delay between a change of the document and the request for its pictures, in milliseconds. */
const DELAY = 150;

/** Requests the pictures of a document from the language server. */
export type Requester = (document: vscode.Uri) => Promise<Picture[]>;

/** A panel that follows one document. */
export class LayoutPanel implements vscode.Disposable {
  private readonly panel: vscode.WebviewPanel;
  private readonly subscriptions: vscode.Disposable[];
  private timer: NodeJS.Timeout | undefined;
  private isOpen = true;

  constructor(
    readonly document: vscode.Uri,
    private readonly request: Requester,
    onClose: () => void,
  ) {
    const name = vscode.workspace.asRelativePath(document).split("/").pop();
    this.panel = vscode.window.createWebviewPanel(
      "uavspec.layout",
      `Layout of ${name}`,
      { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true },
      { enableScripts: false, localResourceRoots: [] },
    );
    this.subscriptions = [
      vscode.workspace.onDidChangeTextDocument(({ document }) => this.note(document)),
      vscode.workspace.onDidSaveTextDocument((document) => this.note(document)),
      this.panel.onDidDispose(() => {
        this.dispose();
        onClose();
      }),
    ];
    void this.update();
  }

  reveal(): void {
    this.panel.reveal(undefined, true);
  }

  async update(): Promise<void> {
    try {
      const pictures = await this.request(this.document);
      // The user may have closed the panel since the request.
      if (this.isOpen) {
        this.panel.webview.html = page(pictures, randomBytes(16).toString("hex"));
      }
    } catch (error) {
      void vscode.window.showErrorMessage(`The memory layout can't be shown: ${error}`);
    }
  }

  dispose(): void {
    this.isOpen = false;
    clearTimeout(this.timer);
    this.subscriptions.forEach((subscription) => subscription.dispose());
    this.panel.dispose();
  }

  /** Notes a change of a document. The layout also depends on the messages that other files define. */
  private note(document: vscode.TextDocument): void {
    if (document.languageId === "ros.msg" || document.uri.toString() === this.document.toString()) {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => void this.update(), DELAY);
    }
  }
}
