// Elements in few words. No text ever becomes markup.
const SVG = "http://www.w3.org/2000/svg";

export function h(tag, given = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "class") made.className = value;
    else if (name in made && typeof value !== "string") made[name] = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

export function icon(...paths) {
  const made = document.createElementNS(SVG, "svg");
  made.setAttribute("viewBox", "0 0 24 24");
  made.setAttribute("aria-hidden", "true");
  for (const d of paths) {
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("d", d);
    made.append(path);
  }
  return made;
}

let count = 0;
export const fresh = (name) => `${name}-${++count}`;

export function card(title, ...children) {
  const id = fresh("card");
  const [aside, rest] = Array.isArray(children[0]) ? [children[0], children.slice(1)] : [[], children];
  return h("section", { class: "card", "aria-labelledby": id }, h("header", {}, h("h2", { id }, title), ...aside), ...rest);
}
