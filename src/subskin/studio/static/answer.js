// The answer in words and numbers: what was found, how surely, beside the truth, and what else it could have been.
import { h } from "./dom.js";
import { plain } from "./numbers.js";

const KIND = { OK: "good", AMBIGUOUS: "warn", NO_CONTACT: "", UNEXPLAINED: "bad", INCOMPLETE: "bad", "": "bad" };

export class Answer {
  constructor(heads = ["quantity", "found", "true"]) {
    this.heads = heads;
    this.status = h("p", { class: "status" });
    this.body = h("tbody");
    this.table = h("div", { class: "scroll" }, h("table", {},
      h("thead", {}, h("tr", {}, heads.map((head) => h("th", { scope: "col" }, head)))), this.body));
    this.more = h("div");
    this.element = h("div", { class: "answer" }, this.status, this.table, this.more);
  }

  show(found, notes) {
    clearTimeout(this.patience);
    if (found.pending) {
      this.#later(found);
      return;
    }
    this.status.textContent = found.words;
    this.status.dataset.kind = KIND[found.status] ?? "";
    this.status.dataset.status = found.status;
    const rows = found.rows.filter((row) => row.value !== null);
    this.table.hidden = !rows.length;
    this.body.replaceChildren(...rows.map((row) => h("tr", {}, h("th", { scope: "row" }, row.label), h("td", {}, h("b", {}, row.text)),
      this.heads.length > 2 ? h("td", {}, row.truth === null ? "–" : `${plain(row.truth, 4)} ${row.unit}`.replace(" °", "°")) : null)));
    const lines = [found.rival?.words, found.fit, ...notes].filter(Boolean);
    this.more.replaceChildren(...lines.map((text) => h("p", { class: "note" }, text)));
  }

  // The numbers of before are taken away, and their rows stay: nothing below jumps.
  #later(found) {
    this.status.textContent = found.words;
    this.status.dataset.kind = this.status.dataset.status = "";
    this.table.hidden = !this.body.children.length;
    for (const cell of this.body.querySelectorAll("td")) cell.textContent = "…";
    for (const line of this.more.children) line.textContent = "…";
    this.patience = setTimeout(() => {
      this.more.replaceChildren(h("p", { class: "note" }, "This takes longer the first time after installation: the estimator is being compiled. The picture follows meanwhile."));
    }, 3000);
  }
}

export function inWords(said) {
  const rows = said.found.rows.filter((row) => row.value !== null).map((row) => `${row.label} ${row.text.replace("±", "plus or minus")}`);
  return `${said.found.words} ${rows.join(", ")}`;
}
