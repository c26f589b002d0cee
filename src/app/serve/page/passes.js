/* The passes of a frame as a strip of pictures with their cost, and what a pass leaves drawn over the picture. */
import {send} from "./connection.js";
import {fill, find, make} from "./make.js";
import {draw_bitmap, mark} from "./picture.js";
import {explanation} from "./story.js";
import {on, tell, world} from "./world.js";

const strip = find("strip"), passes = new Map(); /* by index: {news, card, canvas} */
let side = "a", chosen = null, overlay = "";

const work =
    ["rays", "shadow_rays", "fragments_shaded", "fragments_blended", "photons_gathered", "records", "splats"];

/* The counter that says most of what the pass cost. */
function cost(counters) {
  const entries = Object.entries(counters || {}).filter(([, n]) => n > 0);
  const [name, n] =
      entries.filter(([name]) => work.includes(name)).sort((a, b) => b[1] - a[1])[0] || entries[0] || [];
  return name ? n.toLocaleString("en") + " " + name.replaceAll("_", " ") : "";
}

function card_of(index) {
  if (passes.has(index)) return passes.get(index);
  const canvas = make("canvas", {width: 96, height: 96}), title = make("b"),
        price = make("span", {class: "quiet"});
  const card =
      make("button", {type: "button", class: "card", "aria-pressed": "false", click: () => choose(index)},
           canvas, title, price);
  const entry = {canvas, card, title, price, news: null};
  passes.set(index, entry);
  const after = [...passes.keys()].filter(i => i > index).sort((a, b) => a - b)[0];
  strip.insertBefore(card, after === undefined ? null : passes.get(after).card);
  return entry;
}

function take_pass(news) {
  const entry = card_of(news.index);
  entry.news = {...news, paper_place: news.source, source: null};
  entry.card.title = news.title || news.name;
  entry.title.textContent = news.index + 1 + ". " + (news.title || news.name);
  entry.price.textContent = cost(news.counters);
  if (chosen === news.index) show_pass();
}

function take_picture(f) {
  const {canvas} = card_of(f.index);
  draw_bitmap(canvas, f.bitmap);
  canvas.classList.add("has-picture");
  f.bitmap.close();
  if (chosen === f.index) show_pass();
}

function choose(index) {
  chosen = chosen === index ? null : index;
  if (chosen !== null) tell("pass-chosen", chosen);
  for (const [i, entry] of passes) entry.card.setAttribute("aria-pressed", String(i === chosen));
  show_pass();
}

function counters_table(counters) {
  const rows = Object.entries(counters || {}).filter(([, n]) => n);
  return rows.length ?
      make("table", {}, make("caption", {}, "What it cost"),
           ...rows.map(([name, n]) => make("tr", {}, make("th", {scope: "row"}, name.replaceAll("_", " ")),
                                           make("td", {}, n.toLocaleString("en"))))) :
      null;
}

function overlay_button(name) {
  const is_on = overlay === name;
  return make("button", {
    type: "button",
    class: "chip",
    "aria-pressed": String(is_on),
    click: () => use_overlay(is_on ? "" : name)
  },
              "Draw its marks over the picture");
}

function show_pass() {
  const box = find("pass"), entry = passes.get(chosen);
  if (!entry?.news) {
    box.replaceChildren();
    return;
  }
  const {news, canvas} = entry,
               big = make("canvas", {class: "big-pass", role: "img", "aria-label": news.title || news.name});
  if (canvas.classList.contains("has-picture")) draw_bitmap(big, canvas);
  box.replaceChildren(...[canvas.classList.contains("has-picture") && big, explanation(news),
                          make("p", {class: "help"},
                               news.paper_place + " · pass “" + news.name + "”" +
                                   (news.times > 1 ? ", " + news.times + " times" : "")),
                          news.marks > 0 && overlay_button(news.name), counters_table(news.counters)]
                          .filter(Boolean));
}

/* ---- marks over the picture ---- */

function use_overlay(kind) {
  overlay = kind;
  mark("overlay");
  send({do: "overlay", side, kind});
  show_pass();
}

function take_overlay(o) {
  if (o.kind !== overlay) return;
  const svg = fill(mark("overlay"), o.svg || "", "svg"), [width, height] = world.size;
  svg.setAttribute("transform", `scale(${width / o.width} ${height / o.height})`);
}

/* ---- on and off ---- */

function clear() {
  passes.clear();
  strip.replaceChildren();
  chosen = null;
  show_pass();
}

function ask_passes(is_on) {
  clear();
  if (overlay) use_overlay("");
  side = "a";
  send({do: "passes", side, on: is_on});
  document.body.classList.toggle("with-strip", is_on);
}

on("pass", take_pass);
on("pass-picture", take_picture);
on("overlay", take_overlay);
on("method", m => {
  if (m.side !== "a") return;
  clear();
  if (overlay) use_overlay("");
});
on("connection", c => {
  if (c.state === "open" && find("passes").checked) ask_passes(true);
});
on("moved", () => overlay && mark("overlay"));

export function begin_passes() {
  find("passes").addEventListener("change", event => ask_passes(event.target.checked));
}
