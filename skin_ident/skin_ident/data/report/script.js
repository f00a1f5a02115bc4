"use strict";
// Reads values off the charts and zooms those in time. Every curve is a path of relative moves through whole points in a box of 2000 x 1000.
const WIDTH = 2000, HEIGHT = 1000;
const number = (v) => (v === 0 || (Math.abs(v) >= 0.001 && Math.abs(v) < 1e5) ? String(Number(v.toPrecision(3))) : v.toExponential(2)).replace("-", "\u2212");

function value(axis, share) {
  const [low, high, log] = axis.split(" ").map(Number);
  return log ? low * Math.pow(high / low, share) : low + share * (high - low);
}

function read(path) {
  const x = [], y = [];
  for (const piece of path.getAttribute("d").split("M").slice(1)) {
    const n = piece.match(/-?\d+/g).map(Number);
    for (let i = 0, across = 0, down = 0; i + 1 < n.length; i += 2) { x.push((across += n[i])); y.push((down += n[i + 1])); }
  }
  return { name: path.dataset.name, x, y };
}

function nearest(x, at) {
  let low = 0, high = x.length - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (x[middle] < at) low = middle; else high = middle; }
  return at - x[low] < x[high] - at ? low : high;
}

function inspect(box) {
  const area = box.querySelector(".area");
  let curves, cursor, tip;
  const start = () => {
    curves = [...box.querySelectorAll("path[data-name]")].filter((p) => p.dataset.name && !/band|dots|thin/.test(p.getAttribute("class"))).map(read);
    cursor = area.appendChild(Object.assign(document.createElement("div"), { className: "cursor" }));
    tip = box.appendChild(Object.assign(document.createElement("div"), { className: "tip" }));
  };
  area.addEventListener("pointermove", (event) => {
    if (!curves) start();
    if (!curves.length) return;
    const frame = area.getBoundingClientRect(), share = Math.min(1, Math.max(0, (event.clientX - frame.left) / frame.width));
    const [from, width] = view(box), at = from + share * width;
    const said = curves.map((c) => `${c.name} ${number(value(box.dataset.y, 1 - c.y[nearest(c.x, at)] / HEIGHT))}`);
    cursor.hidden = tip.hidden = false;
    cursor.style.left = `${100 * share}%`;
    tip.textContent = `at ${number(value(box.dataset.x, at / WIDTH))}: ${said.join(", ")}`;
    tip.style.left = share < 0.5 ? "auto" : "4px";
    tip.style.right = share < 0.5 ? "4px" : "auto";
  });
  area.addEventListener("pointerleave", () => { if (tip) cursor.hidden = tip.hidden = true; });
}

function view(box) {
  const [from, , width] = box.querySelector("svg").getAttribute("viewBox").split(" ").map(Number);
  return [from, width];
}

function show(box, from, width) {
  box.querySelector("svg").setAttribute("viewBox", `${from} 0 ${width} ${HEIGHT}`);
  const low = value(box.dataset.x, from / WIDTH), high = value(box.dataset.x, (from + width) / WIDTH);
  const rough = (high - low) / 7, power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = power * [1, 2, 5, 10].find((m) => rough <= m * power * 1.000001), marks = [];
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    const mark = Object.assign(document.createElement("i"), { textContent: (i * step).toFixed(places).replace("-", "\u2212") });
    mark.style.left = `${(100 * (i * step - low)) / (high - low)}%`;
    marks.push(mark);
  }
  box.querySelector(".xt").replaceChildren(...marks);
}

function zoomable(pair) {
  const boxes = [...pair.querySelectorAll(".box[data-x]")];
  const all = (from, width) => boxes.forEach((box) => show(box, from, width));
  pair.title = "drag to zoom, double-click to see all";
  for (const box of boxes) {
    const area = box.querySelector(".area");
    let begun = null, brush = null;
    const share = (event) => { const f = area.getBoundingClientRect(); return Math.min(1, Math.max(0, (event.clientX - f.left) / f.width)); };
    area.classList.add("zoom");
    area.addEventListener("pointerdown", (event) => {
      if (event.pointerType !== "mouse" || event.button !== 0) return;
      event.preventDefault();
      area.setPointerCapture(event.pointerId);
      begun = share(event);
      brush = area.appendChild(Object.assign(document.createElement("div"), { className: "brush" }));
    });
    area.addEventListener("pointermove", (event) => {
      if (begun === null) return;
      const now = share(event);
      brush.style.left = `${100 * Math.min(begun, now)}%`;
      brush.style.width = `${100 * Math.abs(now - begun)}%`;
    });
    const end = (event) => {
      if (begun === null) return;
      const now = share(event), a = Math.min(begun, now), b = Math.max(begun, now), [from, width] = view(box);
      brush.remove();
      begun = brush = null;
      if (event.type === "pointerup" && b - a > 0.01 && (b - a) * width > 4) all(from + a * width, (b - a) * width);
    };
    area.addEventListener("pointerup", end);
    area.addEventListener("pointercancel", end);
    area.addEventListener("dblclick", () => all(0, WIDTH));
  }
}

document.querySelectorAll(".box[data-x]").forEach(inspect);
document.querySelectorAll(".pair").forEach(zoomable);
