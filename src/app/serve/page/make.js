/* Makes elements. Names that come from a scene are only ever text. */

const svg_names = new Set(["svg", "use", "path", "line", "polyline", "rect", "circle", "text", "g", "title"]);

/* An element with attributes and children; functions among the attributes listen to the event of that name. */
export function make(name, given = {}, ...children) {
  const e = svg_names.has(name) ? document.createElementNS("http://www.w3.org/2000/svg", name) :
                                  document.createElement(name);
  for (const [key, value] of Object.entries(given)) {
    if (typeof value === "function")
      e.addEventListener(key, value);
    else if (value === true)
      e.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined)
      e.setAttribute(key, value);
  }
  e.append(...children.filter(c => c !== null && c !== undefined && c !== false));
  return e;
}

export const find = id => document.getElementById(id);

export const icon = name => make("svg", {class: "icon", "aria-hidden": "true", viewBox: "0 0 20 20"},
                                 make("use", {href: "#icon-" + name}));

export function options(select, choices, chosen) {
  select.replaceChildren(...choices.map(([value, text]) => make("option", {value}, text)));
  select.value = chosen;
}

const harmless = new Set(
    ("p em cite code b i sub sup q br math mrow mi mo mn mtext mfrac msqrt msub msup msubsup munder " +
     "path line polyline rect circle ellipse polygon g")
        .split(" "));
const harmless_attributes = new Set(
    "d x y x1 y1 x2 y2 cx cy r rx ry width height points class fill stroke stroke-width opacity".split(" "));

function copy(from, to) {
  for (const node of from.childNodes) {
    if (node.nodeType === Node.TEXT_NODE) to.append(node.data);
    if (node.nodeType !== Node.ELEMENT_NODE || !harmless.has(node.localName)) continue;
    const e = document.createElementNS(node.namespaceURI, node.localName);
    for (const a of node.attributes)
      if (harmless_attributes.has(a.name)) e.setAttribute(a.name, a.value);
    copy(node, e);
    to.append(e);
  }
}

/* Fills an element with markup of which only elements that show something stay; wrapped in svg or math. */
export function fill(e, markup, wrapped = "") {
  const text = wrapped ? `<${wrapped}>${markup}</${wrapped}>` : markup;
  const body = new DOMParser().parseFromString(text, "text/html").body;
  e.replaceChildren();
  copy(wrapped ? body.firstElementChild || body : body, e);
  return e;
}

/* ---- numbers ---- */

export function number(x, digits = 4) {
  if (x === 0 || !Number.isFinite(x)) return String(x);
  const size = Math.abs(x);
  return size >= 1e5 || size < 1e-4 ? x.toExponential(1) : String(Number(x.toPrecision(digits)));
}

export const percent = share => share === null || share === undefined || !Number.isFinite(share) ?
    "–" :
    Number((100 * share).toPrecision(2)) + " %";

export const bytes = n => n < 1e6 ? (n / 1e3).toFixed(0) + " kB" : (n / 1e6).toFixed(1) + " MB";

/* ---- colours: what a file calls 0.5 looks brighter than half ---- */

const to_byte = x => Math.round(255 * (x <= .0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - .055));
const from_byte = b => b / 255 <= .04045 ? b / 255 / 12.92 : ((b / 255 + .055) / 1.055) ** 2.4;

export const to_hex = linear =>
    "#" + linear.map(x => to_byte(Math.min(Math.max(x, 0), 1)).toString(16).padStart(2, "0")).join("");
export const from_hex = hex => [1, 3, 5].map(i => from_byte(parseInt(hex.slice(i, i + 2), 16)));
