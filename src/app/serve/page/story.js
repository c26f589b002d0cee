/* The story of a pixel, beside the picture: the terms that add up to it, the equation, the lines that compute
 * it, and a lens on its neighbours. */
import {send} from "./connection.js";
import {fill, find, make, number, to_hex} from "./make.js";
import {bitmap_of, mark, side_at} from "./picture.js";
import {tool_now, use_tool} from "./view.js";
import {on, world} from "./world.js";

/* global mathml */
const hues = 8;
let place = null, asked = null, wanted = false, told = null;

/* ---- asking: one story at a time is on its way ---- */

function ask() {
  if (asked) {
    wanted = true;
    return;
  }
  asked = {...place, side: side_at(place.x)};
  wanted = false;
  if (!send({do: "story", ...asked})) asked = null;
}

function answered() {
  asked = null;
  if (wanted) ask();
}

export function choose_pixel(x, y) {
  place = {x: Math.min(Math.max(x, 0), world.size[0] - 1), y: Math.min(Math.max(y, 0), world.size[1] - 1)};
  mark_pixel([]);
  draw_lens();
  ask();
}

/* ---- telling ---- */

const size = t => t.contribution.reduce((sum, c) => sum + Math.abs(c), 0);

/* Adds in the order of the terms, the rounding last: what the server has as the pixel. */
export function add_up(story) {
  const sum = [0, 0, 0];
  for (const t of story.terms)
    for (let c = 0; c < 3; c++) sum[c] += t.contribution[c];
  return sum.map((v, c) => v + story.rounding[c]);
}

const named = t => t.index === null || t.index === undefined || t.kind.startsWith("smaller") ?
    t.kind :
    t.kind + " " + t.index;

function swatch(rgb, label) {
  const e = make("span", {class: "swatch", role: "img", "aria-label": label});
  e.style.background = to_hex(rgb.map(v => v / (1 + v)));
  return e;
}

function layers_of(story) {
  const layers = [...new Set(story.terms.map(t => t.layer))];
  return new Map(layers.map((name, i) => [name, i % hues]));
}

/* One bar for all terms, each as wide as what it adds; a layer has one hue. */
function bar(story, layers) {
  const all = story.terms.reduce((sum, t) => sum + size(t), 0) || 1;
  const box = make("div", {class: "stack", role: "img", "aria-label": "What each term adds to the pixel"});
  for (const t of story.terms) {
    const part = make("span", {
      class: "hue" + layers.get(t.layer),
      title: named(t) + ": " + (100 * size(t) / all).toFixed(1) + " %"
    });
    part.style.flexGrow = size(t) / all;
    box.append(part);
  }
  return box;
}

function legend(story, layers) {
  const all = story.terms.reduce((sum, t) => sum + size(t), 0) || 1;
  return make("ul", {class: "legend"}, ...[...layers].map(([name, hue]) => {
    const part = story.terms.filter(t => t.layer === name).reduce((sum, t) => sum + size(t), 0);
    return make("li", {}, make("span", {class: "dot hue" + hue}), name + " ",
                make("b", {}, (100 * part / all).toFixed(0) + " %"));
  }));
}

const short = x => number(x, 3);

function row(kind, name, weight, rgb) {
  return make("tr", {class: kind}, make("th", {scope: "row"}, ...[name].flat()), make("td", {}, weight),
              ...rgb.map(v => make("td", {title: String(v)}, short(v))));
}

function term_row(t, layers) {
  const holds = make("span", {class: "holds"}, "holds " + t.value.map(short).join("  "));
  return row("", [make("span", {class: "dot hue" + layers.get(t.layer)}), named(t), holds], short(t.weight),
             t.contribution);
}

function terms_table(story, layers) {
  const head = ["term", "weight", "adds R", "G", "B"].map(h => make("th", {scope: "col"}, h));
  return make("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "Terms of the pixel"},
              make("table", {class: "terms"}, make("thead", {}, make("tr", {}, ...head)),
                   make("tbody", {}, ...story.terms.map(t => term_row(t, layers)),
                        row("", "rounding", "", story.rounding), row("sum", "the pixel", "", add_up(story)))));
}

const prose = lines => Array.isArray(lines) ? lines.join("") : lines || "";

function source_lines({file, first, text}) {
  const lines = text.replace(/\n$/, "").split("\n");
  return make(
      "details", {class: "source"}, make("summary", {}, file + ", line " + first),
      make("pre", {class: "code", tabindex: 0, "aria-label": "Source of " + file},
           ...lines.flatMap((line, i) => [make("span", {class: "line"}, String(first + i)), line + "\n"])));
}

