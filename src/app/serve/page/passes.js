/* The passes of a frame as a strip of pictures with their cost, and what one leaves drawn over it. */
import {send} from "./connection.js";
import {fill, find, make} from "./make.js";
import {draw_bitmap, mark} from "./picture.js";
import {explanation} from "./story.js";
import {on, tell, world} from "./world.js";

const strip = find("strip"), passes = new Map(); /* by index: {news, card, canvas, past, at} */
const most_past = 48; /* files that are kept of a pass */
let side = "a", chosen = null, shown = null, overlay = "", batches = 0;

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
  const entry = {canvas, card, title, price, news: null, past: [], at: null};
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

/* Keeps what came, of too many every second one; entry.at is the one that is looked at, null: the newest. */
function remember(entry, file) {
  entry.past.push({file, batches});
  if (entry.past.length <= most_past) return;
  entry.past = entry.past.filter((_, i) => i % 2 === 0);
  if (entry.at !== null) entry.at >>= 1;
}

function take_picture(f) {
  const entry = card_of(f.index), {canvas} = entry;
  remember(entry, f.file);
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

async function show_past(entry, canvas, told) {
  const {file, batches} = entry.past[entry.at ?? entry.past.length - 1], at = entry.at;
  told.textContent = "after batch " + batches;
  const bitmap = await createImageBitmap(file);
  if (entry.at === at) draw_bitmap(canvas, bitmap);
  bitmap.close();
}

/* Steps back through the pictures of a pass that came so far. */
function past_slider(entry, canvas) {
  if (entry.past.length < 2) return null;
  const range = make("input", {type: "range", id: "past", min: 0, step: 1}), told = make("output");
  range.max = entry.past.length - 1;
  range.value = entry.at ?? range.max;
  range.addEventListener("input", () => {
    range.max = entry.past.length - 1;
    entry.at = range.value === range.max ? null : Number(range.value);
    show_past(entry, canvas, told);
  });
  show_past(entry, canvas, told);
  return make("div", {class: "field"}, make("label", {for: "past"}, "Batches so far"), told, range);
}

function show_pass() {
  const box = find("pass"), entry = passes.get(chosen);
  if (entry && shown === chosen && document.activeElement === find("past")) return; /* a hand holds it */
  shown = chosen;
  if (!entry?.news) {
    box.replaceChildren();
    return;
  }
  const {news, canvas} = entry, label = news.title || news.name;
  const big = make("canvas", {class: "big-pass", id: "big-pass", role: "img", "aria-label": label});
  if (canvas.classList.contains("has-picture")) draw_bitmap(big, canvas);
  box.replaceChildren(...[canvas.classList.contains("has-picture") && big, past_slider(entry, big),
                          explanation(news),
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

on("state", s => {
  if (s.side === side) batches = s.batches;
});
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
