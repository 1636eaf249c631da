// A search form above the table of all error codes: by number, abbreviation or word, with a checkbox per severity.
(() => {
  "use strict";

  function element(name, properties = {}, children = []) {
    const created = Object.assign(document.createElement(name), properties);
    created.append(...children);
    return created;
  }

  // A number matches a code or one of its alternatives. Words match anywhere, in any order.
  function matches(row, words) {
    return words.every((word) => (/^\d+$/.test(word) ? row.numbers.includes(word) : row.text.includes(word)));
  }

  function filter(place, index) {
    let table = place.nextElementSibling;
    while (table && !table.matches("table, .table-wrapper")) {
      table = table.nextElementSibling;
    }
    if (!table) {
      return;
    }
    const words = JSON.parse(place.dataset.words);
    // The table omits empty columns, so columns are identified by their headings.
    const headings = [...table.querySelectorAll("thead th")].map((cell) => cell.textContent.trim());
    const [severityColumn, alternativesColumn] = [words.severity, words.alternatives].map((name) => headings.indexOf(name));
    const rows = [...table.querySelectorAll("tbody tr")].map((shown) => {
      const cells = [...shown.cells].map((cell) => cell.textContent.trim());
      return {
        shown,
        severity: cells[severityColumn],
        numbers: [cells[0], ...(cells[alternativesColumn] ?? "").match(/\d+/g) || []],
        text: cells.join(" ").toLowerCase(),
      };
    });

    const search = element("input", { type: "search", id: `error-code-search-${index}`, placeholder: words.example });
    search.autocomplete = "off";
    const status = element("p", { className: "error-code-count" });
    status.setAttribute("role", "status");
    const severities = [...new Set(rows.map((row) => row.severity))].map((severity) => {
      const box = element("input", { type: "checkbox", defaultChecked: true });
      const count = rows.filter((row) => row.severity === severity).length;
      return { severity, box, label: element("label", {}, [box, ` ${severity} (${count})`]) };
    });

    function show() {
      const terms = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      const chosen = new Set(severities.filter(({ box }) => box.checked).map(({ severity }) => severity));
      let count = 0;
      for (const row of rows) {
        const isShown = chosen.has(row.severity) && matches(row, terms);
        row.shown.hidden = !isShown;
        count += isShown ? 1 : 0;
      }
      status.textContent = words.shownOfAll.replace("{shown}", count).replace("{all}", rows.length);
    }

    const legend = element("legend", { textContent: words.severity });
    const form = element("form", {}, [
      element("label", { htmlFor: search.id, textContent: words.find }),
      search,
      element("fieldset", {}, [legend, ...severities.map(({ label }) => label)]),
      status,
    ]);
    form.setAttribute("role", "search");
    form.setAttribute("aria-label", words.title);
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", show);
    place.replaceChildren(form);
    form.reset();
    show();
  }

  document.querySelectorAll(".error-code-filter[data-words]").forEach(filter);
})();
