// The document, its history, and all that can be done to it. Node lists and curves are never changed in place.

const blank = () => ({ job: { name: "drawing", loops: [], size: { kind: "boundary" }, layers: {} },
  curves: { loops: [], scars: [] }, resample: false });

/** True if a layer pattern means a name; `*` stands for any text. */
function matches(pattern, name) {
  const parts = pattern.split("*").map((p) => p.replace(/[.+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${parts.join(".*")}$`).test(name);
}

export class Model extends EventTarget {
  doc = blank();
  past = [];
  future = [];
  selected = null; // { loop: name } or { source: index }

  /** Tells of a change; `draft`: more will follow at once. */
  changed(draft = false) { this.dispatchEvent(new CustomEvent("change", { detail: { draft } })); }

  /** Keeps the present for undo; what follows is one step. */
  mark() {
    this.past.push(this.doc);
    if (this.past.length > 200) this.past.shift();
    this.future = [];
    this.doc = structuredClone(this.doc);
  }
  edit(change) { this.mark(); change(this.doc.job, this.doc); this.changed(); }
  undo() { this.swap(this.past, this.future); }
  redo() { this.swap(this.future, this.past); }
  swap(from, to) {
    if (!from.length) return;
    to.push(this.doc);
    this.doc = from.pop();
    this.keepSelection();
    this.changed();
  }
  keepSelection() {
    const s = this.selected;
    if (s && (s.loop !== undefined ? !this.loop(s.loop) : !this.sources[s.source])) this.selected = null;
  }
  select(what) { this.selected = what; this.dispatchEvent(new Event("select")); }

  /** Shows another document; undo leads back. */
  load(doc) {
    this.mark();
    const job = { layers: {}, size: { kind: "boundary" }, ...doc.job };
    // Every loop has its name, so that it keeps it when another one goes.
    let holes = 0;
    job.loops = job.loops.map((l) => ({ ...l, name: l.name ?? (l.kind === "outer" ? "outer" : `hole${holes}`), n: holes += l.kind === "hole" }))
      .map(({ n, ...l }) => l);
    this.doc = { job, resample: doc.resample ?? false,
      curves: { loops: doc.curves?.loops ?? job.loops.map(() => null), scars: doc.curves?.scars ?? [] } };
    this.selected = null;
    this.changed();
  }
  clear() { this.load(blank()); }

  get isEmpty() { return this.doc.job.loops.length === 0; }
  get sources() { return this.doc.job.size.sources ?? []; }
  get givenNodes() { return this.doc.curves.loops.some((c) => !c); }
  loop(name) { return this.doc.job.loops.find((l) => l.name === name); }

  /** Adds a loop of curves: the outer one if there is none, else a hole. */
  addLoop(curves) {
    const names = new Set(this.doc.job.loops.map((l) => l.name));
    const kind = this.doc.job.loops.some((l) => l.kind === "outer") ? "hole" : "outer";
    let name = kind;
    for (let k = 0; kind === "hole" ? name === "hole" || names.has(name) : names.has(name); k++) name = kind + k;
    this.selected = { loop: name };
    this.edit((job, doc) => { job.loops.push({ kind, name, nodes: [] }); doc.curves.loops.push(curves); });
  }
  removeLoop(name) {
    this.selected = null;
    this.edit((job, doc) => {
      const k = job.loops.findIndex((l) => l.name === name);
      job.loops.splice(k, 1);
      doc.curves.loops.splice(k, 1);
      delete job.layers[name];
    });
  }
  turnKind(name) {
    this.edit((job) => { const l = job.loops.find((x) => x.name === name); l.kind = l.kind === "outer" ? "hole" : "outer"; });
  }
  /** Moves a loop; call `mark` once before. */
  moveLoop(name, dx, dy) {
    const k = this.doc.job.loops.findIndex((l) => l.name === name), by = ([x, y]) => [x + dx, y + dy];
    const loop = this.doc.job.loops[k];
    loop.nodes = loop.nodes.map(by);
    this.doc.curves.loops[k] = this.doc.curves.loops[k]?.map((c) => {
      const [kind, v] = Object.entries(c)[0];
      if (kind === "arc") return { arc: { ...v, center: by(v.center) } };
      return { [kind]: Array.isArray(v) ? v.map(by) : { ...v, points: v.points.map(by) } };
    }) ?? null;
  }

  /** Layers that a loop gets: the last pattern that means it. */
  layersOf(name) {
    return Object.entries(this.doc.job.layers).filter(([p]) => matches(p, name)).pop()?.[1] ?? null;
  }
  /** Sets the layers of a name or pattern; `null`: as the program likes. A later entry wins, so it goes to the end. */
  setLayers(pattern, spec) {
    this.edit((job) => {
      for (const known of Object.keys(job.layers)) if (known === pattern || (pattern === "hole*" && known.startsWith("hole"))) delete job.layers[known];
      if (spec) job.layers[pattern] = spec;
    });
  }

  /** The edge length away from sources; `null`: as the outline. */
  get size() { const s = this.doc.job.size; return s.kind === "uniform" ? s.h : s.kind === "sources" ? s.far : null; }
  setSize(h, usual) {
    const size = this.doc.job.size;
    if (size.sources?.length) this.doc.job.size = { ...size, far: h ?? usual };
    else this.doc.job.size = h ? { kind: "uniform", h } : { kind: "boundary" };
  }
  addSource(source, usual) {
    this.edit((job) => { job.size = { kind: "sources", far: this.size ?? usual, sources: [...this.sources, source] }; });
    this.select({ source: this.sources.length - 1 });
  }
  changeSource(k, values) {
    const sources = this.sources.slice();
    sources[k] = { ...sources[k], ...values };
    this.doc.job.size = { ...this.doc.job.size, sources };
  }
  removeSource(k) {
    this.selected = null;
    this.edit((job) => {
      const sources = this.sources.filter((_, i) => i !== k), far = job.size.far;
      job.size = sources.length ? { kind: "sources", far, sources } : { kind: "uniform", h: far };
    });
  }
}
