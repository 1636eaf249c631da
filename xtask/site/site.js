// A button that prints the page.
(() => {
  "use strict";

  const place = document.querySelector(".right-buttons");
  if (!place) {
    return;
  }
  const button = document.createElement("button");
  button.type = "button";
  button.className = "icon-button print-page";
  button.textContent = "Print";
  button.title = "Print this page";
  button.addEventListener("click", () => window.print());
  place.append(button);
})();
