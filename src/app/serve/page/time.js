/* The scene's time, the picture's size and tone. */
import {send, send_last, send_smoothly} from "./connection.js";
import {find, options} from "./make.js";
import {on, world} from "./world.js";

let duration = 0, is_playing = false;

function show_time(at) {
  if (document.activeElement !== find("time") || is_playing) find("time").value = at;
  find("time-told").textContent = at.toFixed(1) + " s";
}

function play(is_on) {
  is_playing = is_on;
  find("play").setAttribute("aria-pressed", String(is_on));
  find("play").setAttribute("aria-label", is_on ? "Pause" : "Play");
}

function take_scene(scene) {
  duration = scene.duration || 0;
  find("time-group").hidden = duration <= 0;
  find("time").max = duration;
  show_time(scene.time || 0);
}

const sizes = [128, 192, 256, 384, 512, 768, 1024];

function show_size([width, height]) {
  const choices = sizes.map(w => [w, w + " × " + Math.round(w * height / width)]);
  if (!sizes.includes(width)) choices.unshift([width, width + " × " + height]);
  options(find("size"), choices, width);
}

function give_tone(more) {
  const tone = {
    do: "tone",
    exposure: Number(find("exposure").value),
    curve: find("curve").value,
    auto: find("auto").checked
  };
  if (more)
    send_smoothly("tone", tone);
  else
    send_last("tone", tone);
}

function show_tone(tone) {
  if (!tone) return;
  find("exposure").value = tone.exposure || 0;
  find("curve").value = tone.curve || "reinhard";
  find("auto").checked = tone.auto !== false;
}

on("hello", h => {
  take_scene(h.scene);
  show_tone(h.tone);
});
on("scene", take_scene);
on("camera", c => {
  if (typeof c.time === "number") show_time(c.time);
});
on("resized", show_size);
on("connection", () => play(false));

export function begin_time() {
  find("time").addEventListener(
      "input", event => send_smoothly("time", {do: "time", at: Number(event.target.value)}, event.timeStamp));
  find("play").addEventListener("click", () => {
    play(!is_playing);
    send({do: "play", on: is_playing});
  });
  find("size").addEventListener("change", event => {
    const width = Number(event.target.value), [w, h] = world.size;
    send({do: "size", width, height: Math.round(width * h / w)});
  });
  find("exposure").addEventListener("input", () => give_tone(true));
  for (const id of ["exposure", "curve", "auto"]) find(id).addEventListener("change", () => give_tone(false));
}
