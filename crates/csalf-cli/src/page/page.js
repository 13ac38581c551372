"use strict";
const models = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const canvas = $("canvas"), ctx = canvas.getContext("2d");
const STEPS = 48, WORST = 25, BINS = 32;
// From poor to good; told apart in the common kinds of colour blindness.
const STOPS = [[176, 24, 43], [239, 138, 98], [253, 219, 150], [186, 222, 200], [103, 169, 207], [33, 102, 172]];

function decode(text, type) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new type(bytes.buffer);
}
const short = (x) => x === null || x === undefined || Number.isNaN(x) ? "–"
  : Number.isInteger(x) ? x.toLocaleString("en") : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2)
  : Number(x.toPrecision(4)).toString();
const seconds = (s) => s >= 1 ? s.toFixed(2) + " s" : (1e3 * s).toFixed(1) + " ms";
function colour(t) {
  const x = Math.min(Math.max(t, 0), 1) * (STOPS.length - 1), k = Math.min(Math.floor(x), STOPS.length - 2), f = x - k;
  return `rgb(${STOPS[k].map((a, c) => Math.round(a + f * (STOPS[k + 1][c] - a))).join(",")})`;
}
const PALETTE = Array.from({ length: STEPS }, (_, i) => colour((i + 0.5) / STEPS));

let m, metric, values, bin, view, marked = -1, order = [];

function load(k) {
  const raw = models[k];
  m = { ...raw, xy: decode(raw.points, Float32Array), quads: decode(raw.quads, Uint32Array),
    triangles: decode(raw.triangles, Uint32Array), edges: decode(raw.edges, Uint32Array) };
  m.nq = m.quads.length / 4;
  m.n = m.nq + m.triangles.length / 3;
  m.cache = {};
  grid();
  texts();
  $("metric").replaceChildren(...m.metrics.map((d) => new Option(d.label, d.name)));
  marked = -1;
  fit();
  choose(m.metrics[0].name);
}

const size = (e) => (e < m.nq ? 4 : 3);
const corner = (e, k) => (e < m.nq ? m.quads[4 * e + k] : m.triangles[3 * (e - m.nq) + k]);
function centre(e) {
  const n = size(e);
  let x = 0, y = 0;
  for (let k = 0; k < n; k++) { const v = corner(e, k); x += m.xy[2 * v] / n; y += m.xy[2 * v + 1] / n; }
  return [x, y];
}

// Cells of the box with the elements whose centre they hold: for drawing a part, and for taps.
function grid() {
  let x0 = Infinity, y0 = Infinity, x1 = -Infinity, y1 = -Infinity;
  for (let i = 0; i < m.xy.length; i += 2) {
    x0 = Math.min(x0, m.xy[i]); x1 = Math.max(x1, m.xy[i]);
    y0 = Math.min(y0, m.xy[i + 1]); y1 = Math.max(y1, m.xy[i + 1]);
  }
  if (!(x1 > x0 || y1 > y0)) { x0 = y0 = 0; x1 = y1 = 1; }
  const w = Math.max(x1 - x0, y1 - y0), side = Math.max(1, Math.min(256, Math.ceil(Math.sqrt(m.n / 16))));
  const start = new Uint32Array(side * side + 1), cell = new Uint32Array(m.n);
  let reach = 0;
  for (let e = 0; e < m.n; e++) {
    const [x, y] = centre(e);
    for (let k = 0; k < size(e); k++) {
      const v = corner(e, k);
      reach = Math.max(reach, Math.abs(m.xy[2 * v] - x), Math.abs(m.xy[2 * v + 1] - y));
    }
    const i = Math.min(side - 1, Math.floor((x - x0) / w * side)), j = Math.min(side - 1, Math.floor((y - y0) / w * side));
    cell[e] = j * side + i;
    start[cell[e] + 1]++;
  }
  for (let i = 0; i < side * side; i++) start[i + 1] += start[i];
  const next = start.slice(), list = new Uint32Array(m.n);
  for (let e = 0; e < m.n; e++) list[next[cell[e]]++] = e;
  m.grid = { x0, y0, x1, y1, w, side, start, list, reach };
}
function* within(xa, ya, xb, yb) {
  const g = m.grid, at = (t, t0) => Math.min(g.side - 1, Math.max(0, Math.floor((t - t0) / g.w * g.side)));
  const [i0, i1] = [at(xa - g.reach, g.x0), at(xb + g.reach, g.x0)], [j0, j1] = [at(ya - g.reach, g.y0), at(yb + g.reach, g.y0)];
  for (let j = j0; j <= j1; j++)
    for (let s = g.start[j * g.side + i0]; s < g.start[j * g.side + i1 + 1]; s++) yield g.list[s];
}

