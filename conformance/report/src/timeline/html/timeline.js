"use strict";
(() => {
  const root = document.documentElement;
  const language = document.getElementById("language");
  document.getElementById("controls").hidden = false;
  if (language) language.addEventListener("change", () => { root.dataset.language = language.value; });

  const chart = document.getElementById("chart");
  if (!chart) return;
  const axis = document.getElementById("axis");
  const duration = Number(chart.dataset.duration) / 1e6;
  const origin = Number(chart.dataset.origin) / 1e6;
  // The finest view shows 100 ms. Browsers limit the width of elements.
  const limit = Math.min(Math.max(1, duration / 0.1), 2000);
  const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 28800, 86400, 864000];
  let zoom = 1;

  const width = () => axis.getBoundingClientRect().width;
  const names = () => chart.firstElementChild.getBoundingClientRect().width - width();
  const pad = (number) => String(number).padStart(2, "0");

  function text(seconds, step) {
    const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
    const rounded = Math.round(seconds * 100) / 100;
    const rest = (rounded % 60).toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
    const minutes = Math.floor(rounded / 60);
    return origin ? `${pad(Math.floor(minutes / 60) % 24)}:${pad(minutes % 60)}:${rest}` : `${pad(minutes)}:${rest}`;
  }

  function element(name, attributes) {
    const made = document.createElementNS(axis.namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  }

  // Draws the ticks of the visible part.
  function ticks() {
    const whole = width();
    const from = (chart.scrollLeft / whole) * duration;
    const to = Math.min(((chart.scrollLeft + chart.clientWidth) / whole) * duration, duration);
    const least = (duration / whole) * (origin ? 90 : 75);
    const step = STEPS.find((step) => step >= least) || duration;
    const drawn = [];
    for (let at = Math.ceil((origin + from) / step); at * step <= origin + to; at += 1) {
      const x = `${((at * step - origin) / duration) * 100}%`;
      const tick = element("g", { class: "tick" });
      tick.append(element("line", { x1: x, x2: x, y1: 0, y2: 22 }));
      // A label at the end would be cut off.
      if (((at * step - origin) / duration) * whole < whole - 60) {
        const label = element("text", { x, dx: 4, y: 15 });
        label.textContent = text(at * step, step);
        tick.append(label);
      }
      drawn.push(tick);
    }
    axis.replaceChildren(...drawn);
  }

  // Moves the names of states into the visible part.
  const spans = Array.from(chart.querySelectorAll(".span"), (span) => [span.querySelector("text"), parseFloat(span.getAttribute("x")) / 100]);
  const labels = spans.filter(([label]) => label);
  function place() {
    const whole = width();
    for (const [label, at] of labels) label.setAttribute("x", Math.max(0, chart.scrollLeft - at * whole) + 5);
  }

  let isPending = false;
  function draw() {
    if (isPending) return;
    isPending = true;
    requestAnimationFrame(() => { isPending = false; ticks(); place(); });
  }

  // Zooms so that the time under `x`, in pixels from the left of the chart, stays there.
  function scale(factor, x = (names() + chart.clientWidth) / 2) {
    const share = (chart.scrollLeft + x - names()) / width();
    zoom = Math.min(Math.max(zoom * factor, 1), limit);
    chart.style.setProperty("--zoom", zoom);
    chart.scrollLeft = share * width() - x + names();
    draw();
  }

  const pan = (share) => { chart.scrollLeft += share * (chart.clientWidth - names()); };
  const ACTIONS = {
    "+": () => scale(1.5), "=": () => scale(1.5), "-": () => scale(1 / 1.5), "0": () => scale(0),
    ArrowLeft: () => pan(-0.2), ArrowRight: () => pan(0.2),
  };
  chart.addEventListener("keydown", (event) => {
    const action = ACTIONS[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  });
  chart.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    scale(Math.exp(-event.deltaY / 300), event.clientX - chart.getBoundingClientRect().left);
  }, { passive: false });

  let grabbed = null;
  chart.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "mouse" || event.button !== 0) return;
    grabbed = { x: event.clientX, left: chart.scrollLeft };
  });
  addEventListener("pointermove", (event) => {
    if (!grabbed) return;
    chart.classList.add("dragging");
    chart.scrollLeft = grabbed.left + grabbed.x - event.clientX;
  });
  addEventListener("pointerup", () => { grabbed = null; chart.classList.remove("dragging"); });

  for (const [id, key] of [["in", "+"], ["out", "-"], ["whole", "0"]]) {
    document.getElementById(id).addEventListener("click", ACTIONS[key]);
  }
  chart.addEventListener("scroll", draw);
  addEventListener("resize", draw);
  draw();
})();
