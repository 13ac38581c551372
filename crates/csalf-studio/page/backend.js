// The engine, wherever it runs: behind the local server, or as WebAssembly in a worker of this page.

/** Puts a reply apart: the head, and typed arrays on its bytes. */
export function decode(buffer) {
  const n = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, n)));
  const arrays = {};
  for (const [name, [start, count]] of Object.entries(head.arrays)) {
    const kind = name === "quads" || name === "triangles" ? Uint32Array : Float32Array;
    arrays[name] = new kind(buffer, 4 + n + start, count);
  }
  return { ...head, ...arrays };
}

/** The server that gave this page. Paths are relative: they begin with the token. */
class Server {
  async ask(path, body, signal) {
    const response = await fetch(`api/${path}`, { method: body === undefined ? "GET" : "POST", body, signal });
    if (!response.ok) throw new Error((await response.text()).trim() || response.statusText);
    return response;
  }
  async start() { return (await this.ask("start")).json(); }
  async open(name, bytes) { return (await this.ask(`open?name=${encodeURIComponent(name)}`, bytes)).json(); }
  async mesh(text, signal) { return decode(await (await this.ask("mesh", text, signal)).arrayBuffer()); }
  async export(text, format) {
    const response = await this.ask(`export?format=${format}`, text);
    const name = /filename="([^"]+)"/.exec(response.headers.get("content-disposition") ?? "")?.[1] ?? "mesh";
    return { name, blob: await response.blob() };
  }
}

/** The engine in a worker: one question after the other; nothing leaves the machine. */
class Inside {
  constructor() {
    this.worker = new Worker("worker.js", { type: "module" });
    this.waiting = new Map();
    this.n = 0;
    this.worker.onmessage = ({ data: { id, ok, value } }) => {
      const { resolve, reject } = this.waiting.get(id);
      this.waiting.delete(id);
      if (ok) resolve(value); else reject(new Error(value));
    };
    this.worker.onerror = (event) => {
      for (const { reject } of this.waiting.values()) reject(new Error(event.message || "the engine did not start"));
      this.waiting.clear();
    };
  }
  ask(what, ...args) {
    return new Promise((resolve, reject) => {
      this.waiting.set(++this.n, { resolve, reject });
      this.worker.postMessage({ id: this.n, what, args });
    });
  }
  async start() { return { documents: [], notes: [] }; }
  async open(name, bytes) { return JSON.parse(new TextDecoder().decode(await this.ask("open", name, bytes))); }
  async mesh(text) { return decode(await this.ask("mesh", text)); }
  async export(text, format) {
    const { name, bytes } = await this.ask("export", text, format);
    return { name, blob: new Blob([bytes], { type: "application/octet-stream" }) };
  }
}

export function backend() {
  const kind = document.querySelector('meta[name="csalf-backend"]').content;
  return kind === "worker" ? new Inside() : new Server();
}
