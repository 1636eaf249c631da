// Tests the documentation site in a browser, from local files: no requests, no errors, correct content.
//
//     cargo xtask docs && npm ci --prefix xtask/site/tests && node --test xtask/site/tests
//
// UAVSPEC_SITE is the folder of the site (default: target/site), UAVSPEC_CHROMIUM the path of a browser, and
// UAVSPEC_PICTURES a folder for screenshots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { after, before, beforeEach, describe, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const repository = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../../..");
const site = path.resolve(process.env.UAVSPEC_SITE ?? path.join(repository, "target/site"));
const axe = fs.readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

const BROWSERS = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];

function browserPath() {
  const runs = (name) => {
    try {
      return execFileSync("which", [name], { encoding: "utf8" }).trim();
    } catch {
      return undefined;
    }
  };
  const found = process.env.UAVSPEC_CHROMIUM ?? BROWSERS.map(runs).find(Boolean);
  assert.ok(found, "Chromium, or its path in UAVSPEC_CHROMIUM");
  return found;
}

function filesBelow(folder, ending) {
  const files = fs.readdirSync(folder, { recursive: true }).map((file) => file.replaceAll("\\", "/"));
  return files.filter((file) => file.endsWith(ending)).sort();
}

const address = (page) => pathToFileURL(path.join(site, page)).href;
const messages = filesBelow(path.join(site, "vectors/px4"), ".vectors.json").map((file) => file.split(".")[0]);
const ALL_PAGES = filesBelow(site, ".html").filter((page) => page !== "toc.html");
const SCHEMAS = filesBelow(path.join(site, "schemas"), ".schema.json").map((file) => `schemas/${file}`);
const PAGES = [
  "index.html",
  ...ALL_PAGES.filter((page) => /^(guide|start|project)\//.test(page)),
  "docs/conformance/README.html",
  "docs/flockwave/README.html",
  "docs/flockwave/error-codes.html",
  "docs/flockwave/error-codes/errors.html",
  "docs/flockwave/messages/UAV-INF.html",
  "docs/flockwave/types/UAVStatusInfo.html",
  "docs/flockwave/error-codes.uk.html",
  "docs/interop/README.html",
  "docs/px4/FailsafeFlags.uk.html",
  "docs/rules/PX-RANGE-01.html",
  "schemas/flockwave/BatteryInfo.schema.html",
  "schemas/uavspec/report.schema.html",
  ...messages.map((message) => `docs/px4/${message}.html`),
];

const ACCESSIBLE_PAGES = [
  "index.html",
  "docs/flockwave/error-codes.html",
  "docs/flockwave/error-codes/errors.html",
  "docs/px4/ArmingCheckReply.html",
  "docs/px4/FailsafeFlags.html",
  "docs/px4/FailsafeFlags.uk.html",
  "guide/lint.html",
  "schemas/px4/Event.schema.html",
];

let browser;
let page;
let complaints;

before(async () => {
  browser = await chromium.launch({ executablePath: browserPath(), args: ["--no-sandbox"] });
});

after(() => browser?.close());

async function open(width = 1440, colorScheme = "light") {
  await page?.context().close();
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme });
  page = await context.newPage();
  complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) {
      complaints.push(message.text());
    }
  });
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => {
    if (!request.url().startsWith("file:") && !request.url().startsWith("data:")) {
      complaints.push(`requests ${request.url()}`);
    }
  });
}

