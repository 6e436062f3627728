// The page: its views, the tools that all of them have, and the theme.
import { CalibrateView } from "./calibrate.js";
import { DesignView } from "./design.js";
import { h, icon } from "./dom.js";
import { FingerView } from "./finger.js";
import { LiveView } from "./live.js";
import { MemoView } from "./memo.js";
import { copied } from "./save.js";
import { where } from "./store.js";
import { switchTheme } from "./theme.js";
import { begin } from "./wire.js";

const VIEWS = { finger: ["Finger", FingerView], live: ["Live", LiveView], calibrate: ["Calibrate", CalibrateView], design: ["Design", DesignView], memo: ["Memo", MemoView] };
const made = {}; // views by name, and how one shows another

function current() {
  const { view } = where();
  return view in VIEWS ? view : "finger";
}

function open() {
  const name = current();
  made[name] ??= new VIEWS[name][1](made);
  for (const link of tabs.querySelectorAll("a")) {
    if (link.dataset.view === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  const main = document.getElementById("main");
  if (main.firstChild !== made[name].element) {
    made[made.shown]?.leave?.();
    main.replaceChildren(made[name].element);
    made.shown = name;
    made[name].enter?.();
    document.title = `${VIEWS[name][0]} – subskin studio`;
  }
  refresh();
}

// Another view takes something to show.
made.show = (name, state) => {
  history.pushState(null, "", `#${name}`);
  open();
  made[name].take(state);
};

const tabs = document.getElementById("tabs");
tabs.append(...Object.entries(VIEWS).map(([name, [label]]) => {
  const link = h("a", { href: `#${name}`, "data-view": name }, label);
  link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    history.pushState(null, "", `#${name}`);
    open();
    made[name].store?.address();
  });
  return link;
}));

const tool = (label, paths, act) => h("button", { class: "icon", type: "button", "aria-label": label, title: label, onclick: act }, icon(...paths));
const undo = tool("Undo", ["M9 14 4 9l5-5", "M4 9h10a6 6 0 0 1 0 12h-3"], () => made[current()].undo?.());
const redo = tool("Redo", ["m15 14 5-5-5-5", "M20 9H10a6 6 0 0 0 0 12h3"], () => made[current()].redo?.());
const link = tool("Copy the link to what is shown", ["M10 14a4 4 0 0 0 6 .4l3-3a4.2 4.2 0 0 0-6-6l-1.500 1.500", "M14 10a4 4 0 0 0-6-.4l-3 3a4.200 4.200 0 0 0 6 6L12.500 17"], () => copied(location.href, link));
const theme = tool("Light or dark", ["M12 3a9 9 0 1 0 9 9 7 7 0 0 1-9-9Z"], switchTheme);
document.getElementById("tools").append(undo, redo, link, theme);

function refresh() {
  const store = made[current()]?.store;
  undo.disabled = !store?.past.length;
  redo.disabled = !store?.future.length;
  if (store) store.heard = refresh;
}

addEventListener("keydown", (event) => {
  const typing = event.target.closest?.("input[type=text], textarea");
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || typing) return;
  event.preventDefault();
  if (event.shiftKey) made[current()].redo?.();
  else made[current()].undo?.();
});
addEventListener("popstate", open);
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault();
  document.getElementById("main").focus();
});
open();
begin();
