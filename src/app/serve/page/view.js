/* The camera in the hand: orbit, pan, walk and zoom by mouse, touch and keys. */
import {is_unanswered, send, send_smoothly} from "./connection.js";
import {find} from "./make.js";
import {click_picture, hover_picture, to_pixel} from "./picture.js";
import {add, axes, length, scale, subtract, turn} from "./vector.js";
import {on, tell, world} from "./world.js";

const degrees = Math.PI / 180, steepest = 88 * degrees;
const frame = find("frame");
let tool = "orbit";

export const tool_now = () => tool;

export function use_tool(name) {
  tool = name;
  frame.dataset.tool = name;
  const button = document.querySelector(`#tools [value="${name}"]`);
  if (button) button.checked = true;
  tell("tool", name);
}

function moved(camera, since) {
  world.camera = camera;
  send_smoothly("camera", {do: "camera", ...camera}, since);
  tell("moved", camera);
}

/* ---- moves ---- */

/* Turns what is seen from the target about the vertical and up and down, not over the poles. */
function swing(offset, up, right, about, over) {
  const level = Math.asin(offset[1] / length(offset));
  const limited = Math.min(Math.max(level + over, -steepest), steepest) - level;
  return turn(turn(offset, right, -limited), up, about);
}

const vertical = [0, 1, 0];

function orbit(about, over, since) {
  const c = world.camera, {right} = axes(c);
  const offset = swing(subtract(c.eye, c.target), vertical, right, about, over);
  moved({...c, eye: add(c.target, offset), up: vertical}, since);
}

function look(about, over, since) {
  const c = world.camera, {right} = axes(c);
  const offset = swing(subtract(c.target, c.eye), vertical, scale(right, -1), about, over);
  moved({...c, target: add(c.eye, offset), up: vertical}, since);
}

function go(by, since) {
  const c = world.camera;
  moved({...c, eye: add(c.eye, by), target: add(c.target, by)}, since);
}

/* By pixels: what is as far as the target stays under the hand. */
function pan(x, y, since) {
  const c = world.camera, {right, up} = axes(c);
  const s = 2 * Math.tan(c.fov * degrees / 2) * length(subtract(c.target, c.eye)) / frame.clientHeight;
  go(add(scale(right, -x * s), scale(up, y * s)), since);
}

function zoom(factor, since) {
  const c = world.camera;
  moved({...c, eye: add(c.target, scale(subtract(c.eye, c.target), factor))}, since);
}

/* By shares of the scene's size: to the right, up, and ahead on the level. */
function walk(right, up, ahead, since) {
  const a = axes(world.camera), level = [a.ahead[0], 0, a.ahead[2]], size = world.extent;
  go(scale(add(add(scale(a.right, right), [0, up, 0]), scale(level, ahead)), size), since);
}

/* ---- pointers ---- */

const pointers = new Map();
let travelled = 0, panning = false;

const across = () => {
  const [p, q] = [...pointers.values()];
  return {x: (p.x + q.x) / 2, y: (p.y + q.y) / 2, apart: Math.hypot(p.x - q.x, p.y - q.y)};
};

function drag_one(dx, dy, since) {
  const full = Math.PI / frame.clientHeight;
  if (panning || tool === "pan")
    pan(dx, dy, since);
  else if (tool === "walk")
    look(dx * full / 2, dy * full / 2, since);
  else if (tool === "pixel")
    return;
  else
    orbit(-dx * full, dy * full, since);
}

function pointer_down(event) {
  if (event.target.closest("button, #line")) return;
  frame.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
  travelled = pointers.size > 1 ? Infinity : 0;
  panning = event.button === 2 || event.button === 1 || event.shiftKey;
}

function pointer_move(event) {
  const p = pointers.get(event.pointerId);
  if (!p) {
    if (tool === "pixel") hover_picture(event);
    return;
  }
  const before = pointers.size === 2 ? across() : null, dx = event.clientX - p.x, dy = event.clientY - p.y;
  p.x = event.clientX;
  p.y = event.clientY;
  travelled += Math.abs(dx) + Math.abs(dy);
  if (!world.camera) return;
  if (before) {
    const now = across();
    pan(now.x - before.x, now.y - before.y, event.timeStamp);
    if (now.apart > 0) zoom(before.apart / now.apart, event.timeStamp);
  } else if (pointers.size === 1 && travelled > 3)
    drag_one(dx, dy, event.timeStamp);
  if (tool === "pixel") hover_picture(event);
}

