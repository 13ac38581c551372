// The side panel: fields for what is selected, and what the engine tells of the mesh.
import { colour, short } from "./mesh.js";

const $ = (id) => document.getElementById(id);
const BINS = 32;

/** A positive number out of a field; `null` if it is empty, NaN if it is none. */
function positive(field) {
  const text = field.value.trim().replace(",", "."), x = Number(text);
  const wrong = text !== "" && !(x > 0 && Number.isFinite(x));
  field.setAttribute("aria-invalid", String(wrong));
  return text === "" ? null : wrong ? NaN : x;
}
/** A sentence of the engine with its long numbers cut to six digits. */
const brief = (text) => text.replace(/-?\d+\.\d{5,}(e-?\d+)?/g, (x) => String(Number(Number(x).toPrecision(6))));
const layers = (n) => `${n} layer${n === 1 ? "" : "s"}`;
function button(texts, title, action) {
  const b = document.createElement("button"), li = document.createElement("li");
  for (const text of texts) { const span = document.createElement("span"); span.textContent = text; b.append(span); }
  b.title = title;
  b.onclick = action;
  li.append(b);
  return li;
}

export class Panel {
  constructor(model, view, actions) {
    Object.assign(this, { model, view, actions });
    const commit = (id, act) => { $(id).addEventListener("change", () => act()); };
    commit("size", () => {
      const h = positive($("size"));
      if (!Number.isNaN(h)) { model.mark(); model.setSize(h, actions.usualSize()); model.changed(); }
    });
    // Coarse to fine on a scale of logarithms; one step of undo per drag.
    $("slider").addEventListener("input", () => {
      if (!this.sliding) { this.sliding = true; model.mark(); }
      model.setSize(Number((view.extent * 0.25 * 0.008 ** Number($("slider").value)).toPrecision(3)), actions.usualSize());
      model.changed(true);
    });
    commit("slider", () => { this.sliding = false; model.changed(); });
    commit("resample", () => model.edit((_, doc) => { doc.resample = $("resample").checked; }));
    for (const id of ["count", "law", "first", "ratio", "thicknesses"]) commit(id, () => this.setLayers(model.selected?.loop));
    $("all-holes").onclick = () => this.setLayers("hole*");
    $("kind").onclick = () => model.turnKind(model.selected.loop);
    $("delete-loop").onclick = () => model.removeLoop(model.selected.loop);
    for (const [id, key] of [["source-h", "h"], ["source-radius", "radius"], ["source-falloff", "falloff"]]) {
      commit(id, () => {
        const x = positive($(id));
        if (x > 0) { model.mark(); model.changeSource(model.selected.source, { [key]: x }); model.changed(); }
      });
    }
    $("delete-source").onclick = () => model.removeSource(model.selected.source);
    $("metric").onchange = () => { view.mesh.choose($("metric").value); this.quality(); view.draw(); };
    new ResizeObserver(() => this.histogram()).observe($("histogram"));
  }

  /** Layers as the fields say, of a loop or pattern. */
  setLayers(pattern) {
    if (pattern === undefined) return;
    const text = $("count").value.trim(), count = Number(text), law = $("law").value, spec = { law };
    const wrong = text !== "" && !(Number.isInteger(count) && count >= 0 && count <= 1000);
    $("count").setAttribute("aria-invalid", String(wrong));
    this.lawFields(law);
    if (wrong) return;
    const first = positive($("first")), ratio = positive($("ratio"));
    if (law === "explicit") {
      const list = $("thicknesses").value.split(/[\s,;]+/).filter(Boolean).map(Number);
      const bad = !list.length || list.some((t) => !(t > 0));
      $("thicknesses").setAttribute("aria-invalid", String(bad && $("thicknesses").value.trim() !== ""));
      if (bad) return;
      spec.thicknesses = list;
      spec.count = list.length;
    } else {
      if (Number.isNaN(first) || Number.isNaN(ratio)) return;
      if (text === "") { this.model.setLayers(pattern, null); return; }
      spec.count = count;
      if (law !== "auto" && first) spec.first = first;
      if (law === "geometric") spec.ratio = ratio ?? 1.2;
    }
    this.model.setLayers(pattern, spec);
  }
  lawFields(law) {
    $("first-row").hidden = law === "auto" || law === "explicit";
    $("ratio-row").hidden = law !== "geometric";
    $("thicknesses-row").hidden = law !== "explicit";
  }

