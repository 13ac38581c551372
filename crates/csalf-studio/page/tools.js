// Pointers and keys on the canvas: moving the view, selecting, drawing, dragging.

/** Hit radius of handles in pixels. */
const HANDLE = 14;

export class Tools {
  constructor(view, model, actions) {
    Object.assign(this, { view, model, actions });
    this.tool = "select";
    this.fingers = new Map();
    this.drag = null; // what the one finger is doing: a function (x, y, px, py, dx, dy), with `end`
    this.moved = 0;
    this.corners = []; // of the polygon being drawn
    const c = view.canvas;
    c.addEventListener("pointerdown", (ev) => this.down(ev));
    c.addEventListener("pointermove", (ev) => this.move(ev));
    c.addEventListener("pointerup", (ev) => this.up(ev));
    c.addEventListener("pointercancel", (ev) => this.up(ev));
    c.addEventListener("wheel", (ev) => { ev.preventDefault(); view.zoom(Math.exp(-ev.deltaY * (ev.deltaMode ? 0.05 : 0.0015)), ev.offsetX, ev.offsetY); }, { passive: false });
    c.addEventListener("dblclick", () => this.closePolygon());
    document.addEventListener("keydown", (ev) => this.key(ev));
    document.querySelectorAll("#tools button").forEach((b) => { b.onclick = () => this.choose(b.dataset.tool); });
  }
  choose(tool) {
    this.tool = tool;
    this.corners = [];
    this.view.sketch = null;
    document.querySelectorAll("#tools button").forEach((b) => b.setAttribute("aria-pressed", String(b.dataset.tool === tool)));
    this.view.canvas.classList.toggle("draws", tool !== "select");
    this.actions.say({
      select: "Drag to move, wheel or two fingers to zoom; a tap selects.",
      rectangle: "Drag from corner to corner.", circle: "Drag from the centre to the rim.",
      polygon: "Tap corner by corner; the first one, a double tap or Enter closes it.",
      source: "Tap where the mesh shall be finer.",
    }[tool]);
    this.view.draw();
  }
  /** A point on round numbers about as fine as the screen. */
  snap(px, py) {
    const unit = 10 ** Math.floor(Math.log10(12 / this.view.s));
    return this.view.at(px, py).map((t) => Number((Math.round(t / unit) * unit).toPrecision(12)));
  }

  down(ev) {
    const c = this.view.canvas, px = ev.offsetX, py = ev.offsetY;
    c.setPointerCapture(ev.pointerId);
    c.focus({ preventScroll: true });
    this.fingers.set(ev.pointerId, [px, py]);
    if (this.fingers.size > 1) { this.moved = 99; this.drag = null; this.view.sketch = null; return; }
    this.moved = 0;
    this.drag = this.tool === "rectangle" || this.tool === "circle" ? this.drawing(px, py)
      : this.tool === "select" ? this.grabbing(px, py) : null;
  }
  move(ev) {
    const old = this.fingers.get(ev.pointerId), px = ev.offsetX, py = ev.offsetY;
    if (!old) {
      if (this.corners.length) { this.view.sketch = [...this.corners, this.snap(px, py)]; this.view.draw(); }
      return;
    }
    this.fingers.set(ev.pointerId, [px, py]);
    this.moved += Math.hypot(px - old[0], py - old[1]);
    const other = [...this.fingers].find(([id]) => id !== ev.pointerId)?.[1];
    if (other) {
      const span = (p) => Math.max(1, Math.hypot(p[0] - other[0], p[1] - other[1]));
      this.view.pan(0.5 * (px - old[0]), 0.5 * (py - old[1]));
      this.view.zoom(span([px, py]) / span(old), (px + other[0]) / 2, (py + other[1]) / 2);
    } else if (this.moved < 4) return;
    else if (this.drag) this.drag.to(px, py, px - old[0], py - old[1]);
    else this.view.pan(px - old[0], py - old[1]);
  }
  up(ev) {
    const at = this.fingers.get(ev.pointerId), drag = this.drag;
    this.fingers.delete(ev.pointerId);
    if (this.fingers.size) return;
    this.drag = null;
    if (!at) return;
    if (this.moved >= 4) { if (this.moved < 99 || drag) drag?.end?.(...at); }
    else if (ev.type === "pointerup") this.tap(...at);
  }

  /** A rectangle or circle between where the finger came down and where it is. */
  drawing(px, py) {
    const [ax, ay] = this.snap(px, py), circle = this.tool === "circle";
    let curves = null;
    return {
      to: (qx, qy) => {
        const [bx, by] = this.snap(qx, qy), r = Number(Math.hypot(bx - ax, by - ay).toPrecision(6));
        if (circle) {
          curves = r > 0 ? [{ arc: { center: [ax, ay], radii: [r, r], rotation: 0, start: 0, sweep: 2 * Math.PI } }] : null;
          this.view.sketch = Array.from({ length: 65 }, (_, i) => [ax + r * Math.cos(i * Math.PI / 32), ay + r * Math.sin(i * Math.PI / 32)]);
          this.actions.say(`circle around (${ax}, ${ay}), radius ${r}`);
        } else {
          const p = [[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]];
          curves = ax !== bx && ay !== by ? [{ polyline: p }] : null;
          this.view.sketch = p;
          this.actions.say(`(${ax}, ${ay}) to (${bx}, ${by})`);
        }
        this.view.draw();
      },
      end: () => { this.finish(curves); },
    };
  }
  finish(curves) {
    const first = this.model.isEmpty;
    this.choose("select");
    if (curves) { this.actions.fitNext(first); this.model.addLoop(curves); }
  }
  closePolygon() {
    if (this.tool !== "polygon" || this.corners.length < 3) return;
    this.finish([{ polyline: [...this.corners, this.corners[0]] }]);
  }

