// The canvas: where one looks, and all that is drawn.
import { PALETTE, STEPS } from "./mesh.js";

export class View {
  constructor(canvas, model) {
    this.canvas = canvas;
    this.ctx = canvas.getContext("2d");
    this.model = model;
    this.x = 0; this.y = 0; this.s = 1; // middle in the units of the model, pixels per unit
    this.home = [-6, -4.5, 6, 4.5];
    this.reply = null; // the last answer
    this.mesh = null; // the last mesh; stays while the document is wrong for a moment
    this.marked = -1; // an element
    this.place = null; // a defect being shown
    this.sketch = null; // what a tool is drawing: a list of points
    this.pending = 0;
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }
  get w() { return this.canvas.clientWidth; }
  get h() { return this.canvas.clientHeight; }
  X(x) { return (x - this.x) * this.s + this.w / 2; }
  Y(y) { return (this.y - y) * this.s + this.h / 2; }
  /** The point of the model under a pixel. */
  at(px, py) { return [this.x + (px - this.w / 2) / this.s, this.y - (py - this.h / 2) / this.s]; }

  /** Takes an answer of the engine. */
  show(reply, mesh) {
    this.reply = reply;
    this.mesh = mesh;
    this.marked = -1;
    this.lines = [];
    let k = 0;
    for (const c of [...reply.loops.map((l) => ({ ...l, closed: true })), ...reply.scars]) {
      const points = [];
      for (let i = 0; i < c.n; i++, k += 2) {
        points.push([reply.origin[0] + reply.scale * reply.outline[k], reply.origin[1] + reply.scale * reply.outline[k + 1]]);
      }
      this.lines.push({ ...c, points });
    }
    this.draw();
  }
  box() {
    const points = (this.lines ?? []).flatMap((l) => l.points);
    if (points.length < 2) return this.home;
    const b = [Infinity, Infinity, -Infinity, -Infinity];
    for (const [x, y] of points) { b[0] = Math.min(b[0], x); b[1] = Math.min(b[1], y); b[2] = Math.max(b[2], x); b[3] = Math.max(b[3], y); }
    return b[2] > b[0] || b[3] > b[1] ? b : this.home;
  }
  get extent() { const b = this.box(); return Math.max(b[2] - b[0], b[3] - b[1]); }
  fit() {
    // Room for the buttons on the right and the line of text below.
    const [x0, y0, x1, y1] = this.box(), pad = 20, right = 50, below = 28;
    this.s = Math.min((this.w - 2 * pad - right) / (x1 - x0 || 1), (this.h - 2 * pad - below) / (y1 - y0 || 1));
    if (!(this.s > 0)) this.s = 1;
    this.x = 0.5 * (x0 + x1) + 0.5 * right / this.s; this.y = 0.5 * (y0 + y1) - 0.5 * below / this.s;
    this.draw();
  }
  zoom(f, px = this.w / 2, py = this.h / 2) {
    const [x, y] = this.at(px, py), e = this.extent;
    this.s = Math.min(Math.max(this.s * f, 20 / e), 1e9 / e);
    const [qx, qy] = this.at(px, py);
    this.x += x - qx; this.y += y - qy;
    this.draw();
  }
  pan(dx, dy) { this.x -= dx / this.s; this.y += dy / this.s; this.draw(); }
  /** Looks at an element. */
  locate(e) {
    this.marked = e;
    this.place = null;
    [this.x, this.y] = this.mesh.centre(e);
    this.s = Math.min(this.w, this.h) / (14 * this.mesh.reach(e) || 1);
    this.draw();
  }
  /** Looks at a place of the model. */
  goto([x, y]) {
    this.place = [x, y];
    const segments = (this.reply?.loops ?? []).map((l) => l.segment).filter((s) => s > 0);
    const near = segments.length ? Math.min(this.extent / 4, 12 * Math.min(...segments)) : this.extent / 4;
    this.x = x; this.y = y;
    this.s = Math.min(this.w, this.h) / near;
    this.draw();
  }

