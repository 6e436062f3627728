// Light or dark: what the system says, until the switch says otherwise.
const dark = matchMedia("(prefers-color-scheme: dark)");
const heard = new Set();
let kept = null;

const chosen = () => kept ?? localStorage.getItem("subskin.theme") ?? (dark.matches ? "dark" : "light");

function apply() {
  document.documentElement.dataset.theme = chosen();
  for (const act of heard) act();
}

export function switchTheme() {
  kept = chosen() === "dark" ? "light" : "dark";
  localStorage.setItem("subskin.theme", kept);
  apply();
}

export const isDark = () => chosen() === "dark";
export const onTheme = (act) => heard.add(act);
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

dark.addEventListener("change", apply);
apply();