  /** Everything that follows from the document and the selection. */
  document() {
    const { model, view } = this, s = model.selected, reply = view.reply;
    // A field that is being typed into is left alone.
    const put = (id, value) => { if (document.activeElement !== $(id)) $(id).value = value ?? ""; };
    $("undo").disabled = !model.past.length;
    $("redo").disabled = !model.future.length;
    $("hint").hidden = !model.isEmpty;
    put("size", model.size);
    $("size").placeholder = model.doc.job.size.kind === "background" ? "from the file"
      : reply?.default_size ? `${short(reply.default_size)} (chosen)` : "as the outline";
    if (!this.sliding) $("slider").value = Math.log((model.size ?? this.actions.usualSize()) / (0.25 * view.extent)) / Math.log(0.008);
    $("resample").checked = model.doc.resample;
    $("resample").parentElement.hidden = !model.givenNodes;
    const loop = s?.loop === undefined ? null : model.loop(s.loop), source = model.sources[s?.source];
    $("loop").hidden = !loop;
    $("source").hidden = !source;
    if (loop) {
      const spec = model.layersOf(loop.name), line = reply?.loops.find((l) => l.name === loop.name);
      $("loop-name").textContent = loop.name;
      $("loop-about").textContent = line ? `${loop.kind === "outer" ? "outer loop" : "hole"}, ${line.n} segments of ${short(line.segment)}` : "";
      $("kind").textContent = loop.kind === "outer" ? "Make a hole" : "Make outer";
      $("all-holes").hidden = loop.kind === "outer";
      put("count", spec?.count);
      $("law").value = spec?.law ?? (spec?.thicknesses ? "explicit" : spec?.ratio ? "geometric" : "auto");
      put("first", spec?.first);
      put("ratio", spec?.ratio);
      put("thicknesses", spec?.thicknesses?.join(", "));
      this.lawFields($("law").value);
    }
    if (source) { put("source-h", source.h); put("source-radius", source.radius); put("source-falloff", source.falloff); }
    $("loops-section").hidden = model.isEmpty;
    $("loops").replaceChildren(...model.doc.job.loops.map((l) => {
      const spec = model.layersOf(l.name), li = button([l.name, spec ? layers(spec.count ?? spec.thicknesses?.length) : ""], "select", () => model.select({ loop: l.name }));
      li.firstChild.setAttribute("aria-current", String(l.name === s?.loop));
      return li;
    }));
    this.made();
  }
  /** What became of the layers of the selected loop. */
  made() {
    const name = this.model.selected?.loop, l = this.view.reply?.layers?.find((l) => l.name === name);
    $("made").textContent = !l ? "" : l.made < l.asked ? `${l.made} of ${layers(l.asked)} made${l.stopped && `: ${l.stopped}`}`
      : l.asked ? `${layers(l.made)} made, thickness within ${(100 * l.thickness_error).toFixed(2)} %` : "no layers";
    $("made").className = l && l.made < l.asked ? "less" : "";
  }

  /** What the engine answered. */
  reply() {
    const { view } = this, r = view.reply, at = ([x, y]) => `(${short(x)}, ${short(y)})`;
    $("problems").hidden = r.ok || this.model.isEmpty;
    $("defects").replaceChildren(...(r.errors ?? []).map((e) =>
      button([brief(e.text)], e.places.length ? `show ${at(e.places[0])}` : "", () => { if (e.places.length) view.goto(e.places[0]); })));
    const notes = [...(this.actions.notes() ?? []), ...r.notes, ...(r.warnings ?? [])];
    $("remarks").hidden = !notes.length;
    $("notes").replaceChildren(...notes.slice(0, 50).map((t) => Object.assign(document.createElement("li"), { textContent: brief(t) })));
    $("export").disabled = !r.ok;
    $("quality").hidden = !r.ok;
    if (r.ok) {
      const chosen = $("metric").value;
      if ($("metric").options.length !== r.metrics.length) $("metric").replaceChildren(...r.metrics.map((m) => new Option(m.label, m.name)));
      if (chosen) $("metric").value = chosen;
      const q = r.quality, figures = [["quads", r.n_quads], ["vertices", r.n_vertices], ["smallest scaled Jacobian", q.min_sj],
        ["mean scaled Jacobian", q.mean_sj], ["angles", `${q.min_angle.toFixed(0)}° to ${q.max_angle.toFixed(0)}°`],
        ["irregular vertices", q.n_irregular], ["sizes met", q.size ? `${(100 * q.size.share).toFixed(1)} %` : "–"], ["triangles", r.n_triangles]];
      $("figures").replaceChildren(...figures.map(([name, value]) => {
        const div = document.createElement("div"), b = document.createElement("b"), span = document.createElement("span");
        b.textContent = typeof value === "string" ? value : short(value);
        span.textContent = name;
        div.append(b, span);
        return div;
      }));
      this.quality();
    }
    this.document();
  }
  /** The metric: histogram and the worst elements. */
  quality() {
    const { mesh } = this.view;
    this.histogram();
    $("worst").replaceChildren(...mesh.worst.map((e, k) => {
      const [x, y] = mesh.centre(e);
      return button([`${k + 1}. ${mesh.named(e)}`, short(mesh.values[e])], `at (${short(x)}, ${short(y)})`, () => { this.view.locate(e); this.actions.tell(e, x, y); });
    }));
  }
  histogram() {
    const { mesh } = this.view, c = $("histogram"), r = devicePixelRatio || 1, w = c.clientWidth, h = c.clientHeight;
    if (!mesh || !w) return;
    const g = c.getContext("2d"), m = mesh.metric, count = new Array(BINS).fill(0);
    c.width = w * r; c.height = h * r;
    g.scale(r, r);
    for (const x of mesh.values) if (!Number.isNaN(x)) count[Math.min(BINS - 1, Math.max(0, Math.floor((x - m.low) / (m.high - m.low) * BINS)))]++;
    const top = Math.max(...count, 1), base = h - 16, ink = getComputedStyle(document.body).color;
    g.font = "11px system-ui, sans-serif";
    count.forEach((n, i) => {
      const tall = n ? Math.max(2, (base - 14) * n / top) : 0;
      g.fillStyle = colour(mesh.goodness(m.low + (i + 0.5) / BINS * (m.high - m.low)));
      g.fillRect(i * w / BINS, base - tall, w / BINS - 1, tall);
    });
    g.fillStyle = ink;
    g.fillText(top.toLocaleString("en"), 2, 10);
    g.fillRect(0, base, w, 1);
    g.fillText(short(m.low), 0, h - 3);
    const end = short(m.high);
    g.fillText(end, w - g.measureText(end).width, h - 3);
  }
}
