// The view of a mesh in space: drag to turn, shift-drag or two fingers to move, wheel or pinch to zoom. Drawn by a depth
// buffer of our own: the number of the element at each pixel gives colours, lines between elements, and what a tap means.
let selected = -1, fast = false, seen = { w: 0, h: 0, id: new Int32Array(0) };

function prepare() {
  const p = m.points, n = p.length / 3;
  m.faceOf = decode(m.face_of_quad, Uint32Array);
  let low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < 3 * n; i++) { const k = i % 3; low[k] = Math.min(low[k], p[i]); high[k] = Math.max(high[k], p[i]); }
  m.low = low; m.high = high;
  m.normals = new Float32Array(3 * m.n);
  for (let e = 0; e < m.n; e++) {
    const [a, b, c, d] = [0, 1, 2, 3].map((k) => 3 * corner(e, k % size(e))), u = [0, 1, 2].map((k) => p[c + k] - p[a + k]);
    const v = [0, 1, 2].map((k) => (size(e) === 4 ? p[d + k] - p[b + k] : p[c + k] - p[b + k]));
    const w = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]], l = Math.hypot(...w) || 1;
    for (let k = 0; k < 3; k++) m.normals[3 * e + k] = w[k] / l;
  }
  m.side = new Float32Array(2 * n);
  m.deep = new Float32Array(n);
  selected = -1;
  lists();
}
function centre(e) {
  const n = size(e), c = [0, 0, 0];
  for (let k = 0; k < n; k++) for (let a = 0; a < 3; a++) c[a] += m.points[3 * corner(e, k) + a] / n;
  return c;
}
function lists() {
  const r = m.report, table = $("faces");
  $("faced").hidden = false;
  table.innerHTML = "<tr><th>face</th><th>surface</th><th class=n>quads</th><th class=n>smallest scaled Jacobian</th><th class=n>mean</th></tr>";
  m.faces.forEach((f, k) => {
    const tr = table.insertRow();
    tr.dataset.face = k;
    tr.tabIndex = 0;
    [f.name, f.kind, short(f.n_quads), f.n_quads ? short(f.min_sj) : "–", f.n_quads ? short(f.mean_sj) : "–"].forEach((text, i) => {
      const td = tr.insertCell();
      td.textContent = text;
      if (i > 1) td.className = "n";
    });
    tr.onclick = () => select(selected === k ? -1 : k);
    tr.onkeydown = (ev) => { if (ev.key === "Enter" || ev.key === " ") { tr.onclick(); ev.preventDefault(); } };
  });
  $("failed").hidden = r.failures.length === 0;
  $("failures").replaceChildren(...r.failures.map((f) => row([f.face, f.message])));
}
// Shows a face and greys the others; -1: all.
function select(k) {
  selected = k;
  for (const tr of document.querySelectorAll("tr[data-face]")) tr.setAttribute("aria-selected", String(Number(tr.dataset.face) === k));
  if (k >= 0) {
    const of = [...m.faceOf.keys()].filter((e) => m.faceOf[e] === k);
    if (of.length) { look(mean(of, (e) => [...m.normals.subarray(3 * e, 3 * e + 3)])); frame(of); }
  }
  draw();
}
function mean(list, of) {
  const c = [0, 0, 0];
  for (const e of list) of(e).forEach((x, a) => { c[a] += x / list.length; });
  return c;
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const l = Math.hypot(...a) || 1; return a.map((x) => x / l); };

