/* Picks objects and lamps in the picture, and drags them by handles: along the floor, in the plane of the
 * view, and about the vertical. Handles are buttons: arrow keys move by steps. */
import {send, send_last, send_smoothly} from "./connection.js";
import {find, icon, make} from "./make.js";
import {add, axes, meet, project, ray, scale, shift, subtract, turn_matrix} from "./vector.js";
import {tool_now} from "./view.js";
import {on, tell, world} from "./world.js";

const frame = find("frame"), layer = find("handles");

export const object_of = number => world.scene?.objects.find(o => o.object === number);
export const light_of = number => world.scene?.lights.find(l => l.light === number);
export const is_dark = light => light.power.every(p => p === 0);

export function selection() {
  const s = world.selected;
  return !s ? null : s.what === "light" ? light_of(s.number) : object_of(s.number);
}

export function select(what, number) {
  world.selected = what ? {what, number} : null;
  tell("selected", world.selected);
}

/* ---- edits ---- */

/* Sends an edit; more of the same follow where it is a drag. */
export function edit(edits, drag = false, since = undefined) {
  const message = {do: "edit", edits: [edits].flat(), ...(drag ? {drag} : {})};
  if (drag)
    send_smoothly("edit", message, since);
  else
    send_last("edit", message, since);
}

const place_of = thing => thing.position || thing.centre;
const begun = thing => ({matrix: thing.matrix, place: place_of(thing)});

/* What moves the thing from where it was when that began. */
function move_edit(selected, from, by) {
  return selected.what === "light" ?
      {kind: "light", light: selected.number, position: add(from.place, by)} :
      {kind: "object", object: selected.number, matrix: shift(from.matrix, by)};
}

export const place_edit = (selected, thing, place) =>
    move_edit(selected, begun(thing), subtract(place, place_of(thing)));

export const turn_edit = (selected, thing, degrees) => ({
  kind: "object",
  object: selected.number,
  matrix: turn_matrix(thing.matrix, thing.centre, degrees * Math.PI / 180)
});

/* ---- drags ---- */

let dragged = null; /* {selected, from, normal, grip: where the hand took it, how, place: now} */

/* Returns the plane to drag in; the floor's seen from its edge is no use. */
function plane(how, camera) {
  const {ahead} = axes(camera);
  return how === "floor" && Math.abs(ahead[1]) > .12 ? [0, 1, 0] : ahead;
}

function exact_pixel(event) {
  const box = frame.getBoundingClientRect();
  return {
    x: (event.clientX - box.left) / box.width * world.size[0],
    y: (event.clientY - box.top) / box.height * world.size[1]
  };
}

function begin_drag(event, how, selected) {
  const thing = selected.what === "light" ? light_of(selected.number) : object_of(selected.number);
  if (!thing || !world.camera) return;
  event.preventDefault();
  event.currentTarget.setPointerCapture(event.pointerId);
  const from = begun(thing), normal = plane(how, world.camera), camera = world.camera;
  const grip =
      meet(camera.eye, ray(camera, world.size, exact_pixel(event)), from.place, normal) || from.place;
  dragged = {selected, thing, from, normal, grip, how, camera, start: event.clientX, edit: null};
}

function drag_edit(d, event) {
  if (d.how === "turn") return turn_edit(d.selected, d.thing, (event.clientX - d.start) * .8);
  const at = meet(d.camera.eye, ray(d.camera, world.size, exact_pixel(event)), d.from.place, d.normal);
  if (!at) return null;
  const by = subtract(at, d.grip), reach = 2 * world.extent;
  if (Math.hypot(...by) > reach) return null;
  d.place = add(d.from.place, by);
  return move_edit(d.selected, d.from, by);
}

function continue_drag(event) {
  const made = dragged && drag_edit(dragged, event);
  if (!made) return;
  dragged.edit = made;
  edit(made, true, event.timeStamp);
  place_handles();
}

function end_drag(event) {
  if (!dragged) return;
  const d = dragged;
  if (d.edit) edit(d.edit, false, event.timeStamp);
  dragged = null;
  if (d.place && world.selected) {
    const thing = selection();
    if (thing) thing[thing.position ? "position" : "centre"] = d.place;
  }
  make_handles();
}

/* The scene's own news are late while one drags. */
export const is_dragging = () => dragged !== null;

/* ---- steps by keys ---- */