function choose(name) {
  metric = m.metrics.find((d) => d.name === name);
  $("metric").value = name;
  values = m.cache[name] ??= decode(metric.values, Float32Array);
  const finite = values.filter((x) => !Number.isNaN(x)).sort();
  metric.low ??= finite.length ? finite[0] : 0;
  metric.high ??= finite.length ? finite[finite.length - 1] : 1;
  if (metric.high <= metric.low) metric.high = metric.low + Math.max(1e-6, Math.abs(metric.low) * 1e-6);
  bin = new Uint8Array(m.n);
  for (let e = 0; e < m.n; e++) {
    const t = goodness(values[e]);
    bin[e] = Number.isNaN(t) ? STEPS : Math.min(STEPS - 1, Math.max(0, Math.floor(t * STEPS)));
  }
  // The worst, without sorting all of a large mesh.
  order = [];
  let bound = Infinity;
  for (let e = 0; e < m.n; e++) {
    const t = goodness(values[e]);
    if (t < bound) {
      order.push([t, e]);
      if (order.length >= 4 * WORST) { order.sort((a, b) => a[0] - b[0] || a[1] - b[1]); order.length = WORST; bound = order[WORST - 1][0]; }
    }
  }
  order.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  order.length = Math.min(order.length, WORST);
  worst(); legend(); histogram(); draw();
}
// 0 poor to 1 good. Values outside the scale count, too: the worst element is found beyond its end.
function goodness(x) {
  const t = (x - metric.low) / (metric.high - metric.low);
  return metric.good === "high" ? t : metric.good === "low" ? 1 - t : 1 - Math.abs(Math.log2(x));
}
function legend() {
  const bar = $("bar"), c = bar.getContext("2d");
  bar.width = 200;
  for (let i = 0; i < 200; i++) {
    const x = metric.low + (i + 0.5) / 200 * (metric.high - metric.low);
    c.fillStyle = colour(goodness(x));
    c.fillRect(i, 0, 1, 10);
  }
  $("low").textContent = short(metric.low);
  $("high").textContent = short(metric.high);
}
function worst() {
  $("worst").replaceChildren(...order.map(([, e], k) => {
    const b = document.createElement("button"), [x, y] = centre(e), li = document.createElement("li");
    b.innerHTML = "<span></span><span></span>";
    b.children[0].textContent = `${k + 1}. ${named(e)}`;
    b.children[1].textContent = short(values[e]);
    b.title = `at (${short(place(x, 0))}, ${short(place(y, 1))})`;
    b.dataset.element = e;
    b.onclick = () => locate(e);
    li.append(b);
    return li;
  }));
}
const named = (e) => (e < m.nq ? `quad ${e}` : `triangle ${e - m.nq}`);
const place = (x, axis) => m.origin[axis] + x * m.scale;