function pointer_up(event) {
  if (!pointers.delete(event.pointerId) || pointers.size) return;
  if (travelled <= 3 && event.type === "pointerup") click_picture(to_pixel(event));
}

function wheel(event) {
  event.preventDefault();
  if (world.camera) zoom(Math.exp(Math.min(Math.max(event.deltaY, -200), 200) * .0015), event.timeStamp);
}

/* ---- keys ---- */

const arrows = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1]
};
const steps = {
  w: [0, 0, 1],
  s: [0, 0, -1],
  a: [-1, 0, 0],
  d: [1, 0, 0],
  e: [0, 1, 0],
  q: [0, -1, 0]
};
const tools = {
  1: "orbit",
  2: "pan",
  3: "walk",
  4: "pixel"
};

function arrow(x, y, far, since) {
  const reach = far ? 4 : 1;
  if (tool === "walk")
    y ? walk(0, 0, .01 * reach * y, since) : look(-3 * degrees * reach * x, 0, since);
  else if (tool === "pan")
    pan(-12 * reach * x, 12 * reach * y, since);
  else
    orbit(3 * degrees * reach * x, 3 * degrees * reach * y, since);
}

function key(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target !== frame || !world.camera) return;
  const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (tools[name])
    use_tool(tools[name]);
  else if (name === "+" || name === "-")
    zoom(name === "+" ? .9 : 1 / .9, event.timeStamp);
  else if (steps[name])
    walk(...steps[name].map(s => s * (event.shiftKey ? .04 : .01)), event.timeStamp);
  else if (tool === "pixel" && (arrows[name] || name === "Enter"))
    tell("pixel-key", {by: arrows[name] || [0, 0], far: event.shiftKey});
  else if (arrows[name])
    arrow(...arrows[name], event.shiftKey, event.timeStamp);
  else if (name === "Enter")
    click_picture({x: Math.floor(world.size[0] / 2), y: Math.floor(world.size[1] / 2)});
  else if (name === "Home")
    send({do: "reset"});
  else
    return;
  event.preventDefault();
}

/* ---- the camera of the picture that one sees ---- */

let numbered = [], newest_of_ours = 0;

function take_camera(camera) {
  const {eye, target, up, fov} = camera;
  world.camera = world.shown = {eye, target, up, fov};
  numbered = [];
  tell("moved", world.camera);
}

on("numbered", n => {
  if (n.message.do !== "camera") return;
  const {eye, target, up, fov} = n.message;
  newest_of_ours = n.event;
  numbered.push({event: n.event, camera: {eye, target, up, fov}});
});

on("drawn", f => {
  if (f.kind !== 0) return;
  let at = -1;
  while (at + 1 < numbered.length && numbered[at + 1].event <= f.event) at++;
  if (at < 0) return;
  world.shown = numbered[at].camera;
  numbered.splice(0, at + 1);
  tell("shown", world.shown);
});

/* Answers to moves of one's own come late: until the newest of them has come the hand knows better. */
on("camera", c => {
  if (!is_unanswered("camera") && (c.event ?? Infinity) > newest_of_ours) take_camera(c);
});

function measure_extent(scene) {
  let low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const o of scene.objects || [])
    for (let c = 0; c < 3; c++) {
      low[c] = Math.min(low[c], o.bounds[c]);
      high[c] = Math.max(high[c], o.bounds[3 + c]);
    }
  const diagonal = length(subtract(high, low));
  world.extent = Number.isFinite(diagonal) && diagonal > 0 ? diagonal : 10;
}

on("hello", h => {
  measure_extent(h.scene);
  newest_of_ours = 0;
  take_camera(h.scene.camera);
});
on("connection", () => pointers.clear());

export function begin_view() {
  frame.addEventListener("pointerdown", pointer_down);
  frame.addEventListener("pointermove", pointer_move);
  frame.addEventListener("pointerup", pointer_up);
  frame.addEventListener("pointercancel", pointer_up);
  frame.addEventListener("wheel", wheel, {passive: false});
  frame.addEventListener("keydown", key);
  frame.addEventListener("contextmenu", event => event.preventDefault());
  for (const button of document.querySelectorAll("#tools input"))
    button.addEventListener("change", () => use_tool(button.value));
  find("reset").addEventListener("click", () => send({do: "reset"}));
  use_tool("orbit");
}