  draw() { if (!this.pending) this.pending = requestAnimationFrame(() => { this.pending = 0; this.paint(); }); }
  paint() {
    const { canvas, ctx, w, h } = this, r = devicePixelRatio || 1;
    if (canvas.width !== Math.round(w * r) || canvas.height !== Math.round(h * r)) { canvas.width = Math.round(w * r); canvas.height = Math.round(h * r); }
    ctx.setTransform(r, 0, 0, r, 0, 0);
    ctx.clearRect(0, 0, w, h);
    const style = getComputedStyle(document.body), colour = (name) => style.getPropertyValue(name).trim();
    if (this.mesh) this.paintMesh(this.reply.ok ? 1 : 0.25);
    this.paintLines(colour("--ink"), colour("--mark"));
    this.paintSources(colour("--mark"), colour("--paper"));
    if (this.reply && !this.reply.ok) {
      for (const e of this.reply.errors) for (const p of e.places) this.cross(p, colour("--bad"), 6);
    }
    if (this.place) this.ring(this.place, colour("--bad"));
    if (this.sketch) this.trace(this.sketch, false, 2, colour("--mark"));
  }
  paintMesh(strength) {
    const { ctx, mesh, w, h } = this, xy = mesh.xy, { origin, scale } = mesh.reply;
    const [xa, yb] = this.at(0, 0), [xb, ya] = this.at(w, h);
    const a = scale * this.s, bx = (origin[0] - this.x) * this.s + w / 2, by = (this.y - origin[1]) * this.s + h / 2;
    const groups = Array.from({ length: STEPS + 1 }, () => []);
    let n = 0;
    for (const e of mesh.within(xa, ya, xb, yb)) { groups[mesh.bin[e]].push(e); n++; }
    const pixels = Math.sqrt(Math.max(1, w * h) / Math.max(1, n));
    const path = (e) => {
      const n = mesh.size(e);
      for (let i = 0; i < n; i++) {
        const v = mesh.corner(e, i), x = a * xy[2 * v] + bx, y = by - a * xy[2 * v + 1];
        if (i) ctx.lineTo(x, y); else ctx.moveTo(x, y);
      }
      ctx.closePath();
    };
    ctx.globalAlpha = strength;
    groups.forEach((list, k) => {
      if (!list.length) return;
      ctx.beginPath();
      list.forEach(path);
      ctx.fillStyle = k < STEPS ? PALETTE[k] : "#999";
      ctx.fill();
      if (pixels > 4) { ctx.lineWidth = Math.min(1, pixels / 12); ctx.strokeStyle = "rgba(20, 26, 38, 0.65)"; }
      else { ctx.lineWidth = 0.7; ctx.strokeStyle = ctx.fillStyle; }
      ctx.stroke();
    });
    ctx.globalAlpha = 1;
    if (this.marked >= 0) {
      ctx.beginPath();
      path(this.marked);
      ctx.lineWidth = 5; ctx.strokeStyle = "#fff"; ctx.stroke();
      ctx.lineWidth = 2.5; ctx.strokeStyle = "#d1006c"; ctx.stroke();
    }
  }
  trace(points, closed, width, style) {
    const { ctx } = this;
    ctx.beginPath();
    points.forEach(([x, y]) => ctx.lineTo(this.X(x), this.Y(y)));
    if (closed) ctx.closePath();
    ctx.lineWidth = width; ctx.strokeStyle = style; ctx.lineJoin = "round";
    ctx.stroke();
  }
  paintLines(ink, mark) {
    const chosen = this.model.selected?.loop;
    for (const l of this.lines ?? []) this.trace(l.points, l.closed, 1.6, ink);
    const l = (this.lines ?? []).find((l) => l.closed && l.name === chosen);
    if (l) this.trace(l.points, true, 4, mark);
    const r = this.reply, p = r?.hard_points ?? [];
    for (let i = 0; i < p.length; i += 2) this.dot([r.origin[0] + r.scale * p[i], r.origin[1] + r.scale * p[i + 1]], 3, ink);
  }
  paintSources(mark, paper) {
    const { ctx } = this;
    this.model.sources.forEach((s, k) => {
      const chosen = this.model.selected?.source === k;
      ctx.strokeStyle = mark;
      for (const [radius, dash] of [[s.radius, []], [s.radius + s.falloff, [4, 4]]]) {
        ctx.beginPath();
        ctx.setLineDash(dash);
        ctx.arc(this.X(s.xy[0]), this.Y(s.xy[1]), Math.min(radius * this.s, 1e6), 0, 2 * Math.PI);
        ctx.lineWidth = chosen ? 2.5 : 1.2;
        ctx.stroke();
      }
      ctx.setLineDash([]);
      this.dot(s.xy, 9, paper);
      this.dot(s.xy, 7, mark);
      if (chosen) { this.dot([s.xy[0] + s.radius, s.xy[1]], 7, paper); this.dot([s.xy[0] + s.radius, s.xy[1]], 5, mark); }
    });
  }
  dot([x, y], radius, style) {
    this.ctx.beginPath();
    this.ctx.arc(this.X(x), this.Y(y), radius, 0, 2 * Math.PI);
    this.ctx.fillStyle = style;
    this.ctx.fill();
  }
  cross([x, y], style, k) {
    const { ctx } = this, px = this.X(x), py = this.Y(y);
    for (const [width, colour] of [[6, "#fff"], [3, style]]) {
      ctx.beginPath();
      ctx.moveTo(px - k, py - k); ctx.lineTo(px + k, py + k); ctx.moveTo(px - k, py + k); ctx.lineTo(px + k, py - k);
      ctx.lineWidth = width; ctx.strokeStyle = colour;
      ctx.stroke();
    }
  }
  ring([x, y], style) {
    const { ctx } = this;
    ctx.beginPath();
    ctx.arc(this.X(x), this.Y(y), 16, 0, 2 * Math.PI);
    ctx.lineWidth = 3; ctx.strokeStyle = style;
    ctx.stroke();
  }

  /** The loop whose line, or else whose hole, is at a pixel. */
  loopAt(px, py, reach = 12) {
    let best = null, least = reach;
    for (const l of this.lines ?? []) {
      if (!l.closed) continue;
      l.points.forEach((a, i) => {
        const d = distance(px, py, this.px(a), this.px(l.points[(i + 1) % l.points.length]));
        if (d < least) { least = d; best = l.name; }
      });
    }
    if (best !== null) return best;
    const [x, y] = this.at(px, py);
    return (this.lines ?? []).find((l) => l.closed && l.kind === "hole" && inside(l.points, x, y))?.name ?? null;
  }
  px([x, y]) { return [this.X(x), this.Y(y)]; }
}

function distance(x, y, [ax, ay], [bx, by]) {
  const dx = bx - ax, dy = by - ay, l = dx * dx + dy * dy;
  const t = l > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / l)) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}
function inside(points, x, y) {
  let odd = false;
  points.forEach(([ax, ay], i) => {
    const [bx, by] = points[(i + 1) % points.length];
    if ((ay > y) !== (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax)) odd = !odd;
  });
  return odd;
}
