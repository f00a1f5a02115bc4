"use strict";
// Reads values off the charts: every curve is a path of relative moves through whole points in a box of 2000 x 1000.
for (const box of document.querySelectorAll(".box[data-x]")) {
  const area = box.querySelector(".area");
  let curves, cursor, tip;
  const value = (data, share) => {
    const [low, high, log] = data.split(" ").map(Number);
    return log ? low * Math.pow(high / low, share) : low + share * (high - low);
  };
  const text = (v) => (v === 0 || (Math.abs(v) >= 0.001 && Math.abs(v) < 1e5) ? String(Number(v.toPrecision(3))) : v.toExponential(2)).replace("-", "\u2212");
  const read = (path) => {
    const n = path.getAttribute("d").match(/-?\d+/g).map(Number), x = [n[0]], y = [n[1]];
    for (let i = 2; i + 1 < n.length; i += 2) { x.push(x[x.length - 1] + n[i]); y.push(y[y.length - 1] + n[i + 1]); }
    return { name: path.dataset.name, x, y };
  };
  const start = () => {
    curves = [...box.querySelectorAll("path[data-name]")].filter((p) => p.dataset.name && !/band|dots|thin/.test(p.getAttribute("class"))).map(read);
    cursor = area.appendChild(Object.assign(document.createElement("div"), { className: "cursor" }));
    tip = box.appendChild(Object.assign(document.createElement("div"), { className: "tip" }));
  };
  const nearest = (x, at) => {
    let low = 0, high = x.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (x[middle] < at) low = middle; else high = middle; }
    return at - x[low] < x[high] - at ? low : high;
  };
  area.addEventListener("pointermove", (event) => {
    if (!curves) start();
    if (!curves.length) return;
    const frame = area.getBoundingClientRect(), share = Math.min(1, Math.max(0, (event.clientX - frame.left) / frame.width));
    const said = curves.map((c) => `${c.name} ${text(value(box.dataset.y, 1 - c.y[nearest(c.x, 2000 * share)] / 1000))}`);
    cursor.hidden = tip.hidden = false;
    cursor.style.left = `${100 * share}%`;
    tip.textContent = `at ${text(value(box.dataset.x, share))}: ${said.join(", ")}`;
    tip.style.left = share < 0.5 ? "auto" : "4px";
    tip.style.right = share < 0.5 ? "4px" : "auto";
  });
  area.addEventListener("pointerleave", () => { if (tip) cursor.hidden = tip.hidden = true; });
}
