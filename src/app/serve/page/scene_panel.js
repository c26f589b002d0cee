/* The scene: what is in it, and numbers and colours of what is selected. */
import {send} from "./connection.js";
import {button, colour, field, number_input, slider, strong_colour, triple} from "./controls.js";
import {find, make} from "./make.js";
import {edit, is_dark, is_dragging, place_edit, select, selection, turn_edit} from "./touch.js";
import {add, scale, unit} from "./vector.js";
import {on, world} from "./world.js";

const editor = find("editor"), list = find("things");
const xyz = ["x", "y", "z"];
let lamps = -1, shown = null, parts = []; /* functions that show the scene as it now is */

/* ---- the list ---- */

const named = (thing, kind, number) => thing.name || kind + " " + number;

function choice(what, number, text, dim) {
  const s = world.selected, chosen = s?.what === what && s.number === number;
  return make("li", {
    role: "option",
    "aria-selected": chosen,
    tabindex: chosen ? 0 : -1,
    class: dim ? "dim" : null,
    "data-what": what,
    "data-number": number,
    click: () => select(what, number)
  },
              make("span", {class: "dot " + what}), text);
}

function show_list() {
  const focused = list.contains(document.activeElement);
  const items = [
    ...world.scene.lights.map(l => choice("light", l.light, "Lamp " + l.light + " · " + l.type, is_dark(l))),
    ...world.scene.objects.map(o => choice("object", o.object, named(o, "Object", o.object), false))
  ];
  list.replaceChildren(...items);
  const current = list.querySelector("[aria-selected=true]") || list.firstElementChild;
  if (!current) return;
  current.tabIndex = 0;
  if (focused) current.focus();
}

function key_list(event) {
  const by = {ArrowDown: 1, ArrowUp: -1}[event.key], items = [...list.children];
  if (!by || !items.length) return;
  event.preventDefault();
  const at = items.indexOf(document.activeElement);
  const {what, number} = items[(at + by + items.length) % items.length].dataset;
  select(what, Number(number));
}

/* ---- editors ---- */

function show_with(control, value) {
  parts.push(() => {
    const v = value();
    if (v !== undefined && v !== null) control.show(v);
  });
  return control;
}

const material_of = number => world.scene.materials.find(m => m.material === number);

function object_editor(s) {
  const own = selection;
  return [
    show_with(triple("Place", xyz, {}, place => edit(place_edit(s, own(), place))), () => own()?.centre),
    make(
        "div", {class: "row"}, field("Turn by (degrees)", number_input({value: 15, id: "turn-by"}, () => {})),
        button("Turn", () => edit(turn_edit(s, own(), Number(find("turn-by").value) || 0))),
        button("Back to the file's place", () => edit({kind: "object", object: s.number, matrix: null}))),
    ...material_editor(own()?.material)
  ];
}

function material_editor(number) {
  const m = () => material_of(number), first = m();
  if (!first) return [];
  const change = part => (value, more, since) =>
      edit({kind: "material", material: number, [part]: value}, more, since);
  const glow = Math.max(...first.emission || [0]);
  return [
    make("h3", {}, "Material ", make("span", {class: "quiet"}, named(first, "", number))),
    first.textured && make("p", {class: "help"}, "Its texture multiplies the colour."),
    show_with(colour("Colour", change("diffuse")), () => m().diffuse),
    show_with(colour("Gloss", change("specular")), () => m().specular),
    show_with(slider("Sharpness of the gloss", {minimum: 1, maximum: 10000}, change("exponent")),
              () => Math.max(m().exponent || 1, 1)),
    show_with(colour("Mirror", change("mirror")), () => m().mirror || [0, 0, 0]),
    show_with(strong_colour("Glow", Math.max(4 * glow, 20), change("emission")), () => m().emission)
  ];
}

function light_editor(s) {
  const own = selection, first = own();
  const change = part => (value, more) => edit({kind: "light", light: s.number, [part]: value}, more);
  return [
    first.position && show_with(triple("Place", xyz, {}, change("position")), () => own()?.position),
    first.direction && show_with(triple("Direction", xyz, {}, change("direction")), () => own()?.direction),
    show_with(strong_colour("Power", Math.max(4 * Math.max(...first.power), 1), change("power")),
              () => own()?.power),
    button("Take this lamp away", () => edit({kind: "remove-light", light: s.number}), {id: "remove-lamp"})
  ];
}

