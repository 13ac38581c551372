// The view of a plane mesh: drag to move, wheel or pinch to zoom.
function centre(e) {
  const n = size(e);
  let x = 0, y = 0;
  for (let k = 0; k < n; k++) { const v = corner(e, k); x += m.xy[2 * v] / n; y += m.xy[2 * v + 1] / n; }
  return [x, y];
}

// Cells of the box with the elements whose centre they hold: for drawing a part, and for taps.
function prepare() {
  m.xy = m.points;
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

function drag(dx, dy) { view.x -= dx / view.s; view.y += dy / view.s; }
const arrow = (x, y) => { view.x += 60 * x / view.s; view.y += 60 * y / view.s; };
function showAll() { fit(); draw(); }
start();
