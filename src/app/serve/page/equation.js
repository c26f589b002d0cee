"use strict";
/* Makes MathML of an equation as the narratives have it: L_d = frac{ρ}{π} ∑_'lamps' E_l. */
function mathml(text) {
  const tokens = text.match(/'[^']*'|frac|sqrt|[A-Za-zΑ-ω]+|[0-9]+|[^\s]/g);
  let at = 0;
  const row = inner => "<mrow>" + inner + "</mrow>";
  function until(end) {
    let out = "";
    while (at < tokens.length && tokens[at] !== end) out += atom();
    at++;
    return row(out);
  }
  function simple() {
    const t = tokens[at++];
    if (t === "{") return until("}");
    if (t === "(") return row("<mo>(</mo>" + until(")") + "<mo>)</mo>");
    if (t === "|") return row("<mo>|</mo>" + until("|") + "<mo>|</mo>");
    if (t === "frac") return "<mfrac>" + simple() + simple() + "</mfrac>";
    if (t === "sqrt") return "<msqrt>" + simple() + "</msqrt>";
    if (t[0] === "'") return "<mtext>" + t.slice(1, -1) + "</mtext>";
    const tag = /[0-9]/.test(t) ? "mn" : /[A-Za-zΑ-ω]/.test(t) ? "mi" : "mo";
    return `<${tag}>${t === "<" ? "&lt;" : t}</${tag}>`;
  }
  function atom() {
    const base = simple(), below = tokens[at] === "_" && ++at ? simple() : null;
    const above = tokens[at] === "^" && ++at ? simple() : null;
    if (base === "<mo>∑</mo>" && below) return "<munder>" + base + below + "</munder>";
    if (below && above) return "<msubsup>" + base + below + above + "</msubsup>";
    return below ? "<msub>" + base + below + "</msub>" : above ? "<msup>" + base + above + "</msup>" : base;
  }
  return until(null);
}
