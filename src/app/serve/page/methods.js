/* Which method draws, what stands right of the line, and the methods' options. */
import {is_unanswered, send} from "./connection.js";
import {field, slider} from "./controls.js";
import {find, make, number, options} from "./make.js";
import {forget} from "./picture.js";
import {on, tell, world} from "./world.js";

const titles = {
  splatting: "Radiance cache splatting",
  "direct-radiance": "Direct radiance mapping",
  "light-octree": "Light octree",
  "multi-mesh": "Multi-mesh caching",
  "shading-cache": "Shading cache",
  path: "Path tracing",
  bidirectional: "Bidirectional paths"
};
/* A setting's name without its method's. */
const short = name => name.slice(name.indexOf(".") + 1).replaceAll("-", " ");

export const title_of = method => titles[method] || method;

const measures = [
  ["reference", "The reference, path traced"], ["difference", "Difference to the reference"],
  ["error", "The map of the error"], ["exact", "The exact picture"]
];

const changed = {
  a: {},
  b: {}
}; /* settings that a hand has turned, by side */

/* ---- which method ---- */

function use_method(side, name) {
  changed[side] = {};
  ask_method(side, name);
}

function ask_method(side, name) {
  const quality = {quality: find("quality-" + side).value};
  world.methods[side] = name;
  send({do: "method", side, name, ...(name && {settings: {...quality, ...changed[side]}})});
  show_settings();
}

/* ---- right of the line ---- */

const needs = {
  reference: ["reference"],
  difference: ["reference", "difference"],
  error: ["reference", "error"]
};

function switch_measures(before, now) {
  const had = needs[before] || [], has = needs[now] || [];
  for (const what of had.filter(w => !has.includes(w)).reverse()) send({do: what, on: false});
  for (const what of has.filter(w => !had.includes(w))) send({do: what, on: true});
}

export function show_right(name) {
  const before = world.right, is_measure = measures.some(m => m[0] === name);
  const now = is_measure || name === "" ? name : "b";
  switch_measures(before, now);
  if (now === "b" && world.methods.b !== name) {
    forget("b");
    if (!world.methods.b) find("quality-b").value = find("quality-a").value;
    use_method("b", name);
  } else if (now !== "b" && world.methods.b)
    use_method("b", "");
  if (now === "exact" && before !== "exact") send({do: "exact", side: "a"});
  find("method-b").value = name;
  set_right(now);
  show_settings();
}

function set_right(now) {
  world.right = now;
  find("side-b").classList.toggle("measures", now !== "b");
  tell("right", now);
}

/* ---- options ---- */

const heeds = (s, method) => !s.methods || s.methods.split(", ").includes(method);
const elsewhere = new Set(["method", "size", "quality", "threads", "memory", "transport"]);

function turn_setting(side, name, value) {
  changed[side][name] = value;
  ask_method(side, world.methods[side]);
}

const own_value = (side, s) => changed[side][s.name] ?? world.settings?.[side]?.[s.name];

function default_of(s, side) {
  const at = ["draft", "normal", "high"].indexOf(find("quality-" + side).value);
  return Array.isArray(s.default) ? s.default[Math.max(at, 0)] : s.default;
}

function choice_control(side, s) {
  const select = make("select", {change: () => turn_setting(side, s.name, select.value)});
  options(select, s.unit.split("|").map(c => [c, c]), own_value(side, s) ?? s.unit.split("|")[0]);
  return field(short(s.name), select, s.help);
}

function flag_control(side, s) {
  const box =
      make("input", {type: "checkbox", change: () => turn_setting(side, s.name, box.checked ? "1" : "0")});
  box.checked = String(own_value(side, s) ?? "0") === "1";
  return field(short(s.name), box, s.help);
}

const told_range = s => s.maximum > s.minimum ? number(s.minimum) + " to " + number(s.maximum) : "";

