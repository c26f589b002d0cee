/* Speed and error, beside each other: numbers, a plot over seconds, what an edit kept, pictures a second. */
import {send} from "./connection.js";
import {bytes, find, make, number, percent} from "./make.js";
import {kinds} from "./picture.js";
import {on, world} from "./world.js";

/* ---- the error over seconds ---- */

const runs = {
  a: [[]],
  b: [[]]
}; /* the newest run last, the one before it for comparison */

function note_error(side, seconds, error) {
  if (!(error > 0) || !(seconds > 0)) return;
  let run = runs[side][runs[side].length - 1];
  if (run.length && seconds < run[run.length - 1][0]) {
    runs[side] = [run, run = []];
  }
  run.push([seconds, error]);
  if (run.length > 400) runs[side][runs[side].length - 1] = run.filter((_, i) => i % 2 === 0 || i > 300);
}

const width = 300, height = 132, left = 38, bottom = 16;

function ticks(low, high) {
  const out = [];
  for (let decade = Math.floor(Math.log10(low)); decade <= Math.ceil(Math.log10(high)); decade++)
    for (const digit of high / low > 30 ? [1] : [1, 2, 5]) {
      const value = digit * 10 ** decade;
      if (value >= low && value <= high) out.push(value);
    }
  return out;
}

function plot() {
  const all = [...runs.a, ...runs.b].flat();
  const svg = find("plot");
  find("plot-group").hidden = all.length < 2;
  if (all.length < 2) return;
  const wide = (values, least) => {
    const low = Math.min(...values), high = Math.max(...values),
          more = Math.max(1.1, Math.sqrt(least * low / high));
    return [low / more, high * more];
  };
  const [s0, s1] = wide(all.map(p => p[0]), 4), [e0, e1] = wide(all.map(p => p[1]), 4);
  const x = s => left + (width - left - 6) * Math.log(s / s0) / Math.log(s1 / s0);
  const y = e => 4 + (height - bottom - 8) * Math.log(e1 / e) / Math.log(e1 / e0);
  const line = (run, side, old) => make("polyline", {
    class: "run " + side + (old ? " old" : ""),
    points: run.map(([s, e]) => x(s).toFixed(1) + "," + y(e).toFixed(1)).join(" ")
  });
  svg.replaceChildren(
      ...ticks(e0, e1).flatMap(
          e => [make("line", {class: "grid", x1: left, x2: width, y1: y(e), y2: y(e)}),
                make("text", {x: left - 4, y: y(e) + 3, "text-anchor": "end"}, percent(e))]),
      ...ticks(s0, s1).map(
          s => make("text", {x: x(s), y: height - 3, "text-anchor": "middle"}, number(s) + " s")),
      ...["a", "b"].flatMap(side => runs[side].map((run, i) => line(run, side, i < runs[side].length - 1))));
}

/* ---- the numbers of a side ---- */

const states = {}, errors = {}; /* of each side; errors of the picture that stands there */

const seconds = s => s === undefined || s === null ? "–" : s < 10 ? s.toFixed(1) + " s" : s.toFixed(0) + " s";

function show_side(side) {
  const s = states[side], error = errors[side], box = find("told-" + side);
  if (!s) {
    box.replaceChildren();
    return;
  }
  const parts = [make("span", {class: "big"}, error == null ? seconds(s.seconds) : "±" + percent(error))];
  if (error != null) parts.push(make("span", {}, seconds(s.seconds)));
  parts.push(make("span", {}, (s.batches || 0) + (s.batches === 1 ? " batch" : " batches")));
  if (s.done) parts.push(make("span", {class: "done"}, "done"));
  box.replaceChildren(...parts);
}

const spaced = name => name.replaceAll("_", " ");

function table(caption, head, rows) {
  return make("table", {}, make("caption", {}, caption),
              head && make("tr", {}, ...head.map(h => make("th", {scope: "col"}, h))),
              ...rows.map(([name, ...cells]) => make("tr", {}, make("th", {scope: "row"}, name),
                                                     ...cells.map(c => make("td", {}, c)))));
}