function step_by_key(event, how, selected) {
  const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
  if (!way) return;
  event.preventDefault();
  event.stopPropagation();
  const thing = selection(), step = world.extent * (event.shiftKey ? .05 : .01);
  if (how === "turn") {
    edit(turn_edit(selected, thing, (way[0] + way[1]) * (event.shiftKey ? 30 : 5)), false, event.timeStamp);
    return;
  }
  const {right, up, ahead} = axes(world.camera);
  const second = how === "floor" ? Math.hypot(ahead[0], ahead[2]) > .01 ? [ahead[0], 0, ahead[2]] : up : up;
  const by = add(scale(right, way[0] * step), scale(second, way[1] * step));
  edit(move_edit(selected, begun(thing), by), false, event.timeStamp);
}

/* ---- the handles ---- */

const ways = [
  ["view", "Move in the plane of the view", 0, 0], ["floor", "Move along the floor", 0, 46],
  ["turn", "Turn about the vertical", 46, 0]
];

function handle(name, label, given) {
  const button =
      make("button", {type: "button", class: "handle " + name, "aria-label": label, title: label, ...given},
           icon(name));
  button.addEventListener("pointermove", continue_drag);
  button.addEventListener("pointerup", end_drag);
  button.addEventListener("pointercancel", end_drag);
  return button;
}

function lamp_button(light) {
  const selected = {what: "light", number: light.light};
  const choose = () => select("light", light.light);
  const button = handle("lamp", "Lamp " + light.light + ", " + light.type, {
    "data-light": light.light,
    pointerdown: event => {
      begin_drag(event, event.shiftKey ? "view" : "floor", selected);
      choose();
    },
    click: choose,
    keydown: event => {
      if (event.key.startsWith("Arrow")) choose();
      step_by_key(event, event.altKey ? "view" : "floor", selected);
    }
  });
  return button;
}

const has_place = light => Array.isArray(light.position);

function make_handles() {
  if (dragged) return;
  const focus = document.activeElement?.closest?.("#handles") ? document.activeElement.dataset : null;
  const lamps = (world.scene?.lights || []).filter(l => has_place(l) && !is_dark(l)).map(lamp_button);
  const s = world.selected, own = selection();
  const moved = own && (s.what === "object" || has_place(own)) ? ways : [];
  const made = moved.filter(([how]) => how !== "turn" || s.what === "object")
                   .map(([how, label]) => handle(how, label, {
                          "data-way": how,
                          pointerdown: event => begin_drag(event, how, s),
                          keydown: event => step_by_key(event, how, s)
                        }));
  layer.replaceChildren(...lamps, ...made);
  if (focus)
    layer.querySelector(focus.way ? `[data-way="${focus.way}"]` : `[data-light="${focus.light}"]`)?.focus();
  place_handles();
}

function put(button, point, dx = 0, dy = 0) {
  const at = project(world.shown, world.size, point), [width, height] = world.size;
  const inside = at && at.x >= 0 && at.x <= width && at.y >= 0 && at.y <= height;
  button.hidden = !inside || tool_now() === "pixel";
  if (!inside) return;
  button.style.left = `calc(${100 * at.x / width}% + ${dx}px)`;
  button.style.top = `calc(${100 * at.y / height}% + ${dy}px)`;
}

function place_handles() {
  if (!world.shown || !world.scene) return;
  const s = world.selected;
  for (const button of layer.children) {
    const way = ways.find(w => w[0] === button.dataset.way), number = Number(button.dataset.light);
    const is_own = way || s?.what === "light" && s.number === number;
    const thing = way ? selection() : light_of(number);
    if (!thing) continue;
    if (!way) button.classList.toggle("selected", is_own);
    put(button, is_own && dragged?.place || place_of(thing), way?.[2], way?.[3]);
  }
}

on("hello", make_handles);
on("scene", make_handles);
on("selected", make_handles);
on("shown", place_handles);
on("moved", place_handles);
on("resized", place_handles);
on("tool", place_handles);
on("connection", () => {
  dragged = null;
});
on("clicked", pixel => {
  if (tool_now() !== "pixel") send({do: "pick", ...pixel});
});
on("picked", p => {
  world.picked = p;
  if (p.what === "object" || p.what === "light")
    select(p.what, p.what === "light" ? p.light : p.object);
  else
    select(null);
});
