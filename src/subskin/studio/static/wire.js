// The socket: what is asked, of many asks the latest, what is told, and what to do when the server is gone.
const pending = new Map(); // by view: {sent, next}
const told = new Map(); // by view: what hears what it tells of itself
const again = new Set(); // what to do when the server is there again
let socket = null;
let number = 0;
let opened = false;
let watched = "";
const waits = new Map(); // by number: what hears the answer

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    const back = opened;
    opened = true;
    show("");
    if (watched) send({ view: "page", do: "watch", of: watched });
    for (const act of again) act(back);
  };
  socket.onmessage = (event) => hear(event.data);
  socket.onclose = () => {
    pending.clear();
    waits.clear();
    show("The server is not there: start “subskin studio” again. This page goes on by itself when it is back.");
    setTimeout(connect, 700);
  };
}

function show(text) {
  const banner = document.getElementById("lost");
  banner.hidden = !text;
  banner.textContent = text;
}

function send(message) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return 0;
  number += 1;
  socket.send(JSON.stringify({ id: number, ...message }));
  return number;
}

function hear(data) {
  const length = new DataView(data).getUint32(0, true);
  const said = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  let at = 4 + length;
  for (const field of said.fields ?? []) {
    const size = field.shape[0] * field.shape[1];
    field.bytes = new Uint8Array(data, at, size);
    at += size;
  }
  if (said.news) {
    told.get(said.view)?.(said);
    requestAnimationFrame(() => send({ view: "page", do: "drawn" }));
    return;
  }
  const heard = waits.get(said.id);
  waits.delete(said.id);
  heard?.(said);
}

// Ask once: each is done, in order.
export function ask(message, heard = () => {}) {
  const id = send(message);
  if (id) waits.set(id, heard);
}

// Whether an answer to what was asked as things move is on its way.
export const busy = (view) => pending.get(view)?.busy ?? false;

// Ask as things move: one is on its way, and of those that wait the latest goes next.
export function follow(message, heard) {
  const state = pending.get(message.view) ?? { busy: false, next: null };
  pending.set(message.view, state);
  if (state.busy) {
    state.next = [message, heard];
    return;
  }
  const id = send(message);
  if (!id) return;
  state.busy = true;
  waits.set(id, (said) => {
    state.busy = false;
    const next = state.next;
    state.next = null;
    if (next) follow(...next);
    heard(said, Boolean(next));
  });
}

export function watch(view, heard) {
  watched = view;
  if (heard) told.set(view, heard);
  send({ view: "page", do: "watch", of: view });
}

export function whenOpen(act) {
  again.add(act);
  if (socket?.readyState === WebSocket.OPEN) act(false);
  return () => again.delete(act);
}

export const begin = connect;
