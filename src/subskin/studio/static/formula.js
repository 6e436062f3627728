// A formula's tree as MathML, which browsers draw themselves.
const MATH = "http://www.w3.org/1998/Math/MathML";
const TAGS = { row: "mrow", frac: "mfrac", sqrt: "msqrt", sup: "msup", sub: "msub", both: "msubsup", i: "mi", n: "mn", o: "mo", t: "mi" };

function part([kind, ...rest]) {
  if (kind === "s") {
    const room = document.createElementNS(MATH, "mspace");
    room.setAttribute("width", `${rest[0]}em`);
    return room;
  }
  const made = document.createElementNS(MATH, TAGS[kind]);
  if (typeof rest[0] === "string") made.textContent = rest[0];
  else made.append(...rest.map(part));
  return made;
}

export function formula(tree, block = false) {
  const made = document.createElementNS(MATH, "math");
  if (block) made.setAttribute("display", "block");
  made.append(part(tree));
  return made;
}

export const isFormula = (tree) => tree.length > 1;
