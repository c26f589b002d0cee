/* The exact picture and what is kept: files, the command line that makes this very picture, a film. */
import {send} from "./connection.js";
import {bytes, find, make} from "./make.js";
import {show_right} from "./methods.js";
import {on, world} from "./world.js";

const titles = {
  png: "Picture, PNG",
  exr: "Picture, EXR",
  scene: "Scene, JSON",
  log: "Log of events",
  page: "Frozen page",
  film: "Film"
};
let is_filming = false;

function add_link(what, href, size) {
  const url = new URL(href, location.href);
  if (url.origin !== location.origin) return;
  find("kept").prepend(make("li", {"data-what": what},
                            make("a", {href: url.pathname + url.search, download: ""}, titles[what] || what),
                            make("span", {class: "quiet"}, size ? bytes(size) : "")));
}

function show_command(command) {
  const box = find("command"), copy = make("button", {type: "button", class: "chip"}, "Copy");
  copy.addEventListener("click", async () => {
    await navigator.clipboard?.writeText(command);
    copy.textContent = "Copied";
  });
  box.replaceChildren(make("p", {class: "help"}, "This command makes this very picture:"),
                      make("pre", {class: "code", tabindex: 0}, command), navigator.clipboard ? copy : "");
}

function show_exact(e) {
  const told = find("exact-told"), bar = find("exact-bar");
  bar.hidden = e.done;
  bar.value = e.fraction || 0;
  told.textContent = !e.done ? "Rendering afresh beside the live picture …" :
      e.exr                  ? "Exact: these are the bits of render." :
                               "";
  find("exact").dataset.done = String(Boolean(e.done));
  if (e.command) show_command(e.command);
  if (!e.done) return;
  if (e.png) add_link("png", e.png);
  if (e.exr) add_link("exr", e.exr);
}

function show_film() {
  find("film").setAttribute("aria-pressed", String(is_filming));
  find("film").textContent = is_filming ? "Stop the film" : "Begin a film";
}

on("exact", show_exact);
on("kept", k => {
  if (k.what === "film" && !k.href) return;
  if (k.what === "film") is_filming = false;
  show_film();
  add_link(k.what, k.href, k.bytes);
});

export function begin_keep() {
  find("exact").addEventListener("click", () => {
    show_exact({done: false}); /* what is told so far is of another one */
    if (world.right === "exact") send({do: "exact", side: "a"});
    show_right("exact");
  });
  for (const what of ["png", "exr", "scene", "log", "page"])
    find("keep-" + what).addEventListener("click", () => send({do: "keep", what}));
  find("film").addEventListener("click", () => {
    is_filming = !is_filming;
    show_film();
    send({do: "keep", what: "film"});
  });
}
