#!/usr/bin/env node
"use strict";

// Runs the program, which npm installs as an optional dependency: one package for each platform.
const { spawn } = require("node:child_process");
const { optionalDependencies = {} } = require("../package.json");

const platform = `@uavspec/${process.platform}-${process.arch}`;

function program() {
  try {
    return require.resolve(`${platform}/bin/uavspec`);
  } catch {
    const help = platform in optionalDependencies
      ? `install ${platform}, for example with "npm install" without --omit=optional`
      : `there are packages for ${Object.keys(optionalDependencies).join(" and ")}; on other platforms, build uavspec from its source`;
    console.error(`error: the package ${platform} with the program is not installed\n  help: ${help}`);
    process.exit(2);
  }
}

// The program decides how it ends: after an interrupt, it first lands the UAVs that it commanded.
const signals = ["SIGHUP", "SIGINT", "SIGTERM"];
for (const signal of signals) {
  process.on(signal, () => child.kill(signal));
}

const child = spawn(program(), process.argv.slice(2), { stdio: "inherit" });

child.on("error", (error) => {
  console.error(`error: cannot run uavspec: ${error.message}`);
  process.exitCode = 2;
});
child.on("exit", (code, signal) => {
  if (signal === null) {
    process.exitCode = code;
  } else {
    signals.forEach((name) => process.removeAllListeners(name));
    process.kill(process.pid, signal);
  }
});