/* What a pass does, its equation, the function that computes it and that one's lines. */
export function explanation(p) {
  return make(
      "section", {class: "pass-told"}, make("h3", {}, p.title || p.pass || p.name),
      p.text && fill(make("p"), prose(p.text)),
      p.equation && fill(make("div", {class: "equation"}), mathml(prose(p.equation)), "math"),
      p.source?.text ? source_lines(p.source) : p.function && make("pre", {class: "code"}, p.function));
}

function show_story(story) {
  answered();
  if (!place || story.x !== place.x || story.y !== place.y) return;
  told = story;
  const layers = layers_of(story), sum = add_up(story);
  find("story").replaceChildren(
      make("h3", {}, `Pixel ${story.x}, ${story.y} `, swatch(sum, "its colour"),
           make("span", {class: "quiet"}, sum.map(v => number(v)).join("  "))),
      ...(story.terms.length ?
              [bar(story, layers), legend(story, layers), terms_table(story, layers)] :
              [make("p", {class: "help"}, "This method tells no terms; the pixel is a mean of samples.")]),
      story.paper && fill(make("p", {class: "help"}), prose(story.paper)),
      ...(story.passes || []).map(explanation));
  find("story").dataset.place = story.x + "," + story.y;
  find("story").dataset.sum = JSON.stringify(sum);
  find("story").dataset.pixel = JSON.stringify(story.pixel);
  mark_pixel(story.terms.filter(t => t.at));
}

/* Path tracers tell no terms. */
function show_refusal(reason) {
  told = null;
  find("story").replaceChildren(make("h3", {}, `Pixel ${place.x}, ${place.y}`),
                                make("p", {class: "help"}, reason));
  find("story").dataset.place = place.x + "," + place.y;
  delete find("story").dataset.sum;
}

function mark_pixel(terms) {
  if (!place) return;
  const unit = Math.max(world.size[0] / 128, .8);
  mark("pixel",
       ...terms.slice(0, 200).map(
           t => make("circle", {class: "maker", cx: t.at[0], cy: t.at[1], r: 1.6 * unit})),
       make("rect", {class: "pixel", x: place.x, y: place.y, width: 1, height: 1}));
}

/* ---- the lens ---- */

const across = 11;

function draw_lens() {
  const lens = find("lens"), bitmap = bitmap_of(side_at(place.x));
  lens.hidden = !bitmap;
  if (!bitmap) return;
  const pen = lens.getContext("2d"), cell = lens.width / across, from = (across - 1) / 2;
  pen.imageSmoothingEnabled = false;
  pen.clearRect(0, 0, lens.width, lens.height);
  pen.drawImage(bitmap, place.x - from, place.y - from, across, across, 0, 0, lens.width, lens.height);
  pen.lineWidth = 3;
  pen.strokeStyle = "#000";
  pen.strokeRect(from * cell, from * cell, cell, cell);
  pen.lineWidth = 1.5;
  pen.strokeStyle = "#fff";
  pen.strokeRect(from * cell, from * cell, cell, cell);
}

/* ---- what people do ---- */

let pinned = false;

function leave() {
  if (tool_now() !== "pixel") mark("pixel");
}

on("story", show_story);
on("refused", r => {
  if (r.do !== "story") return;
  const at = asked;
  answered();
  if (at && place && at.x === place.x && at.y === place.y) show_refusal(r.reason);
});
on("connection", () => {
  asked = null;
});
on("hovered", p => {
  if (!pinned) choose_pixel(p.x, p.y);
});
on("clicked", p => {
  if (tool_now() !== "pixel") return;
  pinned = !pinned || p.x !== place?.x || p.y !== place?.y;
  choose_pixel(p.x, p.y);
});
on("pixel-key", ({by, far}) => {
  const from = place || {x: world.size[0] >> 1, y: world.size[1] >> 1}, step = far ? 10 : 1;
  pinned = true;
  choose_pixel(from.x + step * by[0], from.y - step * by[1]);
});
on("tool", leave);
on("drawn", f => {
  if (tool_now() !== "pixel" || !place || f.kind > 1) return;
  draw_lens();
  if (f.still && told) ask();
});

export function begin_story() {
  find("ask-pixel").addEventListener("click", () => {
    use_tool("pixel");
    if (!place) choose_pixel(world.size[0] >> 1, world.size[1] >> 1);
    find("frame").focus();
  });
}