function show_editor() {
  const s = world.selected, own = selection();
  shown = s && own ? s.what + s.number : null;
  parts = [];
  if (!shown) {
    editor.replaceChildren(
        make("p", {class: "help"},
             "Click on something in the picture, or choose it above. Drag a lamp along the " +
                 "floor; with Shift, in the plane of the view."));
    return;
  }
  editor.replaceChildren(
      make("h3", {},
           s.what === "light" ? "Lamp " + s.number + " · " + own.type : named(own, "Object", s.number)),
      ...(s.what === "light" ? light_editor(s) : object_editor(s)).filter(Boolean));
  for (const part of parts) part();
}

/* ---- sky and sun ---- */

let sky = null, sun = null;

const brightest_sun = () => world.scene.lights.filter(l => l.type === "directional" && !is_dark(l))
                                .sort((a, b) => Math.max(...b.power) - Math.max(...a.power))[0];

/* The way its light goes, for a height and a compass's direction from which it comes. */
function sun_direction(height, around) {
  const h = height * Math.PI / 180, a = around * Math.PI / 180;
  return [-Math.cos(h) * Math.sin(a), -Math.sin(h), -Math.cos(h) * Math.cos(a)];
}

function sun_angles(direction) {
  const d = unit(direction), turn = Math.atan2(-d[0], -d[2]) * 180 / Math.PI;
  return [Math.asin(-d[1]) * 180 / Math.PI, (turn + 360) % 360];
}

function make_sky() {
  const box = find("sky");
  sky = slider("Sky, stops", {minimum: -6, maximum: 6}, (stops, more) => edit({kind: "sky", stops}, more));
  let angles = [45, 0];
  const give = more => edit({kind: "sun", direction: sun_direction(...angles)}, more);
  const one = (label, i, minimum, maximum) => slider(label, {minimum, maximum}, (v, more) => {
    angles[i] = v;
    give(more);
  });
  const height = one("Sun's height", 0, 1, 89), around = one("Sun's direction", 1, 0, 360);
  sun = make("div", {}, height, around);
  sun.show = direction => {
    angles = sun_angles(direction);
    height.show(angles[0]);
    around.show(angles[1]);
  };
  box.replaceChildren(sky, sun);
}

function show_sky() {
  const light = brightest_sun();
  sky.hidden = !world.scene.sky?.present;
  sun.hidden = !light;
  find("sky-group").hidden = sky.hidden && sun.hidden;
  if (!sky.hidden) sky.show(world.scene.sky.stops || 0);
  if (light?.direction) sun.show(light.direction);
}

/* ---- lamps ---- */

/* A new lamp hangs before what was clicked last, or half way to what one looks at. */
function add_lamp() {
  const c = world.camera, p = world.picked;
  const position =
      p?.at && p.normal ? add(p.at, scale(p.normal, .12 * world.extent)) : scale(add(c.eye, c.target), .5);
  const lit = world.scene.lights.filter(l => l.type === "point" && !is_dark(l));
  const power = lit.length ? lit[0].power : new Array(3).fill(.02 * world.extent * world.extent);
  edit({kind: "add-light", position, power});
}

/* ---- news ---- */

on("hello", h => take_scene(h.scene));
on("scene", take_scene);
on("selected", () => {
  show_list();
  show_editor();
});

function take_scene(scene) {
  const more = lamps >= 0 && scene.lights.length > lamps;
  lamps = scene.lights.length;
  if (is_dragging()) return;
  find("undo").disabled = !scene.undo;
  find("redo").disabled = !scene.redo;
  find("scene-name").textContent = scene.name || "scene";
  document.title = (scene.name || "scene") + " · softlux";
  if (more) select("light", scene.lights[lamps - 1].light);
  show_list();
  show_sky();
  const s = world.selected;
  if (s && shown === s.what + s.number && selection())
    for (const part of parts) part();
  else
    show_editor();
}

export function begin_scene_panel() {
  make_sky();
  list.addEventListener("keydown", key_list);
  find("add-lamp").addEventListener("click", add_lamp);
  find("undo").addEventListener("click", () => send({do: "undo"}));
  find("redo").addEventListener("click", () => send({do: "redo"}));
  document.addEventListener("keydown", event => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    if (event.target.matches?.("input[type=number]")) return;
    event.preventDefault();
    send({do: event.shiftKey ? "redo" : "undo"});
  });
}