function histogram() {
  const c = $("histogram"), r = devicePixelRatio || 1, w = c.clientWidth, h = c.clientHeight, g = c.getContext("2d");
  c.width = w * r; c.height = h * r;
  g.scale(r, r);
  const count = new Array(BINS).fill(0);
  for (const x of values) {
    if (!Number.isNaN(x)) count[Math.min(BINS - 1, Math.max(0, Math.floor((x - metric.low) / (metric.high - metric.low) * BINS)))]++;
  }
  const top = Math.max(...count, 1), ink = getComputedStyle(document.body).color;
  $("histogram-title").textContent = "Histogram: " + metric.label;
  g.fillStyle = ink;
  g.font = "11px system-ui, sans-serif";
  g.fillText(top.toLocaleString("en"), 2, 10);
  const base = h - 16;
  count.forEach((n, i) => {
    const x = metric.low + (i + 0.5) / BINS * (metric.high - metric.low), tall = n ? Math.max(2, (base - 14) * n / top) : 0;
    g.fillStyle = colour(goodness(x));
    g.fillRect(i * w / BINS, base - tall, w / BINS - 1, tall);
  });
  g.fillStyle = ink;
  g.fillRect(0, base, w, 1);
  g.fillText(short(metric.low), 0, h - 3);
  const end = short(metric.high);
  g.fillText(end, w - g.measureText(end).width, h - 3);
}

function fit() {
  const g = m.grid, w = canvas.clientWidth, h = canvas.clientHeight, pad = 16;
  const s = Math.min((w - 2 * pad) / (g.x1 - g.x0 || 1), (h - 2 * pad) / (g.y1 - g.y0 || 1));
  view = { s, x: 0.5 * (g.x0 + g.x1), y: 0.5 * (g.y0 + g.y1), least: s / 4 };
}
function zoom(f, px = canvas.clientWidth / 2, py = canvas.clientHeight / 2) {
  const [x, y] = model(px, py);
  view.s = Math.min(Math.max(view.s * f, view.least), view.least * 4e6);
  const [qx, qy] = model(px, py);
  view.x += x - qx; view.y += y - qy;
  draw();
}
const model = (px, py) => [view.x + (px - canvas.clientWidth / 2) / view.s, view.y - (py - canvas.clientHeight / 2) / view.s];
function locate(e) {
  marked = e;
  const [x, y] = centre(e);
  let reach = 0;
  for (let k = 0; k < size(e); k++) reach = Math.max(reach, Math.hypot(m.xy[2 * corner(e, k)] - x, m.xy[2 * corner(e, k) + 1] - y));
  view.x = x; view.y = y;
  view.s = Math.max(view.least * 4, Math.min(canvas.clientWidth, canvas.clientHeight) / (14 * reach));
  tell(e);
  draw();
}
function tell(e) {
  const parts = m.metrics.map((d) => `${d.label} ${short((m.cache[d.name] ??= decode(d.values, Float32Array))[e])}`);
  const [x, y] = centre(e);
  $("here").textContent = `${named(e)} at (${short(place(x, 0))}, ${short(place(y, 1))}): ${parts.join(", ")}`;
  for (const b of document.querySelectorAll("#worst button")) b.setAttribute("aria-current", String(Number(b.dataset.element) === e));
}

let wanted = 0;
function draw() { if (!wanted) wanted = requestAnimationFrame(paint); }
function paint() {
  wanted = 0;
  const r = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (canvas.width !== Math.round(w * r) || canvas.height !== Math.round(h * r)) { canvas.width = Math.round(w * r); canvas.height = Math.round(h * r); }
  ctx.setTransform(r, 0, 0, r, 0, 0);
  ctx.clearRect(0, 0, w, h);
  const [xa, yb] = model(0, 0), [xb, ya] = model(w, h);
  const X = (v) => (m.xy[2 * v] - view.x) * view.s + w / 2, Y = (v) => (view.y - m.xy[2 * v + 1]) * view.s + h / 2;
  const groups = Array.from({ length: STEPS + 1 }, () => []);
  let n = 0;
  for (const e of within(xa, ya, xb, yb)) { groups[bin[e]].push(e); n++; }
  const pixels = Math.sqrt(Math.max(1, w * h) / Math.max(1, n));
  groups.forEach((list, k) => {
    if (!list.length) return;
    ctx.beginPath();
    for (const e of list) {
      ctx.moveTo(X(corner(e, 0)), Y(corner(e, 0)));
      for (let i = 1; i < size(e); i++) ctx.lineTo(X(corner(e, i)), Y(corner(e, i)));
      ctx.closePath();
    }
    ctx.fillStyle = k < STEPS ? PALETTE[k] : "#999";
    ctx.fill();
    if (pixels > 4) { ctx.lineWidth = Math.min(1, pixels / 12); ctx.strokeStyle = "rgba(20, 26, 38, 0.65)"; }
    else { ctx.lineWidth = 0.7; ctx.strokeStyle = ctx.fillStyle; }
    ctx.stroke();
  });
  ctx.beginPath();
  for (let i = 0; i < m.edges.length; i += 2) { ctx.moveTo(X(m.edges[i]), Y(m.edges[i])); ctx.lineTo(X(m.edges[i + 1]), Y(m.edges[i + 1])); }
  ctx.lineWidth = pixels > 4 ? 1.6 : 1;
  ctx.strokeStyle = getComputedStyle(document.body).color;
  ctx.stroke();
  if (marked >= 0) {
    ctx.beginPath();
    for (let i = 0; i < size(marked); i++) ctx.lineTo(X(corner(marked, i)), Y(corner(marked, i)));
    ctx.closePath();
    ctx.lineWidth = 5; ctx.strokeStyle = "#fff"; ctx.stroke();
    ctx.lineWidth = 2.5; ctx.strokeStyle = "#d1006c"; ctx.stroke();
  }
}

