// The engine as WebAssembly: answers the questions of backend.js (class Inside) one after the other.

const utf8 = new TextEncoder(), text = new TextDecoder();
let compiled, engine;

async function start() {
  compiled ??= await WebAssembly.compile(await (await fetch("csalf.wasm")).arrayBuffer());
  // What libraries would ask of a page (the time of day, an identity for a drawing) has no say in a mesh: they get 0.
  const imports = {};
  for (const { module, name, kind } of WebAssembly.Module.imports(compiled)) {
    if (kind === "function") (imports[module] ??= {})[name] = () => 0;
  }
  engine = (await WebAssembly.instantiate(compiled, imports)).exports;
}

/** Calls a function with bytes (and the length of the name before them); gives a copy of the answer. */
function call(name, parts, k) {
  const n = parts.reduce((sum, p) => sum + p.length, 0), at = engine.csalf_input(n);
  let end = at;
  for (const p of parts) { new Uint8Array(engine.memory.buffer).set(p, end); end += p.length; }
  const refused = engine[name](k);
  const bytes = new Uint8Array(engine.memory.buffer, engine.csalf_output(), engine.csalf_output_len()).slice();
  if (refused) throw new Error(text.decode(bytes));
  return bytes;
}

const answers = {
  open(name, file) { const n = utf8.encode(name); return call("csalf_open", [n, file], n.length); },
  mesh(document) { return call("csalf_mesh", [utf8.encode(document)]).buffer; },
  export(document, format) {
    const f = utf8.encode(format), bytes = call("csalf_export", [f, utf8.encode(document)], f.length);
    const n = new DataView(bytes.buffer).getUint32(0, true);
    return { name: text.decode(bytes.subarray(4, 4 + n)), bytes: bytes.slice(4 + n) };
  },
};

self.onmessage = async ({ data: { id, what, args } }) => {
  try {
    if (!engine) await start();
    const value = answers[what](...args);
    self.postMessage({ id, ok: true, value });
  } catch (error) {
    // A module that broke down is not used again.
    if (error instanceof WebAssembly.RuntimeError) engine = null;
    self.postMessage({ id, ok: false, value: error.message });
  }
};
