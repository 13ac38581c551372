// Puts the page together: document, view, tools, panel, engine.
import { backend } from "./backend.js";
import { Mesh, short } from "./mesh.js";
import { Model } from "./model.js";
import { Panel } from "./panel.js";
import { Tools } from "./tools.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
const engine = backend(), model = new Model(), view = new View($("canvas"), model);
let fitNext = true, notes = [], documents = [];

const say = (text) => { $("here").textContent = text; };
const trouble = (error) => { $("status").textContent = error.message; };
/** The edge length where none is set: that of the engine, or else that of the segments. */
function usualSize() {
  const loops = view.reply?.loops.filter((l) => l.n > 2) ?? [];
  const n = loops.reduce((a, l) => a + l.n, 0), length = loops.reduce((a, l) => a + l.n * l.segment, 0);
  return Number((model.size ?? view.reply?.default_size ?? (n ? length / n : view.extent / 40)).toPrecision(3));
}
function tell(e, x, y) {
  const mesh = view.mesh, r = view.reply;
  if (e < 0 || !mesh) { say(`(${short(x)}, ${short(y)})`); return; }
  const [cx, cy] = mesh.centre(e);
  say(`${mesh.named(e)} at (${short(cx)}, ${short(cy)}): ${mesh.reply.metrics.map((m) => `${m.label} ${short(mesh.reply[m.name][e])}`).join(", ")}`);
  if (!r.ok) say("The mesh of before; correct the problems for a new one.");
}
const actions = { say, tell, usualSize, notes: () => notes, open: () => $("file").click(), fitNext: (yes) => { fitNext ||= yes; } };
const panel = new Panel(model, view, actions);
new Tools(view, model, actions);

// One question at a time while something is dragged; a final one ends all others.
let running = null, next = null;
async function remesh(draft) {
  if (draft && running) { next = true; return; }
  running?.abort();
  const mine = running = new AbortController(), began = performance.now();
  next = null;
  const slow = setTimeout(() => { $("status").textContent = "meshing …"; }, 250);
  try {
    const reply = await engine.mesh(JSON.stringify({ ...model.doc, draft }), mine.signal);
    if (running !== mine) return;
    const answered = performance.now();
    const mesh = reply.ok ? new Mesh(reply) : view.mesh;
    if (reply.ok) mesh.choose($("metric").value);
    view.show(reply, model.isEmpty ? null : mesh);
    if (fitNext && view.lines.length) { fitNext = false; view.fit(); }
    panel.reply();
    const all = performance.now() - began;
    $("status").textContent = !reply.ok ? (model.isEmpty ? "" : "no mesh: see the problems")
      : `${short(reply.n_quads)} quads in ${Math.round(all)} ms (mesh ${Math.round(1000 * reply.mesh_s)} ms)`;
    document.body.dataset.times = JSON.stringify({ all, engine: answered - began, mesh: 1000 * (reply.mesh_s ?? 0) });
    document.body.dataset.meshes = Number(document.body.dataset.meshes ?? 0) + 1;
  } catch (error) {
    if (running === mine && error.name !== "AbortError") trouble(error);
  } finally {
    clearTimeout(slow);
    if (running === mine) {
      running = null;
      if (next) remesh(true);
    }
  }
}
model.addEventListener("change", (ev) => { panel.document(); view.draw(); remesh(ev.detail.draft); });
model.addEventListener("select", () => { panel.document(); view.draw(); });

function show(opened) {
  documents = opened.documents;
  notes = opened.notes;
  if (!documents.length) return;
  $("which").hidden = documents.length < 2;
  $("outline").replaceChildren(...documents.map((d, k) => new Option(d.job.name || `outline ${k}`, k)));
  load(0);
}
function load(k) {
  fitNext = true;
  view.mesh = null;
  view.place = null;
  model.load(documents[k]);
}
async function open(file) {
  if (!file) return;
  try {
    show(await engine.open(file.name, new Uint8Array(await file.arrayBuffer())));
  } catch (error) { trouble(new Error(`${file.name}: ${error.message}`)); }
}
async function save() {
  try {
    const { name, blob } = await engine.export(JSON.stringify(model.doc), $("format").value);
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    $("status").textContent = `${name} saved`;
  } catch (error) { trouble(error); }
}
/** A plate with four holes, layers round them, and a finer spot. */
function example() {
  const arc = (x, y, r) => [{ arc: { center: [x, y], radii: [r, r], rotation: 0, start: 0, sweep: 2 * Math.PI } }];
  const holes = [[-4, -2, 1], [4, -2, 1], [-4, 2, 1], [3, 1.5, 1.6]];
  show({ notes: [], documents: [{
    job: { name: "plate", size: { kind: "sources", far: 0.5, sources: [{ xy: [-1, 0], h: 0.15, radius: 0.6, falloff: 2.5 }] },
      loops: [{ kind: "outer", name: "outer", nodes: [] }, ...holes.map((_, k) => ({ kind: "hole", name: `hole${k}`, nodes: [] }))],
      layers: { "hole*": { count: 2, law: "constant", first: 0.15 }, outer: { count: 1, law: "auto" } } },
    curves: { loops: [[{ polyline: [[-7, -4], [7, -4], [7, 4], [-7, 4], [-7, -4]] }], ...holes.map((h) => arc(...h))], scars: [] } }] });
}

$("open").onclick = actions.open;
$("file").onchange = async () => { await open($("file").files[0]); $("file").value = ""; };
$("new").onclick = () => { documents = []; notes = []; $("which").hidden = true; fitNext = true; view.mesh = null; view.place = null; model.clear(); };
$("undo").onclick = () => model.undo();
$("redo").onclick = () => model.redo();
$("export").onclick = save;
$("example").onclick = example;
$("outline").onchange = () => load(Number($("outline").value));
$("in").onclick = () => view.zoom(1.5);
$("out").onclick = () => view.zoom(1 / 1.5);
$("fit").onclick = () => view.fit();
document.addEventListener("dragover", (ev) => ev.preventDefault());
document.addEventListener("drop", (ev) => { ev.preventDefault(); open(ev.dataTransfer.files[0]); });

// For tests and the curious.
window.studio = { model, view, idle: () => !running };

view.fit();
panel.document();
engine.start().then(show, trouble).finally(() => { document.body.dataset.ready = "yes"; });