function tap(px, py) {
  const [x, y] = model(px, py);
  for (const e of within(x, y, x, y)) {
    let inside = true;
    for (let k = 0, n = size(e); k < n && inside; k++) {
      const a = corner(e, k), b = corner(e, (k + 1) % n);
      inside = (m.xy[2 * b] - m.xy[2 * a]) * (y - m.xy[2 * a + 1]) - (m.xy[2 * b + 1] - m.xy[2 * a + 1]) * (x - m.xy[2 * a]) >= 0;
    }
    if (inside) { marked = e; tell(e); draw(); return; }
  }
  marked = -1;
  $("here").textContent = `(${short(place(x, 0))}, ${short(place(y, 1))})`;
  draw();
}

const fingers = new Map();
let moved = 0;
canvas.addEventListener("pointerdown", (ev) => { canvas.setPointerCapture(ev.pointerId); fingers.set(ev.pointerId, [ev.offsetX, ev.offsetY]); moved = fingers.size > 1 ? 99 : 0; });
canvas.addEventListener("pointermove", (ev) => {
  const old = fingers.get(ev.pointerId);
  if (!old) return;
  const now = [ev.offsetX, ev.offsetY], other = [...fingers].find(([id]) => id !== ev.pointerId)?.[1];
  const share = other ? 0.5 : 1;
  view.x -= share * (now[0] - old[0]) / view.s; view.y += share * (now[1] - old[1]) / view.s;
  moved += Math.hypot(now[0] - old[0], now[1] - old[1]);
  fingers.set(ev.pointerId, now);
  if (other) zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(old[0] - other[0], old[1] - other[1])), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  draw();
});
const release = (ev) => { const at = fingers.get(ev.pointerId); fingers.delete(ev.pointerId); if (at && moved < 5 && ev.type === "pointerup") tap(...at); };
canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("wheel", (ev) => { ev.preventDefault(); zoom(Math.exp(-ev.deltaY * (ev.deltaMode ? 0.05 : 0.0015)), ev.offsetX, ev.offsetY); }, { passive: false });
canvas.addEventListener("keydown", (ev) => {
  const step = 60 / view.s, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
  if (moves[ev.key]) { view.x += moves[ev.key][0]; view.y += moves[ev.key][1]; draw(); }
  else if (ev.key === "+" || ev.key === "=") zoom(1.3);
  else if (ev.key === "-") zoom(1 / 1.3);
  else if (ev.key === "0") { fit(); draw(); }
  else return;
  ev.preventDefault();
});
$("fit").onclick = () => { fit(); draw(); };
$("in").onclick = () => zoom(1.5);
$("out").onclick = () => zoom(1 / 1.5);
$("metric").onchange = (ev) => choose(ev.target.value);
$("outline").onchange = (ev) => load(Number(ev.target.value));
new ResizeObserver(() => { histogram(); draw(); }).observe(canvas);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { histogram(); draw(); });

