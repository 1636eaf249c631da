// Checks that the configured program has a language server.

import { execFile } from "node:child_process";

/** The arguments that start the language server. */
export const SERVER = ["lsp"];

/** A reason why the language server can't be started, as a message for the user. */
export async function problemOf(program: string): Promise<string | undefined> {
  return new Promise((resolve) => {
    execFile(program, [...SERVER, "--help"], { timeout: 10_000 }, (error, _, errors) => {
      resolve(error ? message(program, error, errors) : undefined);
    });
  });
}

function message(program: string, error: Error & { code?: unknown }, errors: string): string {
  if (error.code === "ENOENT") {
    return (
      `The program \`${program}\` was not found. To install it, clone the uavspec repository and run ` +
      "`cargo install --path conformance`. If it is installed elsewhere, set `uavspec.path`."
    );
  }
  const reason = errors.trim().split("\n")[0] || error.message;
  return `\`${program} lsp\` can't be started: ${reason}. Update uavspec, or correct \`uavspec.path\`.`;
}