// Turns the view so that `normal` looks at the eye, a little from the side; up stays up.
function look(normal) {
  const eye = unit(unit(normal).map((x, k) => x + 0.35 * view.right[k] + 0.25 * view.up[k]));
  const up = Math.abs(eye[2]) > 0.95 ? view.up : [0, 0, 1];
  view.right = unit(cross(up, eye));
  view.up = cross(eye, view.right);
  view.eye = eye;
}
// Moves and zooms so that these elements fill the view.
function frame(list) {
  const c = mean(list, centre);
  view.at = c;
  let reach = 0;
  for (const e of list) for (let k = 0; k < size(e); k++) reach = Math.max(reach, Math.hypot(...[0, 1, 2].map((a) => m.points[3 * corner(e, k) + a] - c[a])));
  view.s = Math.max(view.least, Math.min(canvas.clientWidth, canvas.clientHeight) / (2.4 * reach || 1));
}
function fit() {
  const eye = unit([0.55, -0.70, 0.46]), right = unit(cross([0, 0, 1], eye)), up = cross(eye, right);
  view = { eye, right, up, at: m.low.map((x, k) => 0.5 * (x + m.high[k])), s: 1, least: 0 };
  let w = 0, h = 0;
  for (let i = 0; i < m.points.length; i += 3) {
    const q = [0, 1, 2].map((k) => m.points[i + k] - view.at[k]);
    w = Math.max(w, Math.abs(dot(q, right))); h = Math.max(h, Math.abs(dot(q, up)));
  }
  view.s = Math.min((canvas.clientWidth - 32) / (2 * w || 1), (canvas.clientHeight - 32) / (2 * h || 1));
  view.least = view.s / 4;
}
function zoom(f, px = canvas.clientWidth / 2, py = canvas.clientHeight / 2) {
  const old = view.s, x = px - canvas.clientWidth / 2, y = canvas.clientHeight / 2 - py;
  view.s = Math.min(Math.max(view.s * f, view.least), view.least * 4e5);
  const g = 1 / old - 1 / view.s;
  view.at = view.at.map((c, k) => c + g * (x * view.right[k] + y * view.up[k]));
  draw();
}
function locate(e) {
  marked = e;
  look([...m.normals.subarray(3 * e, 3 * e + 3)]);
  frame([e]);
  view.s /= 6;
  tell(e);
  draw();
}
function turn(dx, dy) {
  const around = (a, b, t) => [a.map((x, k) => x * Math.cos(t) + b[k] * Math.sin(t)), b.map((x, k) => x * Math.cos(t) - a[k] * Math.sin(t))];
  // Left and right about the vertical, up and down about the horizontal of the screen.
  const c = Math.cos(-dx), s = Math.sin(-dx), about = (v) => [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
  view.eye = about(view.eye); view.right = about(view.right); view.up = about(view.up);
  [view.eye, view.up] = around(view.eye, view.up, dy);
  view.eye = unit(view.eye); view.right = unit(cross(view.up, view.eye)); view.up = cross(view.eye, view.right);
}
function move(dx, dy) { view.at = view.at.map((c, k) => c - (dx * view.right[k] - dy * view.up[k]) / view.s); }

const GREY = [150, 156, 166];
function paint() {
  wanted = 0;
  fast &&= fingers.size > 0;
  const began = performance.now(), r = Math.min(devicePixelRatio || 1, 2) * (fast ? 0.5 : 1);
  const w = Math.max(1, Math.round(canvas.clientWidth * r)), h = Math.max(1, Math.round(canvas.clientHeight * r)), s = view.s * r;
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const p = m.points, { side, deep } = m, { right, up, eye, at } = view;
  const [ox, oy, oz] = [dot(right, at), dot(up, at), dot(eye, at)];
  for (let v = 0, i = 0; i < p.length; v++, i += 3) {
    side[2 * v] = (right[0] * p[i] + right[1] * p[i + 1] + right[2] * p[i + 2] - ox) * s + w / 2;
    side[2 * v + 1] = h / 2 - (up[0] * p[i] + up[1] * p[i + 1] + up[2] * p[i + 2] - oy) * s;
    deep[v] = (eye[0] * p[i] + eye[1] * p[i + 1] + eye[2] * p[i + 2] - oz) * s;
  }
  const id = new Int32Array(w * h).fill(-1), depth = new Float32Array(w * h).fill(-Infinity);
  let drawn = 0, length = 0;
  for (let e = 0; e < m.n; e++) {
    const a = corner(e, 0), b = corner(e, 1), c = corner(e, 2);
    triangle(e, a, b, c, w, h, id, depth);
    if (size(e) === 4) triangle(e, a, c, corner(e, 3), w, h, id, depth);
    const x = side[2 * a], y = side[2 * a + 1];
    if (x > 0 && x < w && y > 0 && y < h) { drawn++; length += Math.hypot(side[2 * b] - x, side[2 * b + 1] - y); }
  }
  seen = { w, h, r, id };
  const light = unit([0, 1, 2].map((k) => 0.75 * eye[k] + 0.45 * up[k] - 0.3 * right[k]));
  const shade = new Uint32Array(m.n), colours = PALETTE.map((t) => t.match(/\d+/g).map(Number));
  for (let e = 0; e < m.n; e++) {
    const bright = 0.6 + 0.4 * Math.abs(dot([m.normals[3 * e], m.normals[3 * e + 1], m.normals[3 * e + 2]], light));
    let c = bin[e] < STEPS ? colours[bin[e]] : [153, 153, 153];
    if (selected >= 0 && m.faceOf[e] !== selected) c = GREY;
    shade[e] = 0xff000000 | (c[2] * bright) << 16 | (c[1] * bright) << 8 | c[0] * bright;
  }
  const image = ctx.createImageData(w, h), out = new Uint32Array(image.data.buffer), fine = drawn > 0 && length / drawn > 5;
  const dark = matchMedia("(prefers-color-scheme: dark)").matches, outer = dark ? 0xffb0a89a : 0xff20180f;
  for (let y = 0, i = 0; y < h; y++) {
    for (let x = 0; x < w; x++, i++) {
      const e = id[i], right = x + 1 < w ? id[i + 1] : e, down = y + 1 < h ? id[i + w] : e;
      if (e === right && e === down) { if (e >= 0) out[i] = shade[e]; continue; }
      const f = e < 0 ? -1 : m.faceOf[e], fr = right < 0 ? -1 : m.faceOf[right], fd = down < 0 ? -1 : m.faceOf[down];
      if (f !== fr || f !== fd) out[i] = e < 0 || fr < 0 || fd < 0 ? outer : 0xff140e08;
      else out[i] = fine ? dim(shade[e]) : shade[e];
    }
  }
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.putImageData(image, 0, 0);
  if (marked >= 0) {
    ctx.beginPath();
    for (let k = 0; k < size(marked); k++) ctx.lineTo(side[2 * corner(marked, k)], side[2 * corner(marked, k) + 1]);
    ctx.closePath();
    ctx.lineWidth = 5 * r; ctx.strokeStyle = "#fff"; ctx.stroke();
    ctx.lineWidth = 2.5 * r; ctx.strokeStyle = "#d1006c"; ctx.stroke();
  }
  if (fingers.size) fast = fast || performance.now() - began > 50;
}
const dim = (c) => 0xff000000 | (c >> 16 & 255) * 0.55 << 16 | (c >> 8 & 255) * 0.55 << 8 | (c & 255) * 0.55;

// Pixels of a triangle that are nearer than what is there.
function triangle(e, a, b, c, w, h, id, depth) {
  const q = m.side, ax = q[2 * a], ay = q[2 * a + 1], bx = q[2 * b], by = q[2 * b + 1], cx = q[2 * c], cy = q[2 * c + 1];
  const y0 = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5)), y1 = Math.min(h - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
  if (y0 > y1 || Math.max(ax, bx, cx) < 0 || Math.min(ax, bx, cx) > w) return;
  const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  if (area === 0) return;
  const za = m.deep[a], zx = ((m.deep[b] - za) * (cy - ay) - (m.deep[c] - za) * (by - ay)) / area;
  const zy = ((m.deep[c] - za) * (bx - ax) - (m.deep[b] - za) * (cx - ax)) / area;
  for (let y = y0; y <= y1; y++) {
    const Y = y + 0.5;
    let left = Infinity, right = -Infinity;
    for (let k = 0; k < 3; k++) {
      const [px, py, qx, qy] = k === 0 ? [ax, ay, bx, by] : k === 1 ? [bx, by, cx, cy] : [cx, cy, ax, ay];
      if ((py <= Y) !== (qy <= Y)) { const x = px + (Y - py) * (qx - px) / (qy - py); left = Math.min(left, x); right = Math.max(right, x); }
    }
    const x0 = Math.max(0, Math.ceil(left - 0.5)), x1 = Math.min(w - 1, Math.floor(right - 0.5));
    for (let x = x0, i = y * w + x0; x <= x1; x++, i++) {
      const z = za + (x + 0.5 - ax) * zx + (Y - ay) * zy;
      if (z > depth[i]) { depth[i] = z; id[i] = e; }
    }
  }
}

function tap(px, py) {
  const x = Math.floor(px * seen.r), y = Math.floor(py * seen.r), e = seen.id[y * seen.w + x] ?? -1;
  marked = e;
  if (e >= 0) tell(e);
  else $("here").textContent = "";
  draw();
}
function drag(dx, dy, ev, pinching) {
  if (pinching || ev.shiftKey || ev.buttons > 1) move(dx, dy);
  else turn(dx / 150, dy / 150);
}
const arrow = (x, y) => turn(0.2 * x, -0.2 * y);
function showAll() { fit(); select(-1); }
canvas.addEventListener("contextmenu", (ev) => ev.preventDefault());
start();
