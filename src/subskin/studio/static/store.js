// What is shown, what was shown before, and the link that holds it.
const text = new TextEncoder();

async function packed(value) {
  const stream = new Blob([text.encode(JSON.stringify(value))]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpacked(letters) {
  const bytes = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return JSON.parse(await new Response(stream).text());
}

// The address: #view, or #view=state.
export function where() {
  const [view, state] = decodeURIComponent(location.hash.slice(1)).split("=");
  return { view: view || "finger", state: state ?? "" };
}

export async function linked() {
  const { state } = where();
  if (!state) return null;
  try {
    return await unpacked(state);
  } catch {
    return null;
  }
}

export class Store {
  constructor(view) {
    this.view = view;
    this.state = null;
    this.past = [];
    this.future = [];
    this.heard = () => {};
  }

  // A state that stays: it can be undone, and the address holds it.
  async commit(state) {
    const same = this.kept && JSON.stringify(state) === JSON.stringify(this.kept);
    if (this.kept && !same) {
      this.past.push(this.kept);
      if (this.past.length > 200) this.past.shift();
      this.future = [];
    }
    this.kept = state;
    this.state = state;
    this.heard();
    await this.address();
  }

  async address() {
    if (!this.kept || where().view !== this.view) return;
    const hash = `#${this.view}=${await packed(this.kept)}`;
    if (where().view === this.view) history.replaceState(null, "", hash);
  }

  undo() {
    return this.#step(this.past, this.future);
  }

  redo() {
    return this.#step(this.future, this.past);
  }

  #step(from, to) {
    const state = from.pop();
    if (!state) return null;
    to.push(this.kept);
    this.kept = state;
    this.state = state;
    this.heard();
    this.address();
    return state;
  }
}
