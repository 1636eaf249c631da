// A form that composes a message and shows it as JSON and as uORB bytes.
(() => {
  "use strict";

  // By type: the size in bytes, a function that writes a value to memory, and the bounds of integers.
  const SCALARS = {
    bool: { size: 1, put: (view, at, value) => view.setUint8(at, value ? 1 : 0) },
    float32: { size: 4, put: (view, at, value) => view.setFloat32(at, value, true) },
    float64: { size: 8, put: (view, at, value) => view.setFloat64(at, value, true) },
  };
  for (const bits of [8, 16, 32, 64]) {
    const most = 2n ** BigInt(bits);
    const put = (view, at, value) => {
      for (let byte = 0; byte < bits / 8; byte += 1) {
        view.setUint8(at + byte, Number((value >> BigInt(8 * byte)) & 0xffn));
      }
    };
    SCALARS[`uint${bits}`] = { size: bits / 8, put, low: 0n, high: most - 1n };
    SCALARS[`int${bits}`] = { size: bits / 8, put, low: -most / 2n, high: most / 2n - 1n };
  }
  SCALARS.byte = SCALARS.uint8;
  SCALARS.char = SCALARS.uint8;

  // Input that is not a valid value of the field.
  class InvalidValue extends Error {}

  // Texts of the user interface, in the language of the page.
  let words = {};

  let controls = 0;

  function fill(text, parts) {
    return text.replace(/\{(\w+)\}/g, (_, name) => parts[name]);
  }

  function element(name, properties = {}, children = []) {
    const created = Object.assign(document.createElement(name), properties);
    created.append(...children);
    return created;
  }

  function integer(text, { low, high }) {
    if (!/^[+-]?(\d+|0x[0-9a-f]+)$/i.test(text)) {
      throw new InvalidValue(fill(words.expectedInteger, { low, high }));
    }
    const digits = text.replace(/^[+-]/, "");
    const value = text.startsWith("-") ? -BigInt(digits) : BigInt(digits);
    if (value < low || value > high) {
      throw new InvalidValue(fill(words.outOfRange, { value: text, low, high }));
    }
    return value;
  }

  function float(text, type) {
    if (/^nan$/i.test(text)) {
      return NaN;
    }
    if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text)) {
      throw new InvalidValue(words.expectedNumber);
    }
    const value = type === "float32" ? Math.fround(Number(text)) : Number(text);
    if (!Number.isFinite(value)) {
      const most = type === "float32" ? 3.4028234663852886e38 : Number.MAX_VALUE;
      throw new InvalidValue(fill(words.outOfRange, { value: text, low: -most, high: most }));
    }
    return value;
  }

  function parse(text, type) {
    const trimmed = text.trim();
    return SCALARS[type].high === undefined ? float(trimmed, type) : integer(trimmed, SCALARS[type]);
  }

  // The shortest text that parses to the same value. NaN is written as null.
  function json(value, type) {
    if (typeof value !== "number") {
      return String(value);
    }
    if (Number.isNaN(value)) {
      return "null";
    }
    if (Object.is(value, -0)) {
      return "-0.0";
    }
    let shortest = value;
    for (let digits = 1; type === "float32" && digits <= 9; digits += 1) {
      shortest = Number(value.toPrecision(digits));
      if (Math.fround(shortest) === value) {
        break;
      }
    }
    return String(shortest);
  }

  // A control has an element to show, and a function that reads its value for JSON and for memory.

  function caption(field) {
    // An empty `lang` would mean an unknown language.
    const language = field.lang ? { lang: field.lang } : {};
    const label = field.label ? [element("span", { textContent: field.label, ...language }), " "] : [];
    return [...label, element("code", { textContent: field.name })];
  }

  // The frame of a control: label, input, hint and error message.
  function framed(field, input, hint) {
    controls += 1;
    input.id = `composer-${controls}`;
    const note = element("span", { className: "composer-hint", id: `${input.id}-hint`, textContent: hint });
    const wrong = element("span", { className: "composer-wrong", id: `${input.id}-wrong` });
    input.setAttribute("aria-describedby", `${note.id} ${wrong.id}`);
    const label = element("label", { htmlFor: input.id }, caption(field));
    const report = (message) => {
      wrong.textContent = message;
      input.setAttribute("aria-invalid", String(message !== ""));
    };
    return { frame: element("div", { className: "composer-field" }, [label, input, note, wrong]), report };
  }

  // Wraps `read` to show its error next to the control.
  function reporting(report, read) {
    return () => {
      try {
        const value = read();
        report("");
        return value;
      } catch (error) {
        if (error instanceof InvalidValue) {
          report(error.message);
        }
        throw error;
      }
    };
  }

  function single(field, shown, read) {
    const { size, put } = SCALARS[field.type];
    return {
      element: shown,
      read: () => {
        const value = read();
        return {
          json: () => json(value, field.type),
          places: (base) => [{ field, at: base + field.offset, size }],
          put: (view, base) => put(view, base + field.offset, value),
        };
      },
    };
  }

  function flag(field) {
    const box = element("input", { type: "checkbox" });
    const label = element("label", {}, [box, element("span", {}, caption(field))]);
    return single(field, element("div", { className: "composer-field composer-flag" }, [label]), () => box.checked);
  }

  function number(field) {
    const input = element("input", { type: "text", defaultValue: "0", autocomplete: "off", spellcheck: false });
    const { frame, report } = framed(field, input, [field.type, field.unit].filter(Boolean).join(", "));
    return single(field, frame, reporting(report, () => parse(input.value, field.type)));
  }

  function choice(field) {
    const select = element("select");
    const zero = field.values.some(([value]) => value === "0") ? [] : [["0", "", ""]];
    for (const [value, name, description] of [...zero, ...field.values]) {
      const textContent = [[value, name].filter(Boolean).join(" "), description].filter(Boolean).join(": ");
      select.append(element("option", { value, textContent, defaultSelected: value === "0" }));
    }
    select.append(element("option", { value: "", textContent: words.anotherValue }));
    const other = element("input", { type: "text", defaultValue: "0", hidden: true, autocomplete: "off" });
    other.setAttribute("aria-label", `${field.name}: ${words.anotherValue}`);
    select.addEventListener("input", () => {
      other.hidden = select.value !== "";
    });
    const { frame, report } = framed(field, select, field.type);
    select.after(other);
    other.setAttribute("aria-describedby", select.getAttribute("aria-describedby"));
    const text = () => (select.value === "" ? other.value : select.value);
    return single(field, frame, reporting(report, () => parse(text(), field.type)));
  }

  function flags(field) {
    const boxes = field.flags.map(([value, name, description]) => {
      const box = element("input", { type: "checkbox", value });
      const parts = [element("code", { textContent: name }), description ? ` ${description}` : ""];
      return { box, label: element("label", {}, [box, element("span", {}, parts)]) };
    });
    const legend = element("legend", {}, caption(field));
    const shown = element("fieldset", { className: "composer-flags" }, [legend, ...boxes.map(({ label }) => label)]);
    // The sum has no upper bound, so a mask with a sign bit becomes a negative value.
    const chosen = () => boxes.filter(({ box }) => box.checked).reduce((all, { box }) => all | BigInt(box.value), 0n);
    return single(field, shown, chosen);
  }

  function text(field) {
    const input = element("input", { type: "text", autocomplete: "off", spellcheck: false });
    const { frame, report } = framed(field, input, fill(words.upToBytes, { most: field.count }));
    const read = reporting(report, () => {
      const bytes = new TextEncoder().encode(input.value);
      if (bytes.length > field.count) {
        throw new InvalidValue(fill(words.tooManyBytes, { count: bytes.length, most: field.count }));
      }
      return bytes;
    });
    return {
      element: frame,
      read: () => {
        const bytes = read();
        const value = input.value;
        return {
          json: () => JSON.stringify(value),
          places: (base) => [{ field, at: base + field.offset, size: field.count }],
          put: (view, base) => bytes.forEach((byte, index) => view.setUint8(base + field.offset + index, byte)),
        };
      },
    };
  }

  function list(field) {
    const input = element("input", { type: "text", autocomplete: "off", spellcheck: false, placeholder: "0" });
    const { frame, report } = framed(field, input, fill(words.upToValues, { type: field.type, most: field.count }));
    const { size, put } = SCALARS[field.type];
    const one = (text) => {
      if (field.type !== "bool") {
        return parse(text, field.type);
      }
      if (!["true", "false", "1", "0"].includes(text)) {
        throw new InvalidValue(words.expectedBool);
      }
      return text === "true" || text === "1";
    };
    const zero = field.type === "bool" ? false : parse("0", field.type);
    const read = reporting(report, () => {
      const texts = input.value.split(/[\s,;]+/).filter(Boolean);
      if (texts.length > field.count) {
        throw new InvalidValue(fill(words.tooManyValues, { count: texts.length, most: field.count }));
      }
      return Array.from({ length: field.count }, (_, index) => (index < texts.length ? one(texts[index]) : zero));
    });
    return {
      element: frame,
      read: () => {
        const values = read();
        return {
          json: () => `[${values.map((value) => json(value, field.type)).join(", ")}]`,
          places: (base) => [{ field, at: base + field.offset, size: size * field.count }],
          put: (view, base) => values.forEach((value, index) => put(view, base + field.offset + index * size, value)),
        };
      },
    };
  }

  // Reads all parts, even if one of them is invalid.
  function readAll(parts) {
    const values = [];
    let invalid;
    for (const part of parts) {
      try {
        values.push(part.read());
      } catch (error) {
        invalid = error;
      }
    }
    if (invalid) {
      throw invalid;
    }
    return values;
  }

  function object(fields) {
    const parts = fields.map(control);
    const shown = [];
    fields.forEach((field, index) => {
      const last = shown[shown.length - 1];
      if (last && last.group === field.group) {
        last.parts.push(parts[index].element);
      } else {
        shown.push({ group: field.group, parts: [parts[index].element] });
      }
    });
    const elements = shown.map(({ group, parts: grouped }) =>
      group
        ? element("fieldset", {}, [element("legend", { textContent: group.replace(/[.:]$/, "") }), ...grouped])
        : element("div", { className: "composer-group" }, grouped),
    );
    return {
      elements,
      read: () => {
        const values = readAll(parts);
        return {
          json: (indent) => {
            const inner = `${indent}  `;
            const members = values.map((value, index) => `${inner}${JSON.stringify(fields[index].name)}: ${value.json(inner)}`);
            return members.length === 0 ? "{}" : `{\n${members.join(",\n")}\n${indent}}`;
          },
          places: (base) => values.flatMap((value) => value.places(base)),
          put: (view, base) => values.forEach((value) => value.put(view, base)),
        };
      },
    };
  }

  function nested(field) {
    const summary = (index) => {
      const place = index === undefined ? field.name : `${field.name}[${index}]`;
      return element("summary", {}, [element("code", { textContent: place }), field.label ? ` ${field.label}` : ""]);
    };
    const whole = (index) => {
      const { elements, read } = object(field.fields);
      return { element: element("details", {}, [summary(index), ...elements]), read };
    };
    const moved = (value, by) => ({
      json: value.json,
      places: (base) => value.places(base + by).map((place) => ({ ...place, of: field.name })),
      put: (view, base) => value.put(view, base + by),
    });
    if (field.count === undefined) {
      const one = whole();
      return { element: one.element, read: () => moved(one.read(), field.offset) };
    }
    const parts = Array.from({ length: field.count }, (_, index) => whole(index));
    return {
      element: element("div", {}, parts.map((part) => part.element)),
      read: () => {
        const values = readAll(parts).map((value, index) => moved(value, field.offset + index * field.size));
        return {
          json: (indent) => {
            const inner = `${indent}  `;
            return `[\n${values.map((value) => inner + value.json(inner)).join(",\n")}\n${indent}]`;
          },
          places: (base) => values.flatMap((value) => value.places(base)),
          put: (view, base) => values.forEach((value) => value.put(view, base)),
        };
      },
    };
  }

  function control(field) {
    if (field.fields) {
      return nested(field);
    }
    if (field.type === "text") {
      return text(field);
    }
    if (field.count !== undefined) {
      return list(field);
    }
    if (field.type === "bool") {
      return flag(field);
    }
    if (field.values) {
      return choice(field);
    }
    return field.flags ? flags(field) : number(field);
  }

  const hex = (byte) => byte.toString(16).padStart(2, "0");

  // Rows of eight bytes, as in the picture of the layout. Each byte has the name of its field as its title.
  function dump(bytes, before, places) {
    const names = new Array(bytes.length).fill(words.padding);
    for (const { field, at, size, of } of places) {
      names.fill(of ? `${of}: ${field.name}` : field.name, at, at + size);
    }
    const rows = [];
    for (let row = 0; row < bytes.length; row += 8) {
      const cells = [element("span", { className: "composer-offset", textContent: String(row).padStart(5) })];
      for (let at = row; at < Math.min(row + 8, bytes.length); at += 1) {
        const classes = [bytes[at] !== 0 && "composer-set", before && before[at] !== bytes[at] && "composer-new"];
        const className = classes.filter(Boolean).join(" ");
        cells.push(" ", element("span", { className, title: fill(words.byteOf, { at, field: names[at] }), textContent: hex(bytes[at]) }));
      }
      rows.push(...cells, "\n");
    }
    return rows;
  }

  // Describes the change in a sentence for screen readers.
  function change(before, bytes) {
    const changed = [...bytes.keys()].filter((at) => before && before[at] !== bytes[at]);
    const sentences = changed.slice(0, 8).map((at) => fill(words.byteIs, { at, value: hex(bytes[at]) }));
    return sentences.join(", ") + (changed.length > 8 ? ` ${fill(words.andMore, { count: changed.length - 8 })}` : "");
  }

  function copier(name, content) {
    const button = element("button", { type: "button", textContent: name });
    button.addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(content());
        button.textContent = words.copied;
      } catch {
        button.textContent = words.copyingRefused;
      }
      setTimeout(() => {
        button.textContent = name;
      }, 1500);
    });
    return button;
  }

  function compose(place) {
    const message = JSON.parse(place.dataset.message);
    words = message.words;
    const { elements, read } = object(message.fields);
    const form = element("form", { className: "composer-form" }, elements);
    form.setAttribute("aria-label", fill(words.fieldsOf, message));
    form.addEventListener("submit", (event) => event.preventDefault());

    const shownJson = element("pre", { className: "composer-json", tabIndex: 0 });
    const shownBytes = element("pre", { className: "composer-bytes", tabIndex: 0 });
    shownJson.setAttribute("aria-label", "JSON");
    shownBytes.setAttribute("aria-label", "uORB");
    const status = element("p", { className: "composer-status" });
    status.setAttribute("role", "status");
    let bytes;

    function show() {
      try {
        const value = read();
        const made = new Uint8Array(message.size);
        value.put(new DataView(made.buffer), 0);
        shownJson.textContent = value.json("");
        shownBytes.replaceChildren(...dump(made, bytes, value.places(0)));
        status.textContent = change(bytes, made);
        bytes = made;
        mayCopy(true);
      } catch (error) {
        if (!(error instanceof InvalidValue)) {
          throw error;
        }
        status.textContent = words.notAllFit;
        mayCopy(false);
      }
    }

    const clear = element("button", { type: "button", textContent: words.setToZero });
    clear.addEventListener("click", () => {
      form.reset();
      form.querySelectorAll("select").forEach((select) => select.dispatchEvent(new Event("input")));
      show();
    });
    const copyJson = copier(words.copyJson, () => shownJson.textContent);
    const copyBytes = copier(words.copyBytes, () => [...bytes].map(hex).join(""));
    // While a value is invalid, the output is outdated and must not be copied.
    const mayCopy = (isValid) => [copyJson, copyBytes].forEach((button) => (button.disabled = !isValid));
    const output = element("div", { className: "composer-output" }, [
      element("div", { className: "composer-buttons" }, [clear, copyJson, copyBytes]),
      status,
      element("h3", { textContent: "JSON" }),
      shownJson,
      element("h3", { textContent: message.title }),
      shownBytes,
    ]);
    form.addEventListener("input", show);
    place.replaceChildren(form, output);
    // The browser may restore input of an earlier visit; discard it.
    form.reset();
    show();
  }

  document.querySelectorAll(".composer[data-message]").forEach(compose);
})();
