/* The picture: its newest frames of every kind, two of them under one line that one drags. */
import {send} from "./connection.js";
import {find, make} from "./make.js";
import {on, tell, world} from "./world.js";

export const kinds = {
  a: 0,
  b: 1,
  reference: 2,
  pass: 3,
  difference: 4,
  error: 5,
  exact: 6
};
const frame = find("frame"), line = find("line");
const canvases = {
  left: find("left"),
  right: find("right")
};
const newest = new Map(); /* of each kind: the bitmap */
let share = .5, greatest = 0;

/* ---- frames ---- */

export function draw_bitmap(canvas, bitmap) {
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
  }
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
}

const is_right = kind => world.right !== "" && kinds[world.right] === kind;

function fit(width, height) {
  if (world.size[0] === width && world.size[1] === height) return;
  world.size = [width, height];
  frame.style.setProperty("--wide", width);
  frame.style.setProperty("--high", height);
  find("marks").setAttribute("viewBox", `0 0 ${width} ${height}`);
  tell("resized", world.size);
}

function acknowledge(number) {
  greatest = Math.max(greatest, number);
  send({do: "got", frame: greatest});
}

/* Frames of a kind are decoded one after the other, and none is drawn over a newer one. */
const drawn = new Map();

async function show_frame(f) {
  let bitmap;
  try {
    bitmap = await createImageBitmap(f.file);
  } catch {
    acknowledge(f.number);
    return;
  }
  acknowledge(f.number);
  if (f.kind === kinds.pass) {
    tell("pass-picture", {...f, bitmap});
    return;
  }
  if ((drawn.get(f.kind) || 0) > f.number) return;
  drawn.set(f.kind, f.number);
  newest.get(f.kind)?.close();
  newest.set(f.kind, bitmap);
  if (f.kind === kinds.a) {
    fit(f.width, f.height);
    draw_bitmap(canvases.left, bitmap);
    frame.classList.add("ready");
  }
  if (is_right(f.kind)) draw_right();
  tell("drawn", f);
}

function draw_right() {
  const bitmap = newest.get(kinds[world.right]);
  frame.classList.toggle("split", world.right !== "");
  canvases.right.classList.toggle("empty", !bitmap);
  if (bitmap) draw_bitmap(canvases.right, bitmap);
}

on("frame", show_frame);
on("right", draw_right);
on("hello", h => {
  greatest = 0;
  drawn.clear();
  fit(...h.size);
});

/* Forgets what was shown of a kind: what comes is of another method. */
export function forget(name) {
  newest.get(kinds[name])?.close();
  newest.delete(kinds[name]);
  draw_right();
}

export const bitmap_of = name => newest.get(kinds[name]);

/* ---- the line ---- */

function split_at(at) {
  share = Math.min(Math.max(at, 0), 1);
  frame.style.setProperty("--split", 100 * share + "%");
  line.setAttribute("aria-valuenow", Math.round(100 * share));
}

export const side_at = x => world.right && x >= share * world.size[0] && world.right === "b" ? "b" : "a";

function drag_line(event) {
  if (!line.hasPointerCapture(event.pointerId)) return;
  const box = frame.getBoundingClientRect();
  split_at((event.clientX - box.left) / box.width);
}

function key_line(event) {
  const by = {ArrowLeft: -.02, ArrowRight: .02, PageDown: -.1, PageUp: .1, Home: -1, End: 1}[event.key];
  if (by === undefined) return;
  event.preventDefault();
  split_at(share + by);
}

/* ---- places in it ---- */

export function to_pixel(event) {
  const box = frame.getBoundingClientRect(), [width, height] = world.size;
  const within = (x, end) => Math.min(Math.max(Math.floor(x), 0), end - 1);
  return {
    x: within((event.clientX - box.left) / box.width * width, width),
    y: within((event.clientY - box.top) / box.height * height, height)
  };
}

export const click_picture = pixel => tell("clicked", pixel);
export const hover_picture = event => tell("hovered", to_pixel(event));

/* Marks over the picture, in layers by name: SVG elements. */
export function mark(layer, ...elements) {
  const marks = find("marks");
  let group = marks.querySelector(`[data-layer="${layer}"]`);
  if (!group) marks.append(group = make("g", {"data-layer": layer}));
  group.replaceChildren(...elements);
  return group;
}

export function begin_picture() {
  split_at(.5);
  line.addEventListener("pointerdown", event => line.setPointerCapture(event.pointerId));
  line.addEventListener("pointermove", drag_line);
  line.addEventListener("keydown", key_line);
}
