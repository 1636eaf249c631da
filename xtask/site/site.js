// Completes the pages of mdBook: readable tables on narrow screens, keyboard access, and a button that prints the page.
(() => {
  "use strict";

  const all = (selector, scope = document) => [...scope.querySelectorAll(selector)];

  // On narrow screens, the style sheet shows each row as a block, so each cell needs its heading. In a table of two
  // columns, the first cell is the heading of the second. Styles that change `display` remove the role of an element.
  for (const table of all("main table")) {
    const headings = all("thead th", table).map((cell) => cell.textContent.trim());
    const roles = { table: "table", "thead, tbody": "rowgroup", tr: "row", th: "columnheader", td: "cell" };
    for (const [selector, role] of Object.entries(roles)) {
      [table, ...all(selector, table)].filter((one) => one.matches(selector)).forEach((one) => one.setAttribute("role", role));
    }
    for (const cell of headings.length > 2 ? all("td:not(:first-child)", table) : []) {
      if (headings[cell.cellIndex]) {
        cell.dataset.label = headings[cell.cellIndex];
      }
    }
    table.classList.add("stacked");
  }

  // Areas that scroll are reachable by keyboard.
  const scrolls = () => {
    for (const area of all(".table-wrapper, main pre > code, main pre")) {
      area.tabIndex = area.scrollWidth > area.clientWidth || area.scrollHeight > area.clientHeight ? 0 : -1;
    }
  };
  addEventListener("resize", scrolls);
  scrolls();

  // The controls of the table of contents are neither links nor buttons.
  const button = (control, label, isOpen) => {
    const update = () => control.setAttribute("aria-expanded", isOpen());
    control.setAttribute("role", "button");
    control.setAttribute("aria-label", label);
    control.addEventListener("click", () => setTimeout(update));
    control.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        control.click();
      }
    });
    update();
  };
  const sidebar = document.getElementById("mdbook-sidebar");
  const isShown = () => document.documentElement.classList.contains("sidebar-visible");
  // A label can't be a button or have a state, but its icon can.
  document.getElementById("mdbook-sidebar-toggle").removeAttribute("aria-expanded");
  const toggle = document.querySelector("#mdbook-sidebar-toggle .fa-svg");
  toggle.tabIndex = 0;
  button(toggle, "Table of contents", isShown);
  document.getElementById("mdbook-menu-bar").setAttribute("role", "banner");
  for (const fold of all(".chapter-item .chapter-fold-toggle:not(.header-toggle)", sidebar)) {
    const [title, item] = [fold.previousElementSibling, fold.closest("li")];
    fold.tabIndex = isShown() ? 0 : -1;
    button(fold, `Chapters below ${title.textContent}`, () => item.classList.contains("expanded"));
    if (title.matches("span")) {
      title.classList.add("group");
      title.addEventListener("click", () => fold.click());
    }
  }

  // A heading of the page is omitted if it is also the title of a group of chapters.
  addEventListener("DOMContentLoaded", () => {
    const groups = all(".group", sidebar).map((group) => group.textContent);
    all(".header-item", sidebar).filter((item) => groups.includes(item.textContent)).forEach((item) => item.remove());
  });

  // Ids and commands in parentheses are less prominent than words.
  for (const title of all(".chapter-link-wrapper > a[href]", sidebar)) {
    const [, words, id] = title.textContent.match(/^(.+) \(([^()]+)\)$/) ?? [];
    if (id && !title.matches(".header-in-summary")) {
      const small = document.createElement("small");
      small.textContent = id;
      title.replaceChildren(words, " ", small);
    }
  }

  // The site has styles for one light and one dark theme.
  const names = { "mdbook-theme-default_theme": "System", "mdbook-theme-light": "Light", "mdbook-theme-navy": "Dark" };
  for (const theme of all("#mdbook-theme-list .theme")) {
    const name = names[theme.id];
    if (name) {
      theme.textContent = name;
    } else {
      theme.parentElement.remove();
    }
  }

  const print = document.createElement("button");
  print.type = "button";
  print.className = "icon-button print-page";
  print.textContent = "Print";
  print.title = "Print this page";
  print.addEventListener("click", () => window.print());
  document.querySelector(".right-buttons")?.append(print);
})();