function number_control(side, s) {
  const standard = default_of(s, side), value = own_value(side, s) ?? standard;
  const help = [
    s.help, s.symbol && "the paper's " + s.symbol, told_range(s),
    standard ? "default " + (Number.isFinite(Number(standard)) ? number(Number(standard)) : standard) : ""
  ].filter(Boolean).join(" · ");
  const change = v => turn_setting(side, s.name, String(v));
  const is_bounded = s.maximum > s.minimum && s.maximum <= 1e5 && Number(value) > 0;
  if (!is_bounded) {
    const input = make("input", {type: "text", inputmode: "decimal", change: () => change(input.value)});
    input.value = own_value(side, s) ?? "";
    input.placeholder = standard || "auto";
    return field(short(s.name), input, help);
  }
  const whole = s.unit === "N" || s.unit === "M" || s.unit === "TEXELS" || s.unit === "PIXELS";
  const control =
      slider(short(s.name), {minimum: s.minimum, maximum: s.maximum, whole}, (v, more) => more || change(v));
  control.show(Number(value));
  control.append(make("p", {class: "help"}, help));
  return control;
}

function control(side, s) {
  return s.unit === ""     ? flag_control(side, s) :
      s.unit.includes("|") ? choice_control(side, s) :
                             number_control(side, s);
}

function settings_of(side) {
  const method = world.methods[side];
  if (!method || !world.hello) return null;
  const all = world.hello.settings.filter(s => heeds(s, method) && !elsewhere.has(s.name));
  const own = all.filter(s => s.everyday && s.methods), rest = all.filter(s => !own.includes(s));
  return make("section", {class: "side-" + side, "data-side": side},
              make("h3", {}, make("span", {class: "dot " + side}), title_of(method)),
              ...own.map(s => control(side, s)),
              make("details", {"data-open": side}, make("summary", {}, "More options, for experiments"),
                   ...rest.map(s => control(side, s))));
}

export function show_settings() {
  const box = find("settings");
  if (box.contains(document.activeElement) && document.activeElement.matches("input, select")) return;
  const open = new Set([...box.querySelectorAll("details[open]")].map(d => d.dataset.open));
  box.replaceChildren(...["a", "b"].map(settings_of).filter(Boolean));
  for (const d of box.querySelectorAll("details")) d.open = open.has(d.dataset.open);
}

/* ---- news ---- */

function take_sides(h) {
  world.methods = {a: h.sides.a || "", b: h.sides.b || ""};
  options(find("method-a"), h.methods.map(m => [m, title_of(m)]), world.methods.a);
  const right = find("method-b"), before = right.value;
  right.replaceChildren(make("option", {value: ""}, "Compare with …"),
                        make("optgroup", {label: "Another method"},
                             ...h.methods.map(m => make("option", {value: m}, title_of(m)))),
                        make("optgroup", {label: "The truth"},
                             ...measures.map(([value, text]) => make("option", {value}, text))));
  const is_measure = measures.some(m => m[0] === before);
  const name = world.methods.b || (is_measure ? before : "");
  world.right = world.methods.b ? "b" : "";
  show_right(name);
}

on("hello", take_sides);

function take_settings(side, settings) {
  world.settings = {...world.settings, [side]: settings};
  find("quality-" + side).value = settings?.quality || "normal";
}

on("state", s => {
  if (!world.hello || world.settings?.[s.side] || is_unanswered("method")) return;
  take_settings(s.side, s.settings);
  show_settings();
});

/* Whoever switched it: all viewers see the same. */
on("method", ({side, name, settings}) => {
  if (!world.hello || is_unanswered("method")) return;
  take_settings(side, settings);
  world.methods[side] = name;
  if (side === "a")
    find("method-a").value = name;
  else if (name || world.right === "b") {
    find("method-b").value = name;
    set_right(name && "b");
  }
  show_settings();
});

export function begin_methods() {
  find("method-a").addEventListener("change", event => use_method("a", event.target.value));
  find("method-b").addEventListener("change", event => show_right(event.target.value));
  for (const side of ["a", "b"])
    find("quality-" + side).addEventListener("change", () => ask_method(side, world.methods[side]));
}