function kept_table(kept) {
  const {before = {}, since = {}} = kept.counters || {};
  const rows = Object.keys({...before, ...since})
                   .map(name => [spaced(name), (before[name] ?? 0).toLocaleString("en"),
                                 (since[name] ?? 0).toLocaleString("en")]);
  return rows.length ? table("Work before the last edit and since", ["", "before", "since"], rows) : null;
}

function show_work() {
  const made = ["a", "b"].filter(side => states[side]).flatMap(side => {
    const s = states[side], counters = Object.entries(s.counters || {}).filter(([, n]) => n);
    return [
      s.reduced && make("p", {class: "help"}, s.reduced),
      s.kept?.changes?.length && make("p", {class: "help"}, "Last edit: " + s.kept.changes.join(", ") + "."),
      s.kept && kept_table(s.kept),
      counters.length &&
          table((side === "a" ? "Left" : "Right") + ": what it took", null,
                counters.map(([name, n]) => [spaced(name), n.toLocaleString("en")]))
    ].filter(Boolean);
  });
  if (find("work").parentElement.open) find("work").replaceChildren(...made);
}

on("state", s => {
  if (s.seconds < states[s.side]?.seconds) delete errors[s.side]; /* it began anew */
  states[s.side] = s;
  show_side(s.side);
  show_work();
});
on("error", e => {
  errors[e.side] = e.error;
  note_error(e.side, e.seconds, e.error);
  show_side(e.side);
  plot();
});
on("method", ({side, name}) => {
  runs[side] = [...runs[side].slice(-1), []];
  if (!name) delete states[side];
  delete errors[side];
  show_side(side);
  plot();
});
on("reference", r => {
  if (world.right !== "reference" && world.right !== "difference") return;
  find("told-b").replaceChildren(make("span", {class: "big"}, r.samples + " samples"),
                                 make("span", {class: "done"}, r.done ? "done" : ""));
});

/* ---- pictures a second, and from the hand to the eye ---- */

const second = [], waiting = [], latencies = [], events = {};

const median = sorted => sorted.length ? sorted[Math.floor(sorted.length / 2)] : NaN;

on("numbered", n => {
  if (n.since !== undefined) waiting.push(n);
});
on("drawn", f => {
  const now = performance.now();
  second.push({now, bytes: f.bytes, first: f.kind === kinds.a});
  if (f.kind <= kinds.b && f.event !== events[f.kind]) {
    events[f.kind] = f.event;
    delete errors[f.kind === kinds.a ? "a" : "b"];
  }
  if (f.kind !== kinds.a) return;
  while (waiting.length && waiting[0].event <= f.event) latencies.push(now - waiting.shift().since);
  if (latencies.length > 300) latencies.splice(0, latencies.length - 300);
});
on("connection", () => {
  waiting.length = 0;
});

export function speed() {
  const now = performance.now();
  while (second.length && second[0].now < now - 1000) second.shift();
  const sorted = [...latencies].sort((a, b) => a - b);
  return {
    frames: second.filter(f => f.first).length,
    bytes: second.reduce((sum, f) => sum + f.bytes, 0),
    median: median(sorted),
    late: sorted.length ? sorted[Math.floor(.95 * (sorted.length - 1))] : NaN,
    count: sorted.length
  };
}

function show_speed() {
  const s = speed(), parts = [];
  if (s.frames) parts.push(s.frames + " pictures/s", bytes(s.bytes) + "/s");
  if (Number.isFinite(s.median)) parts.push(s.median.toFixed(0) + " ms from hand to picture");
  find("speed").textContent = parts.join(" · ");
}

export function begin_status() {
  setInterval(show_speed, 500);
  find("estimate").addEventListener("change", event => {
    send({do: "error", on: event.target.checked});
    if (!event.target.checked) delete errors.a, delete errors.b;
  });
  window.softlux = {speed, states, world}; /* for measurements */
}
