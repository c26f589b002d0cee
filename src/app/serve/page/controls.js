/* Controls of the panels. Each is an element with `show(value)`, which leaves alone what one is typing in, and
 * calls `changed(value, more)` where a hand changed it; more: it is still moving. */
import {from_hex, make, number, to_hex} from "./make.js";

let count = 0;

export function field(label, control, help = "") {
  const id = control.id || (control.id = "control-" + ++count);
  return make("div", {class: "field"}, make("label", {for: id
              }, label), control, help && make("p", {class: "help"}, help));
}

const is_busy = e => e === document.activeElement && e.type !== "range" && e.type !== "color";

/* Takes a number from what was typed; null: none. */
const typed = input =>
    input.value.trim() === "" || !Number.isFinite(Number(input.value)) ? null : Number(input.value);

export function number_input(given, changed) {
  const input = make("input", {type: "number", step: "any", ...given});
  input.addEventListener("change", () => {
    if (typed(input) !== null && input.checkValidity()) changed(typed(input), false);
  });
  input.show = value => {
    if (!is_busy(input)) input.value = value === null ? "" : number(value);
  };
  return input;
}

/* Three numbers under one label. */
export function triple(label, names, given, changed) {
  const inputs =
      names.map(name => number_input({"aria-label": label + " " + name, title: name, ...given}, () => {
                  const values = inputs.map(typed);
                  if (values.every(v => v !== null)) changed(values, false);
                }));
  const group = make("fieldset", {class: "triple"}, make("legend", {}, label), ...inputs);
  group.show = values => inputs.forEach((input, i) => input.show(values[i]));
  return group;
}

/* A slider with its number; logarithmic where its range spans more than two decades. */
export function slider(label, {minimum, maximum, whole = false, linear = false, unit = ""}, changed) {
  const log = !linear && minimum > 0 && maximum / minimum > 100;
  const to = log ? v => Math.log(v / minimum) / Math.log(maximum / minimum) :
                   v => (v - minimum) / (maximum - minimum);
  const from = t => {
    const v = log ? minimum * (maximum / minimum) ** t : minimum + t * (maximum - minimum);
    return whole ? Math.round(v) : Number(v.toPrecision(3));
  };
  const range = make("input", {type: "range", min: 0, max: 1, step: .002, "aria-label": label});
  const exact = number_input({min: minimum, max: maximum, "aria-label": label + ", number"}, (v, more) => {
    range.value = to(v);
    changed(v, more);
  });
  const told = more => {
    exact.value = number(from(Number(range.value)));
    range.setAttribute("aria-valuetext", exact.value + unit);
    changed(from(Number(range.value)), more);
  };
  range.addEventListener("input", () => told(true));
  range.addEventListener("change", () => told(false));
  const group = make("div", {class: "slider", role: "group", "aria-label": label},
                     make("span", {class: "name"}, label), exact, range);
  group.show = value => {
    if (document.activeElement !== range) range.value = to(value);
    range.setAttribute("aria-valuetext", number(value) + unit);
    exact.show(value);
  };
  return group;
}

/* A colour, of which each channel is at most 1. */
export function colour(label, changed) {
  const input = make("input", {type: "color", "aria-label": label});
  input.addEventListener("input", () => changed(from_hex(input.value), true));
  input.addEventListener("change", () => changed(from_hex(input.value), false));
  const group = make("label", {class: "colour"}, make("span", {class: "name"}, label), input);
  group.show = rgb => {
    input.value = to_hex(rgb);
  };
  return group;
}

/* A colour times a strength that may be any: of lamps and of what glows. */
export function strong_colour(label, maximum, changed) {
  let tint = [1, 1, 1], strength = 0;
  const give = more => changed(tint.map(t => t * strength), more);
  const swatch = colour(label + " colour", (rgb, more) => {
    const most = Math.max(...rgb, 1e-6);
    tint = rgb.map(c => c / most);
    give(more);
  });
  const power = slider(label, {minimum: 0, maximum, linear: true}, (v, more) => {
    strength = v;
    give(more);
  });
  const group = make("div", {class: "strong"}, power, swatch);
  group.show = rgb => {
    strength = Math.max(...rgb);
    if (strength > 0) tint = rgb.map(c => c / strength);
    swatch.show(tint);
    power.show(strength);
  };
  return group;
}

export function button(label, pressed, given = {}) {
  return make("button", {type: "button", ...given, click: pressed}, label);
}
