/* What happened, newest first: numbered events, refusals, the connection. */
import {find, make} from "./make.js";
import {on} from "./world.js";

const most = 200;
let last = "";

function note(text, kind = "") {
  const list = find("log");
  if (text === last && list.firstElementChild) {
    const times = list.firstElementChild.querySelector(".times");
    times.textContent = Number(times.textContent || 1) + 1;
    return;
  }
  last = text;
  list.prepend(make("li", {class: kind}, text + " ", make("span", {class: "times quiet"})));
  while (list.children.length > most) list.lastElementChild.remove();
}

const details = {
  edit: m => m.edits.map(e => e.kind + " " + (e.object ?? e.material ?? e.light ?? "")).join(", "),
  method: m => m.side + " " + (m.name || "none"),
  story: m => m.x + ", " + m.y,
  keep: m => m.what
};

let fading = 0;

export function say(text) {
  const toast = find("toast");
  toast.textContent = text;
  toast.classList.add("visible");
  clearTimeout(fading);
  fading = setTimeout(() => toast.classList.remove("visible"), 5000);
}

on("numbered",
   ({message}) => note(message.do + (details[message.do] ? ": " + details[message.do](message) : "")));
on("refused", r => {
  note("refused " + r.do + ": " + r.reason, "refused");
  say(r.reason);
});
on("kept", k => k.href && say("Kept: " + k.what + ", below Keep"));
on("viewers", v => {
  find("viewers").textContent = v.count > 1 ? v.count + " viewers" : "";
});
on("connection", c => {
  const is_open = c.state === "open", text = find("connection");
  document.body.classList.toggle("lost", !is_open);
  text.textContent = is_open ? "connected" :
      c.times > 3            ? "No answer. Is softlux serve still running? Open the address that it prints." :
                               "Connection lost, trying again …";
  if (!is_open && c.reason) note("connection ended: " + c.reason, "refused");
});