describe("pages", () => {
  for (const width of [360, 1440]) {
    for (const scheme of ["light", "dark"]) {
      test(`open without errors and fit ${width} pixels, ${scheme}`, async () => {
        await open(width, scheme);
        for (const name of PAGES) {
          await page.goto(address(name));
          await page.waitForSelector("main h1");
          const [content, shown] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
          assert.ok(content <= shown, `${name}: ${content} pixels of content in ${shown}`);
          const [red] = await page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor.match(/\d+/g).map(Number));
          assert.equal(red < 128, scheme === "dark", `${name} is ${scheme}`);
          if (process.env.UAVSPEC_PICTURES) {
            const picture = `${name.replaceAll("/", "-").replace(".html", "")}-${width}-${scheme}.png`;
            await page.screenshot({ path: path.join(process.env.UAVSPEC_PICTURES, picture) });
          }
        }
        assert.deepEqual(complaints, []);
      });
    }
  }

  // Loading each page would take minutes, so their contents are shown one after the other.
  test("have contents that fit a phone", async () => {
    await open(360);
    await page.goto(address("index.html"));
    assert.ok(ALL_PAGES.length > 700, `${ALL_PAGES.length} pages`);
    for (const name of ALL_PAGES.filter((one) => one !== "report.html")) {
      const [, content] = fs.readFileSync(path.join(site, name), "utf8").match(/<main>(.*)<\/main>/s);
      const width = await page.evaluate((html) => {
        const main = document.querySelector("main");
        main.innerHTML = html.replaceAll("<img ", "<img hidden ");
        main.querySelectorAll("table").forEach((table) => table.classList.add("stacked"));
        return document.documentElement.scrollWidth;
      }, content);
      assert.ok(width <= 360, `${name}: ${width} pixels`);
    }
  });

  test("pass the accessibility rules of axe", async () => {
    for (const [width, scheme] of [[1440, "light"], [1440, "dark"], [360, "light"]]) {
      await open(width, scheme);
      for (const name of ACCESSIBLE_PAGES.slice(0, width === 360 ? 1 : undefined)) {
        await page.goto(address(name));
        await page.evaluate(axe);
        // axe doesn't check the contrast of text on a gradient.
        await page.addStyleTag({ content: ".table-wrapper, pre, pre > code { background-image: none !important; }" });
        // The sidebar and the menu are the same on all pages.
        const { violations } = await page.evaluate(
          (isWhole) => globalThis.axe.run(isWhole ? document : "main", { iframes: false }),
          name === "index.html",
        );
        const found = violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map((node) => node.html).join(" ")}`);
        assert.deepEqual(found, [], `${name}, ${width}, ${scheme}`);
      }
    }
  });

  test("have no broken links", () => {
    const pages = filesBelow(site, ".html");
    const texts = new Map(pages.map((name) => [name, fs.readFileSync(path.join(site, name), "utf8")]));
    const ids = new Map();
    const idsOf = (name) => {
      if (!ids.has(name)) {
        ids.set(name, new Set([...texts.get(name).matchAll(/\sid="([^"]*)"/g)].map(([, id]) => id)));
      }
      return ids.get(name);
    };
    const broken = [];
    let links = 0;
    for (const [name, text] of texts) {
      for (const [, target] of text.matchAll(/\s(?:href|src)="([^"]*)"/g)) {
        if (/^[a-z]+:/i.test(target)) {
          continue;
        }
        links += 1;
        const [file, id] = decodeURIComponent(target.replaceAll("&amp;", "&")).split("#");
        const linked = file === "" ? name : path.posix.join(path.posix.dirname(name), file);
        const exists = fs.existsSync(path.join(site, linked));
        const hasId = !id || !texts.has(linked) || idsOf(linked).has(id);
        if (!exists || !hasId) {
          broken.push(`${name}: ${target}`);
        }
      }
    }
    assert.ok(links > 5000, `${links} links`);
    assert.deepEqual(broken, []);
  });

  test("print their text without controls", async () => {
    await open();
    await page.goto(address("docs/px4/FailsafeFlags.html"));
    await page.emulateMedia({ media: "print" });
    for (const hidden of [".composer", "#mdbook-sidebar", "#mdbook-menu-bar", ".nav-wrapper"]) {
      assert.equal(await page.locator(hidden).first().isVisible(), false, hidden);
    }
    assert.ok(await page.locator("#field-fd_motor_failure").locator("xpath=ancestor::tr").isVisible());
  });
});

describe("the start page", () => {
  test("shows three tasks with a command each, and a report", async () => {
    await open();
    await page.goto(address("index.html"));
    const tasks = page.locator(".tasks > section");
    assert.equal(await tasks.count(), 3);
    for (const task of await tasks.all()) {
      assert.match(await task.locator("pre").textContent(), /^\$ (cargo xtask|uavspec) /);
      assert.ok(await task.locator("> p > a").last().getAttribute("href"));
    }
    await page.frameLocator(".picture iframe").getByRole("heading", { name: "Does not conform" }).waitFor({ state: "attached" });
    assert.deepEqual(complaints, []);
  });
});

describe("the table of contents", () => {
  const titles = () =>
    page.locator("#mdbook-sidebar .chapter-link-wrapper > :first-child").evaluateAll((all) =>
      all.filter((one) => !one.matches(".header-in-summary")).map((one) => one.textContent.trim()),
    );

  test("has unique titles, and words for each rule", async () => {
    await open();
    await page.goto(address("index.html"));
    const all = await titles();
    assert.ok(all.length > 700, `${all.length} titles`);
    assert.deepEqual(all.filter((title, at) => all.indexOf(title) !== at), []);
    const rules = all.filter((title) => /\b(FW-UST-[A-Z]+|(FW|PX)-[A-Z-]+-\d+[A-Z]?)$/.test(title));
    assert.ok(rules.length > 150, `${rules.length} rules`);
    assert.deepEqual(rules.filter((title) => !/^[A-Z]\w*.* (FW|PX)-/.test(title)), ["PX-FSF-01", "PX-FSF-02"]);
  });

  test("is operated by keyboard", async () => {
    await open();
    await page.goto(address("index.html"));
    const group = page.getByRole("button", { name: "Chapters below Message envelope" });
    const rule = page.getByRole("link", { name: "Messages are objects FW-ENV-01" });
    await page.getByRole("button", { name: "Chapters below Rules of check" }).press("Enter");
    assert.equal(await rule.isVisible(), false);
    await group.press("Space");
    await page.getByRole("button", { name: "Chapters below Message envelope", expanded: true }).waitFor();
    await page.locator("#mdbook-sidebar .group", { hasText: "Message envelope" }).click();
    assert.equal(await rule.isVisible(), false);
    await group.press("Enter");
    await rule.press("Enter");
    await page.waitForURL(/FW-ENV-01\.html$/);
    assert.ok(await rule.isVisible(), "the current chapter is visible");
  });

  test("opens on a phone", async () => {
    await open(360);
    await page.goto(address("index.html"));
    const install = page.locator("#mdbook-sidebar").getByRole("link", { name: "Install", exact: true });
    assert.equal(await install.isVisible(), false);
    await page.getByRole("button", { name: "Table of contents" }).press("Enter");
    await install.click();
    await page.getByRole("heading", { level: 1, name: "Install" }).waitFor();
    assert.deepEqual(complaints, []);
  });
});

describe("schemas", () => {
  const text = (name) => fs.readFileSync(path.join(site, name), "utf8");

  test("have a page with each field, unit and value, and a link to the file", () => {
    assert.ok(SCHEMAS.length > 250, `${SCHEMAS.length} schemas`);
    for (const name of SCHEMAS.filter((one) => !one.includes(".bundle."))) {
      const html = text(name.replace(/json$/, "html"));
      const schema = JSON.parse(text(name));
      assert.ok(html.includes(`href="${path.basename(name)}"`), name);
      for (const [field, { $defs }] of Object.entries(schema.properties ?? {})) {
        const row = html.split(`<tr><td><code>${field}</code></td>`)[1]?.split("</tr>")[0];
        assert.ok(row, `${name}: ${field}`);
        const required = schema.required?.includes(field) ? "yes" : "no";
        assert.ok(row.includes(`<td>${required}</td>`), `${name}: ${field} is required: ${required}`);
        const unit = $defs?.annotations?.["x-unit"];
        assert.ok(!unit || row.includes(`<td>${unit}</td>`), `${name}: ${field} has the unit ${unit}`);
      }
      for (const { const: value } of schema.anyOf ?? []) {
        const escaped = JSON.stringify(value)?.replaceAll("&", "&amp;");
        assert.ok(value === undefined || html.includes(`<code>${escaped}</code>`), `${name}: ${value}`);
      }
    }
  });

  test("have an example that is a test vector", async () => {
    await open(360);
    for (const name of ["schemas/px4/BatteryStatus", "schemas/flockwave/UAV-INF.notification"]) {
      await page.goto(address(`${name}.schema.html`));
      const example = await page.locator("#example ~ pre").first().textContent();
      const { cases } = JSON.parse(text(`${name.replace("schemas", "vectors")}.vectors.json`));
      const valid = cases.filter((one) => one.valid).map((one) => JSON.stringify(one.json));
      assert.ok(valid.includes(JSON.stringify(JSON.parse(example))), name);
    }
  });

  test("are reached from the page of the message", async () => {
    await open();
    await page.goto(address("docs/px4/FailsafeFlags.html"));
    await page.getByRole("link", { name: "FailsafeFlags.schema.json" }).click();
    await page.getByRole("heading", { name: "FailsafeFlags (JSON Schema)" }).waitFor();
    await page.getByRole("cell", { name: "FailsafeFlags", exact: true }).getByRole("link").click();
    await page.waitForURL(/docs\/px4\/FailsafeFlags\.html$/);
  });
});

describe("the search", () => {
  beforeEach(() => open());

  for (const [words, expected] of [
    ["134", "docs/flockwave/error-codes/errors.html"],
    ["low battery", "docs/flockwave/error-codes/"],
    ["LOWBAT", "docs/flockwave/error-codes"],
    ["FailsafeFlags", "docs/px4/FailsafeFlags.html"],
    ["geofence_breached", "docs/px4/FailsafeFlags.html"],
    ["PX-RANGE-01", "docs/rules/PX-RANGE-01.html"],
    ["ArmingCheckReply schema", "docs/px4/ArmingCheckReply.html"],
    ["ArmingCheckReply.schema.json", "docs/px4/ArmingCheckReply.html"],
  ]) {
    test(`finds ${words} by keyboard`, async () => {
      await page.goto(address("index.html"));
      await page.keyboard.press("/");
      await page.keyboard.type(words);
      const results = page.locator("#mdbook-searchresults a");
      await results.first().waitFor();
      const found = await results.evaluateAll((links) => links.slice(0, 3).map((link) => link.href));
      assert.ok(found.some((link) => link.includes(expected)), found.join("\n"));
      assert.deepEqual(complaints, []);
    });
  }
});

describe("error codes", () => {
  beforeEach(async () => {
    await open();
    await page.goto(address("docs/flockwave/error-codes.html"));
  });

  const shown = () =>
    page.locator(".error-code-filter + * tbody tr:visible").evaluateAll((rows) => rows.map((row) => row.cells[0].textContent.trim()));

  test("are found by number, with their alternatives", async () => {
    await page.getByLabel("Find a code").fill("134");
    assert.deepEqual(await shown(), ["66", "134", "199"]);
    assert.equal(await page.getByRole("status").textContent(), "3 of 63 codes");
  });

  test("are found by abbreviation and by word, in any case", async () => {
    await page.getByLabel("Find a code").fill("lowbat Almost");
    assert.deepEqual(await shown(), ["199"]);
    await page.getByLabel("Find a code").fill("no such words");
    assert.deepEqual(await shown(), []);
  });

  test("are filtered by severity", async () => {
    for (const severity of ["informational", "warning", "error"]) {
      await page.getByRole("checkbox", { name: severity }).uncheck();
    }
    const codes = await shown();
    assert.ok(codes.length > 0 && codes.every((code) => Number(code) >= 192), codes.join());
  });

  test("are found in tables that omit an empty column", async () => {
    const words = await page.locator(".error-code-filter").getAttribute("data-words");
    await page.setContent(`<div class="error-code-filter"></div><table>
      <thead><tr><th>Code</th><th>Severity</th><th>Meaning</th><th>Alternatives</th></tr></thead>
      <tbody><tr><td>64</td><td>warning</td><td>Gusts</td><td>128</td></tr><tr><td>128</td><td>error</td><td>Storm</td><td>64</td></tr></tbody>
    </table>`);
    await page.locator(".error-code-filter").evaluate((place, text) => place.setAttribute("data-words", text), words);
    await page.addScriptTag({ path: path.join(site, "docs/error-codes.js") });
    await page.getByLabel("Find a code").fill("128");
    assert.deepEqual(await shown(), ["64", "128"]);
    await page.getByRole("checkbox", { name: "warning (1)" }).uncheck();
    assert.deepEqual(await shown(), ["128"]);
  });

  test("show code, meaning and alternatives on a phone", async () => {
    await open(360);
    await page.goto(address("docs/flockwave/error-codes.html"));
    const search = page.getByLabel("Find a code");
    assert.ok((await search.boundingBox()).y < 400, "the search is near the top");
    await search.fill("134");
    assert.deepEqual(await shown(), ["66", "134", "199"]);
    const row = page.getByRole("row").filter({ has: page.getByRole("link", { name: "134", exact: true }).first() }).nth(1);
    for (const cell of await row.getByRole("cell").all()) {
      const { x, width } = await cell.boundingBox();
      assert.ok(x >= 0 && x + width <= 360, "a cell is within the screen");
    }
    assert.match(await row.innerText(), /^134\nLOWBAT\n.*error\nBattery charge is too low.*\n.*66.*199$/s);
    const label = await row.getByRole("cell").last().evaluate((cell) => getComputedStyle(cell, "::before").content);
    assert.match(label, /Alternatives/);
  });

  test("link to their alternatives", async () => {
    await page.getByLabel("Find a code").fill("66");
    await page.getByRole("row", { name: "134 LOWBAT" }).getByRole("link", { name: "199" }).last().click();
    await page.waitForURL(/#code-199$/);
    await page.getByRole("heading", { name: "199 LOWBAT" }).waitFor();
  });
});

// Sets the controls of a message to a JSON value, without keyboard events.
function choose(value) {
  const set = (control, property, chosen) => {
    control[property] = chosen;
    control.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const word = (number) => (number === null ? "NaN" : Object.is(number, -0) ? "-0" : String(number));
  const own = (scope, name, kind) =>
    [...scope.querySelectorAll(kind)].filter(
      (one) => one.querySelector("code").textContent.replace(/\[\d+\]$/, "") === name && one.parentElement.closest("details") === (scope.matches("details") ? scope : null),
    );
  const fill = (scope, object) => {
    for (const [name, part] of Object.entries(object)) {
      const details = own(scope, name, "details");
      if (details.length > 0) {
        (Array.isArray(part) ? part : [part]).forEach((one, index) => fill(details[index], one));
        continue;
      }
      const [masks] = own(scope, name, "fieldset.composer-flags");
      if (masks) {
        masks.querySelectorAll("input").forEach((box) => set(box, "checked", (BigInt(part) & BigInt(box.value)) !== 0n));
        continue;
      }
      const [field] = own(scope, name, ".composer-field");
      const control = field.querySelector("input, select");
      if (control.type === "checkbox") {
        set(control, "checked", part);
      } else if (control.tagName === "SELECT" && ![...control.options].some((option) => option.value === word(part))) {
        set(control, "value", "");
        set(field.querySelector("input"), "value", word(part));
      } else {
        set(control, "value", Array.isArray(part) ? part.map(word).join(" ") : typeof part === "string" ? part : word(part));
      }
    }
  };
  document.querySelector(".composer-buttons button").click();
  fill(document.querySelector(".composer"), value);
  const rows = document.querySelector(".composer-bytes").textContent.split("\n");
  return {
    status: document.querySelector(".composer-status").textContent,
    bytes: rows.map((row) => row.trim().split(/\s+/).slice(1).join("")).join(""),
    json: document.querySelector(".composer-json").textContent,
  };
}

// Integers beyond JavaScript's range are written as strings of digits.
function exact(text) {
  return JSON.parse(text.replace(/(?<=[:[,\s])-?\d{16,}(?=[,\]}\s])/g, '"$&"'));
}

describe("other languages", () => {
  beforeEach(() => open());

  test("are linked, and have language attributes", async () => {
    await page.goto(address("docs/px4/FailsafeFlags.html"));
    await page.getByRole("link", { name: "Українська" }).first().click();
    await page.waitForURL(/FailsafeFlags\.uk\.html$/);
    const motor = page.getByRole("checkbox", { name: "fd_motor_failure" });
    assert.match(await motor.locator("xpath=..").textContent(), /мотор/i);
    assert.equal(await motor.evaluate((box) => box.closest("[lang]").lang), "uk");
    await motor.check();
    assert.equal(await page.locator(".composer-status").textContent(), "байт 84 дорівнює 01");
    await page.locator("main").getByRole("link", { name: "English" }).click();
    await page.waitForURL(/FailsafeFlags\.html$/);
    assert.deepEqual(complaints, []);
  });

  test("have error codes that are found by translated words", async () => {
    await page.goto(address("docs/flockwave/error-codes.uk.html"));
    await page.getByLabel("Знайти код").fill("компас");
    assert.match(await page.getByRole("status").textContent(), /^кодів \d+ з 63$/);
    await page.getByLabel("Знайти код").fill("134");
    assert.equal(await page.getByRole("status").textContent(), "кодів 3 з 63");
  });
});

describe("composing", () => {
  beforeEach(() => open());

  test("shows labels and groups of the definition", async () => {
    await page.goto(address("docs/px4/FailsafeFlags.html"));
    const links = page.getByRole("group", { name: "Control links" });
    await links.getByLabel("Ground station link lost").check();
    await page.getByLabel("Most severe battery warning").selectOption({ value: "2" });
    await page.getByLabel("Motor failed").focus();
    await page.keyboard.press("Space");
    assert.equal(await page.locator(".composer-status").textContent(), "byte 84 is 01");
    const json = JSON.parse(await page.locator(".composer-json").textContent());
    const chosen = Object.entries(json).filter(([, value]) => value).map(([name]) => name);
    assert.deepEqual(chosen, ["gcs_connection_lost", "battery_warning", "fd_motor_failure"]);
    assert.deepEqual(complaints, []);
  });

  for (const message of messages) {
    test(`gives the bytes and the JSON of the codec: ${message}`, async () => {
      await page.goto(address(`docs/px4/${message}.html`));
      const text = fs.readFileSync(path.join(site, `vectors/px4/${message}.vectors.json`), "utf8");
      const read = JSON.parse(text).cases;
      const cases = exact(text).cases.map((one, index) => ({ ...one, expected: read[index].json }));
      const composed = cases.filter((one) => one.valid && one.json && one.uorb);
      assert.ok(composed.length > 0);
      for (const { id, json, uorb, expected } of composed) {
        const seen = await page.evaluate(choose, json);
        assert.equal(seen.bytes, uorb.padEnd(seen.bytes.length, "0"), id);
        assert.deepEqual(JSON.parse(seen.json), expected, id);
      }
      assert.deepEqual(complaints, []);
    });
  }

  test("accepts integer limits, signed masks, and names with a meaning in JavaScript", async () => {
    await page.goto(address("docs/px4/Event.html"));
    const data = await page.locator(".composer").evaluate((place) => {
      const message = JSON.parse(place.dataset.message);
      const fields = [
        { name: "constructor", type: "uint64", offset: 0, values: [["18446744073709551615", "TOP", "$& of <b>all</b>"]] },
        { name: "least", type: "int64", offset: 8 },
        { name: "mask", type: "int8", offset: 16, flags: [["1", "FIRST", ""], ["-128", "SIGN", ""]] },
      ];
      return JSON.stringify({ ...message, name: "Kite", size: 24, fields });
    });
    await page.setContent("<div class='composer'></div>");
    await page.locator(".composer").evaluate((place, text) => place.setAttribute("data-message", text), data);
    await page.addScriptTag({ path: path.join(site, "docs/composer.js") });
    await page.getByLabel("constructor", { exact: true }).selectOption("18446744073709551615 TOP: $& of <b>all</b>");
    await page.getByLabel("least").fill("-9223372036854775808");
    await page.getByLabel("FIRST").check();
    await page.getByLabel("SIGN").check();
    const json = await page.locator(".composer-json").textContent();
    assert.equal(json, '{\n  "constructor": 18446744073709551615,\n  "least": -9223372036854775808,\n  "mask": -127\n}');
    const bytes = await page.locator(".composer-bytes").textContent();
    assert.match(bytes, /ff ff ff ff ff ff ff ff\n\s+8 00 00 00 00 00 00 00 80\n\s+16 81 00/);
    assert.deepEqual(complaints, []);
  });

  test("shows errors next to the control", async () => {
    await page.goto(address("docs/px4/FailsafeFlags.html"));
    const field = page.getByLabel("mode_req_attitude");
    for (const [wrong, expected] of [["-1", "found -1"], ["4294967296", "found 4294967296"], ["many", "expected an integer"]]) {
      await field.fill(wrong);
      assert.equal(await field.getAttribute("aria-invalid"), "true");
      const described = (await field.getAttribute("aria-describedby")).split(" ").at(-1);
      assert.match(await page.locator(`#${described}`).textContent(), new RegExp(expected));
    }
    assert.ok(await page.getByRole("button", { name: "Copy JSON" }).isDisabled());
    await field.fill("0x10");
    assert.ok(await page.getByRole("button", { name: "Copy JSON" }).isEnabled());
    assert.equal(await field.getAttribute("aria-invalid"), "false");
    assert.match(await page.locator(".composer-json").textContent(), /"mode_req_attitude": 16,/);
  });
});
