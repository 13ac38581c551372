// A finished mesh as the page needs it: cells for drawing and taps, colours of a metric, the worst elements.

export const STEPS = 48;
const WORST = 25;
// From poor to good; told apart in the common kinds of colour blindness.
const STOPS = [[176, 24, 43], [239, 138, 98], [253, 219, 150], [186, 222, 200], [103, 169, 207], [33, 102, 172]];

export function colour(t) {
  const x = Math.min(Math.max(t, 0), 1) * (STOPS.length - 1), k = Math.min(Math.floor(x), STOPS.length - 2), f = x - k;
  return `rgb(${STOPS[k].map((a, c) => Math.round(a + f * (STOPS[k + 1][c] - a))).join(",")})`;
}
export const PALETTE = Array.from({ length: STEPS }, (_, i) => colour((i + 0.5) / STEPS));

/** A number for people. */
export const short = (x) => x === null || x === undefined || Number.isNaN(x) ? "–"
  : Number.isInteger(x) && Math.abs(x) < 1e7 ? x.toLocaleString("en") : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2)
  : Number(x.toPrecision(4)).toString();

export class Mesh {
  constructor(reply) {
    this.reply = reply;
    this.xy = reply.points;
    this.nq = reply.n_quads;
    this.n = reply.n_quads + reply.n_triangles;
    this.cells();
  }
  size(e) { return e < this.nq ? 4 : 3; }
  corner(e, k) { return e < this.nq ? this.reply.quads[4 * e + k] : this.reply.triangles[3 * (e - this.nq) + k]; }
  named(e) { return e < this.nq ? `quad ${e}` : `triangle ${e - this.nq}`; }
  /** The middle of an element, in the units of the model. */
  centre(e) {
    const n = this.size(e), { origin, scale } = this.reply;
    let x = 0, y = 0;
    for (let k = 0; k < n; k++) { const v = this.corner(e, k); x += this.xy[2 * v] / n; y += this.xy[2 * v + 1] / n; }
    return [origin[0] + scale * x, origin[1] + scale * y];
  }
  /** Largest distance of a corner from the middle. */
  reach(e) {
    const [x, y] = this.centre(e), { origin, scale } = this.reply;
    let reach = 0;
    for (let k = 0; k < this.size(e); k++) {
      const v = this.corner(e, k);
      reach = Math.max(reach, Math.hypot(origin[0] + scale * this.xy[2 * v] - x, origin[1] + scale * this.xy[2 * v + 1] - y));
    }
    return reach;
  }

  /** Square cells over the box of the mesh, with the elements whose middle they hold. */
  cells() {
    const { n, xy } = this, side = Math.max(1, Math.min(256, Math.ceil(Math.sqrt(n / 16))));
    const start = new Uint32Array(side * side + 1), cell = new Uint32Array(n);
    let reach = 0;
    for (let e = 0; e < n; e++) {
      const count = this.size(e);
      let x = 0, y = 0;
      for (let k = 0; k < count; k++) { const v = this.corner(e, k); x += xy[2 * v] / count; y += xy[2 * v + 1] / count; }
      for (let k = 0; k < count; k++) { const v = this.corner(e, k); reach = Math.max(reach, Math.abs(xy[2 * v] - x), Math.abs(xy[2 * v + 1] - y)); }
      const at = (t) => Math.min(side - 1, Math.max(0, Math.floor(t * side)));
      cell[e] = at(y) * side + at(x);
      start[cell[e] + 1]++;
    }
    for (let i = 0; i < side * side; i++) start[i + 1] += start[i];
    const next = start.slice(), list = new Uint32Array(n);
    for (let e = 0; e < n; e++) list[next[cell[e]]++] = e;
    this.grid = { side, start, list, reach };
  }
  /** Elements that may touch a box, given in the units of the model. */
  * within(xa, ya, xb, yb) {
    const g = this.grid, { origin, scale } = this.reply;
    const at = (t, axis, add) => Math.min(g.side - 1, Math.max(0, Math.floor(((t - origin[axis]) / scale + add) * g.side)));
    const i0 = at(xa, 0, -g.reach), i1 = at(xb, 0, g.reach), j0 = at(ya, 1, -g.reach), j1 = at(yb, 1, g.reach);
    for (let j = j0; j <= j1; j++)
      for (let s = g.start[j * g.side + i0]; s < g.start[j * g.side + i1 + 1]; s++) yield g.list[s];
  }
  /** The element at a point, or -1. */
  at(px, py) {
    const { origin, scale } = this.reply, x = (px - origin[0]) / scale, y = (py - origin[1]) / scale, xy = this.xy;
    for (const e of this.within(px, py, px, py)) {
      let inside = true;
      for (let k = 0, n = this.size(e); k < n && inside; k++) {
        const a = this.corner(e, k), b = this.corner(e, (k + 1) % n);
        inside = (xy[2 * b] - xy[2 * a]) * (y - xy[2 * a + 1]) - (xy[2 * b + 1] - xy[2 * a + 1]) * (x - xy[2 * a]) >= 0;
      }
      if (inside) return e;
    }
    return -1;
  }

  /** Chooses the metric: colours of all elements, and the worst ones. */
  choose(name) {
    this.metric = this.reply.metrics.find((m) => m.name === name) ?? this.reply.metrics[0];
    this.values = this.reply[this.metric.name];
    this.bin = new Uint8Array(this.n);
    let worst = [], bound = Infinity;
    const order = (a, b) => a[0] - b[0] || a[1] - b[1];
    for (let e = 0; e < this.n; e++) {
      const t = this.goodness(this.values[e]);
      this.bin[e] = Number.isNaN(t) ? STEPS : Math.min(STEPS - 1, Math.max(0, Math.floor(t * STEPS)));
      if (t < bound) {
        worst.push([t, e]);
        if (worst.length >= 4 * WORST) { worst.sort(order); worst.length = WORST; bound = worst[WORST - 1][0]; }
      }
    }
    this.worst = worst.sort(order).slice(0, WORST).map(([, e]) => e);
  }
  /** 0 poor to 1 good; beyond the scale, too. */
  goodness(x) {
    const m = this.metric, t = (x - m.low) / (m.high - m.low);
    return m.good === "high" ? t : m.good === "low" ? 1 - t : 1 - Math.abs(Math.log2(x));
  }
}