  /** What a drag in select mode takes hold of: a handle of a source, the selected loop, or nothing. */
  grabbing(px, py) {
    const { view, model } = this, near = (p) => Math.hypot(view.X(p[0]) - px, view.Y(p[1]) - py) < HANDLE;
    const once = (change) => {
      let begun = false;
      return {
        to: (...args) => { if (!begun) { begun = true; model.mark(); } change(...args); model.changed(true); },
        end: () => { if (begun) model.changed(); },
      };
    };
    const chosen = model.selected?.source, s = model.sources[chosen];
    if (s && s.radius * view.s > HANDLE && near([s.xy[0] + s.radius, s.xy[1]])) {
      return once((qx, qy) => {
        const [x, y] = this.snap(qx, qy);
        model.changeSource(chosen, { radius: Number(Math.hypot(x - s.xy[0], y - s.xy[1]).toPrecision(6)) });
      });
    }
    const k = model.sources.findIndex((s) => near(s.xy));
    if (k >= 0) {
      model.select({ source: k });
      return once((qx, qy) => model.changeSource(k, { xy: this.snap(qx, qy) }));
    }
    const loop = model.selected?.loop;
    if (loop !== undefined && view.loopAt(px, py, 10) === loop) {
      let [x0, y0] = this.snap(px, py);
      return once((qx, qy) => {
        const [x, y] = this.snap(qx, qy);
        model.moveLoop(loop, x - x0, y - y0);
        [x0, y0] = [x, y];
      });
    }
    return null;
  }

  tap(px, py) {
    const { view, model } = this;
    if (this.tool === "source") {
      const extent = view.extent, round = (x) => Number(x.toPrecision(2)), usual = this.actions.usualSize();
      this.choose("select");
      model.addSource({ xy: this.snap(px, py), h: round(usual / 3), radius: round(extent / 20), falloff: round(extent / 6) }, usual);
      return;
    }
    if (this.tool === "polygon") {
      const p = this.snap(px, py), [first] = this.corners, last = this.corners[this.corners.length - 1];
      if (first && this.corners.length > 2 && Math.hypot(view.X(first[0]) - px, view.Y(first[1]) - py) < HANDLE) this.closePolygon();
      else if (!last || last[0] !== p[0] || last[1] !== p[1]) {
        this.corners.push(p);
        view.sketch = [...this.corners, p];
        this.actions.say(`${this.corners.length} corners, the last at (${p[0]}, ${p[1]})`);
        view.draw();
      }
      return;
    }
    const near = model.sources.findIndex((s) => Math.hypot(view.X(s.xy[0]) - px, view.Y(s.xy[1]) - py) < HANDLE);
    const loop = view.loopAt(px, py);
    view.place = null;
    if (near >= 0) model.select({ source: near });
    else if (loop !== null) { view.marked = -1; model.select({ loop }); }
    else {
      model.select(null);
      const [x, y] = view.at(px, py);
      view.marked = view.mesh?.at(x, y) ?? -1;
      this.actions.tell(view.marked, x, y);
    }
    view.draw();
  }

  key(ev) {
    const inField = /^(INPUT|SELECT|TEXTAREA)$/.test(ev.target.tagName), { view, model } = this;
    if ((ev.ctrlKey || ev.metaKey) && ev.key.toLowerCase() === "z" && !inField) {
      if (ev.shiftKey) model.redo(); else model.undo();
    } else if (inField || ev.ctrlKey || ev.metaKey || ev.altKey) return;
    else if (ev.key === "Escape") { this.choose("select"); model.select(null); }
    else if (ev.key === "Enter" && this.tool === "polygon") this.closePolygon();
    else if ((ev.key === "Delete" || ev.key === "Backspace") && model.selected) {
      if (model.selected.loop !== undefined) model.removeLoop(model.selected.loop);
      else model.removeSource(model.selected.source);
    } else if (ev.target === view.canvas && ev.key.startsWith("Arrow")) {
      const step = 60, [dx, dy] = { ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[ev.key];
      view.pan(dx, dy);
    } else if (ev.key === "+" || ev.key === "=") view.zoom(1.3);
    else if (ev.key === "-") view.zoom(1 / 1.3);
    else if (ev.key === "0") view.fit();
    else if (ev.key.toLowerCase() === "o") this.actions.open();
    else {
      const tool = { v: "select", r: "rectangle", c: "circle", p: "polygon", s: "source" }[ev.key.toLowerCase()];
      if (!tool) return;
      this.choose(tool);
    }
    ev.preventDefault();
  }
}
