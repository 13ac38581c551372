"use strict";
// What both pages have: figures, colours, lists. The view (plane.js, space.js) gives prepare(), centre(e), fit(),
// zoom(f), locate(e), paint(), what fingers and keys need (below), and calls start().
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
  m = { ...raw, points: decode(raw.points, Float32Array), quads: decode(raw.quads, Uint32Array),
    triangles: decode(raw.triangles, Uint32Array), edges: decode(raw.edges, Uint32Array) };
  m.nq = m.quads.length / 4;
  m.n = m.nq + m.triangles.length / 3;
  m.cache = {};
  prepare();
  texts();
  $("metric").replaceChildren(...m.metrics.map((d) => new Option(d.label, d.name)));
  marked = -1;
  fit();
  choose(m.metrics[0].name);
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
const size = (e) => (e < m.nq ? 4 : 3);
const corner = (e, k) => (e < m.nq ? m.quads[4 * e + k] : m.triangles[3 * (e - m.nq) + k]);
const place = (x, axis) => m.origin[axis] + x * m.scale;
const where = (e) => `(${centre(e).map((x, axis) => short(place(x, axis))).join(", ")})`;
const named = (e) => (e < m.nq ? `quad ${e}` : `triangle ${e - m.nq}`) + (m.faces ? ` of ${m.faces[m.faceOf[e]].name}` : "");
function worst() {
  $("worst").replaceChildren(...order.map(([, e], k) => {
    const b = document.createElement("button"), li = document.createElement("li");
    b.innerHTML = "<span></span><span></span>";
    b.children[0].textContent = `${k + 1}. ${named(e)}`;
    b.children[1].textContent = short(values[e]);
    b.title = `at ${where(e)}`;
    b.dataset.element = e;
    b.onclick = () => locate(e);
    li.append(b);
    return li;
  }));
}
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

function tell(e) {
  const parts = m.metrics.map((d) => `${d.label} ${short((m.cache[d.name] ??= decode(d.values, Float32Array))[e])}`);
  $("here").textContent = `${named(e)} at ${where(e)}: ${parts.join(", ")}`;
  for (const b of document.querySelectorAll("#worst button")) b.setAttribute("aria-current", String(Number(b.dataset.element) === e));
}

let wanted = 0;
function draw() { if (!wanted) wanted = requestAnimationFrame(paint); }

// Fingers and keys, the same in both views: these give drag(dx, dy, ev, pinching), tap(x, y), arrow(x, y), showAll().
const fingers = new Map();
let moved = 0;
canvas.addEventListener("pointerdown", (ev) => { canvas.setPointerCapture(ev.pointerId); fingers.set(ev.pointerId, [ev.offsetX, ev.offsetY]); moved = fingers.size > 1 ? 99 : 0; });
canvas.addEventListener("pointermove", (ev) => {
  const old = fingers.get(ev.pointerId);
  if (!old) return;
  const now = [ev.offsetX, ev.offsetY], other = [...fingers].find(([id]) => id !== ev.pointerId)?.[1];
  const share = other ? 0.5 : 1, [dx, dy] = [now[0] - old[0], now[1] - old[1]];
  drag(share * dx, share * dy, ev, Boolean(other));
  moved += Math.hypot(dx, dy);
  fingers.set(ev.pointerId, now);
  if (other) zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(old[0] - other[0], old[1] - other[1])), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  draw();
});
const release = (ev) => {
  const at = fingers.get(ev.pointerId);
  fingers.delete(ev.pointerId);
  if (at && moved < 5 && ev.type === "pointerup") tap(...at);
  draw();
};
canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("wheel", (ev) => { ev.preventDefault(); zoom(Math.exp(-ev.deltaY * (ev.deltaMode ? 0.05 : 0.0015)), ev.offsetX, ev.offsetY); }, { passive: false });
canvas.addEventListener("keydown", (ev) => {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  if (arrows[ev.key]) { arrow(...arrows[ev.key]); draw(); }
  else if (ev.key === "+" || ev.key === "=") zoom(1.3);
  else if (ev.key === "-") zoom(1 / 1.3);
  else if (ev.key === "0") showAll();
  else return;
  ev.preventDefault();
});
$("fit").onclick = showAll;
$("in").onclick = () => zoom(1.5);
$("out").onclick = () => zoom(1 / 1.5);
$("metric").onchange = (ev) => choose(ev.target.value);
$("outline").onchange = (ev) => load(Number(ev.target.value));
new ResizeObserver(() => { histogram(); draw(); }).observe(canvas);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { histogram(); draw(); });


function row([name, value]) {
  const tr = document.createElement("tr");
  tr.insertCell().textContent = name;
  const cell = tr.insertCell();
  cell.className = "n";
  cell.textContent = value;
  return tr;
}
const rows = (table, list) => table.replaceChildren(...list.map(row));
function texts() {
  const r = m.report, q = r.quality;
  $("title").textContent = r.name || "mesh";
  $("said").textContent = m.about;
  $("command").textContent = m.command;
  const figures = [["quads", q.n_quads], ["vertices", q.n_vertices], ["triangles", q.n_triangles], ["smallest scaled Jacobian", q.min_sj],
    ["mean scaled Jacobian", q.mean_sj], ["irregular inner vertices", q.n_irregular], ["meshed in", seconds(r.mesh_s)]];
  if (m.faces) {
    figures.splice(2, 1, ["faces meshed", `${r.n_faces - r.failures.length} of ${r.n_faces}`], ["sides of one quad only", r.n_free_sides],
      ["… of three and more", r.n_branching_sides]);
  }
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
  if (q.max_warpage !== null) $("quality").append(row(["warpage, largest", short(q.max_warpage)]));
  const s = q.size;
  $("sized").hidden = Boolean(m.faces);
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
  if (r.peak_memory_mb) times.append(row(["memory, at most", short(Math.round(r.peak_memory_mb)) + " MB"]));
}

function start() {
  if (models.length > 1) {
    $("which").hidden = false;
    $("outline").replaceChildren(...models.map((d, k) => new Option(d.report.name || `outline ${k}`, k)));
  }
  load(0);
}
