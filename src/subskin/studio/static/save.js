// What can be kept: the finger as a file, the touch as a program, the picture, the link.
import { h } from "./dom.js";
import { say } from "./say.js";
import { ask } from "./wire.js";

export function download(name, content, type = "text/plain") {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const address = URL.createObjectURL(blob);
  const link = h("a", { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

export async function copied(text, button) {
  const before = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = h("textarea", { class: "hidden" }, text);
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
    button.focus();
  }
  if (!button.querySelector("svg")) button.textContent = "Copied";
  say("Copied", 0);
  setTimeout(() => { if (!button.querySelector("svg")) button.textContent = before; }, 1500);
}

async function picture(view, kind) {
  const answer = await fetch(`/picture.${kind}`, { method: "POST", body: JSON.stringify(view.store.state) });
  if (answer.ok) download(`finger.${kind}`, await answer.blob());
  else say(await answer.text(), 0);
}

export function saveMenu(view) {
  const button = (text, act) => h("button", { class: "button", type: "button", onclick: act }, text);
  return h("div", { class: "buttons" },
    button("Save finger.toml", () => download(view.name, view.store.state.text, "application/toml")),
    button("Copy as Python", (event) => {
      const target = event.currentTarget;
      ask({ view: "finger", do: "script", state: view.store.state }, (said) => copied(said.script, target));
    }),
    button("Picture, SVG", () => picture(view, "svg")),
    button("Picture, PNG", () => picture(view, "png")));
}