function rows(table, list) {
  table.replaceChildren(...list.map(([name, value, kind]) => {
    const tr = table.insertRow();
    tr.insertCell().textContent = name;
    const cell = tr.insertCell();
    cell.className = "n" + (kind ? " " + kind : "");
    cell.textContent = value;
    return tr;
  }));
}
function texts() {
  const r = m.report, q = r.quality;
  $("title").textContent = r.name || "mesh";
  $("said").textContent = m.about;
  $("command").textContent = m.command;
  const figures = [["quads", q.n_quads], ["vertices", q.n_vertices], ["triangles", q.n_triangles], ["smallest scaled Jacobian", q.min_sj],
    ["mean scaled Jacobian", q.mean_sj], ["irregular inner vertices", q.n_irregular], ["meshed in", seconds(r.mesh_s)]];
  $("figures").replaceChildren(...figures.map(([name, value]) => {
    const div = document.createElement("div");
    div.innerHTML = "<b></b><span></span>";
    div.children[0].textContent = typeof value === "string" ? value : short(value);
    div.children[1].textContent = name;
    return div;
  }));
  const layers = $("layers");
  layers.innerHTML = "<tr><th>loop</th><th class=n>asked</th><th class=n>made</th><th class=n>thickness error</th><th>stopped because</th></tr>";
  for (const l of r.layers) {
    const tr = layers.insertRow();
    const cells = [l.loops, l.asked, l.made, l.made ? short(l.thickness_error) : "–", l.stopped];
    cells.forEach((text, k) => { const td = tr.insertCell(); td.textContent = text; if (k > 0 && k < 4) td.className = "n"; });
    if (l.made < l.asked) tr.cells[2].className = "n less";
  }
  $("warned").hidden = r.warnings.length === 0;
  $("warnings").replaceChildren(...r.warnings.map((w) => Object.assign(document.createElement("li"), { textContent: w })));
  rows($("quality"), [["scaled Jacobian, smallest", short(q.min_sj)], ["… 1 % quantile", short(q.p1_sj)], ["… mean", short(q.mean_sj)],
    ["angles, degrees", `${short(q.min_angle)} to ${short(q.max_angle)}`], ["aspect ratio, largest", short(q.max_aspect)], ["… mean", short(q.mean_aspect)],
    ["skew, largest", short(q.max_skew)], ["shape, smallest", short(q.min_shape)], ["tau, all", short(q.tau_global)], ["tau, at the boundary", short(q.tau_boundary)],
    ["irregular share", short(q.irregular_share)], ["largest valence", short(q.max_valence)]]);
  const s = q.size;
  rows($("size"), s ? [["edges of the wanted size", (100 * s.share).toFixed(1) + " %"], ["ratio made / wanted", `${short(s.min_ratio)} to ${short(s.max_ratio)}`],
    ["mean of log", short(s.mean_log)], ["root mean square of log", short(s.rms_log)], ["quads that the sizes ask for", short(Math.round(q.expected_quads))]] : [["no size field", ""]]);
  const total = Object.values(r.stages).reduce((a, b) => a + b, 0) || 1;
  const times = $("times");
  times.replaceChildren();
  const stages = ["check", "size", "fill", "collect", "clean", "certify"];
  const known = (n) => (stages.indexOf(n) + 1 || stages.length + 1);
  const ordered = Object.entries(r.stages).sort((a, b) => known(a[0]) - known(b[0]));
  for (const [name, t] of [...ordered, ["all", r.mesh_s], ["processor", r.mesh_cpu_s]]) {
    const tr = times.insertRow(), cell = (tr.insertCell().textContent = name, tr.insertCell()), bar = document.createElement("div");
    if (name !== "all" && name !== "processor") { bar.className = "time"; bar.style.width = (100 * t / total).toFixed(1) + "%"; cell.append(bar); }
    cell.style.width = "45%";
    const n = tr.insertCell();
    n.className = "n";
    n.textContent = t === null ? "–" : seconds(t);
  }
}

if (models.length > 1) {
  $("which").hidden = false;
  $("outline").replaceChildren(...models.map((d, k) => new Option(d.report.name || `outline ${k}`, k)));
}
load(0);
