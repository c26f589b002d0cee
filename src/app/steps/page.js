"use strict";
/* Makes the page of the runs in it; the slider plays the refinement; a pixel, by mouse or keys, tells what
 * made it. */
/* global mathml */
(function() {
const runs = JSON.parse(document.getElementById("data").textContent);
const png = data => "data:image/png;base64," + data;
const percent = error =>
    error === null || error === undefined ? "-" : Number((100 * error).toPrecision(3)) + " %";
const prose = lines => Array.isArray(lines) ? lines.join("") : lines;

/* An element with attributes: text and html are what it holds. */
function make(name, parent, given = {}) {
  const e = document.createElement(name);
  for (const [key, value] of Object.entries(given)) {
    if (key === "text")
      e.textContent = value;
    else if (key === "html")
      e.innerHTML = value;
    else
      e.setAttribute(key, value);
  }
  parent.append(e);
  return e;
}

function frame(parent, alt, data, width, height) {
  const box = make("div", parent, {class: "frame"});
  make("img", box, {alt, width, height, src: png(data)});
  return box;
}

const svg = (parent, kind, width, height, html) => parent.insertAdjacentHTML(
    "beforeend", `<svg class="${kind}" viewBox="0 0 ${width} ${height}">${html}</svg>`);

/* ---- the passes ---- */

function addFigure(section, run, step, number, title) {
  const known = step.frames.map(f => f[0]).filter(p => p !== null),
        marks = step.frames.some(f => f[1] !== null);
  if (!known.length && !marks) return;
  const last = run.snapshots[run.snapshots.length - 1].picture, own = known.length > 0;
  const figure = make(
      "figure", section,
      {class: "pass" + (step.height > 2 * step.width ? " tall" : ""), "data-step": number});
  const box = frame(
      figure, title + (own ? "" : ", drawn over the picture"), own ? known[known.length - 1] : last,
      own ? step.width : run.width, own ? step.height : run.height);
  if (marks) svg(box, "marks", run.width, run.height, "");
  make("figcaption", figure, {text: step.width ? step.width + " × " + step.height : ""});
}

function addCost(section, cost) {
  if (!Object.keys(cost).length) return;
  const table = make("table", section, {class: "cost"});
  make("caption", table, {text: "what it cost"});
  for (const [name, count] of Object.entries(cost)) {
    const tr = make("tr", table);
    make("th", tr, {scope: "row", text: name.replaceAll("_", " ")});
    make("td", tr, {text: count});
  }
}

function addStep(article, run, step, number) {
  const section = make("section", article, {class: "step"}), told = step.told,
        title = told ? told.title : step.name;
  make("h3", section, {text: number + 1 + ". " + title});
  const source = make("p", section, {class: "source", text: step.source + " · pass "});
  make("q", source, {text: step.name});
  source.append(", " + step.times + (step.times === 1 ? " time" : " times"));
  addFigure(section, run, step, number, title);
  if (told) {
    make("p", section, {html: prose(told.text)});
    if (told.equation)
      section.insertAdjacentHTML(
          "beforeend", '<math display="block">' + mathml(prose(told.equation)) + "</math>");
    make("code", make("p", section, {class: "code"}), {text: told.code});
  }
  const worth = told && told.layer && run.layers ? run.layers[told.layer] : null;
  if (typeof worth === "number")
    make("p", section, {
      class: "worth",
      text: "Without what this pass adds the picture would be off by " + percent(worth) +
          "; with it, it is off by " + percent(run.snapshots[run.snapshots.length - 1].error) + "."
    });
  addCost(section, step.cost);
}

/* ---- the picture, its errors, the reference ---- */

/* Error over batches, both logarithmic. */
function addErrors(article, run) {
  const width = 400, height = 120, left = 46, bottom = 18, errors = run.snapshots.map(s => s.error);
  if (errors.length < 3 || !errors.every(e => e > 0)) return;
  const least = Math.log(Math.min(...errors) / 1.2), greatest = Math.log(Math.max(...errors) * 1.2);
  const last = Math.log(run.snapshots[errors.length - 1].batches + 1);
  const points =
      run.snapshots
          .map(
              s => (left + (width - left) * Math.log(s.batches + 1) / last).toFixed(1) + "," +
                  ((height - bottom) * (greatest - Math.log(s.error)) / (greatest - least)).toFixed(1))
          .join(" ");
  svg(article, "errors", width, height,
      '<g font-size="10" fill="currentColor">' +
          `<text x="0" y="10">${percent(Math.exp(greatest))}</text><text x="0" y="${height - bottom}">${
              percent(Math.exp(least))}</text>` +
          `<text x="${width}" y="${height - 4}" text-anchor="end">batches</text></g>` +
          `<polyline fill="none" stroke="var(--accent)" stroke-width="1.5" points="${points}"/>`);
}

function addPlayer(article, run, number) {
  const last = run.snapshots.length - 1, stage = make("div", article, {class: "stage"});
  const box = frame(stage, "the picture", run.snapshots[last].picture, run.width, run.height);
  box.className = "picture frame";
  box.tabIndex = 0;
  box.setAttribute("role", "application");
  box.setAttribute("aria-label", "The picture: arrow keys move to a pixel, whose explanation stands below");
  svg(box, "marks", run.width, run.height, "");
  const line = make("p", stage, {class: "slider"}), id = "slider" + number;
  make("label", line, { for: id, text: "refinement"
  });
  make("input", line, {type: "range", id, min: 0, max: last, value: last});
  make("output", line, { for: id
  });
  addErrors(article, run);
  const box2 = make("div", article, {class: "explanation", "aria-live": "polite"});
  make("h3", box2, {text: "The explanation of a pixel"});
  make("p", box2, {class: "hint", text: "Click on the picture, or move with the arrow keys on it."});
}

function addReference(article, run) {
  const r = run.reference;
  if (!r) return;
  const section = make("section", article, {class: "reference"});
  make("h3", section, {text: "How far it is from the truth"});
  make("p", section, {
    text: "The same light paths, path traced with " + r.samples + " samples a pixel (their own noise: " +
        percent(r.noise) + "). Without that noise the picture is off by " +
        percent(run.snapshots[run.snapshots.length - 1].error) +
        ", relative RMSE. Blue is too dark, red too bright, full colour at 50 %."
  });
  for (const [name, data] of [["the reference", r.picture], ["the difference", r.difference]]) {
    const figure = make("figure", section);
    frame(figure, name, data, run.width, run.height);
    make("figcaption", figure, {text: name});
  }
}

function addFilm(article, run) {
  const section = make("section", article, {class: "reference"});
  make("h3", section, {text: "A pixel as a mean"});
  make("p", section, {
    text: "Above a pixel is what its centre shows. Rendered without --filter centre it is the mean over its square, " +
        "from sub-frames that the hardware draws beside the centres: four of everything, then more where edges " +
        "are or light differs. The brighter a pixel of the map, the more samples it has."
  });
  for (const [name, data] of [["means over pixels", run.film.picture], ["samples", run.film.samples]]) {
    const figure = make("figure", section);
    frame(figure, name, data, run.width, run.height);
    make("figcaption", figure, {text: name});
  }
}

function addArticle(main, run, number) {
  const article = make("article", main, {"data-article": number});
  make("h2", article, {text: run.narrative.method});
  make("p", article, {class: "paper", html: prose(run.narrative.paper)});
  make("p", article, {html: prose(run.narrative.introduction)});
  addPlayer(article, run, number);
  run.steps.forEach((step, i) => addStep(article, run, step, i));
  addFilm(article, run);
  addReference(article, run);
  const details = make("details", article);
  make("summary", details, {text: "The plan: what this scene needs, and what it does not"});
  make("pre", details, {text: run.plan});
  return article;
}

/* ---- the refinement ---- */

function lastUpTo(frames, snapshot, which) {
  for (let i = snapshot; i >= 0; i--)
    if (frames[i] && frames[i][which] !== null) return frames[i][which];
  return null;
}

function showSnapshot(run, article, snapshot) {
  const s = run.snapshots[snapshot];
  article.querySelector(".picture img").src = png(s.picture);
  article.querySelector(".slider output").textContent = "batch " + s.batches + " of " +
      run.snapshots[run.snapshots.length - 1].batches +
      (s.error === null ? "" : ", off by " + percent(s.error));
  for (const figure of article.querySelectorAll("figure.pass")) {
    const frames = run.steps[Number(figure.dataset.step)].frames;
    const picture = lastUpTo(frames, snapshot, 0), marks = lastUpTo(frames, snapshot, 1);
    const image = figure.querySelector("img"), drawn = figure.querySelector("svg.marks");
    const known = frames.some(f => f[0] !== null);
    if (picture !== null)
      image.src = png(picture);
    else if (!known)
      image.src = png(s.picture);
    figure.classList.toggle("not-yet", known ? picture === null : marks === null);
    if (drawn) drawn.innerHTML = marks || "";
  }
}

/* ---- the explanation of a pixel ---- */

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

function unpack(explanations) {
  const terms = bytes(explanations.terms);
  return {
    kinds: explanations.kinds,
    begin: new Uint32Array(bytes(explanations.begin)),
    index: new Float64Array(terms),
    floats: new Float32Array(terms),
    rounding: new Float64Array(bytes(explanations.rounding))
  };
}

/* In the order of the terms, in double precision, the rest last: the picture's exact values. A term is an
   index and ten floats: kind, column, row, weight, contribution, value. */
function tell(run, x, y) {
  const s = run.unpacked, pixel = y * run.width + x, sum = [0, 0, 0], terms = [];
  for (let i = s.begin[pixel]; i < s.begin[pixel + 1]; i++) {
    const f = s.floats.subarray(12 * i + 2, 12 * i + 12), [layer, kind] = s.kinds[f[0]];
    const placed = !Number.isNaN(f[1]), contribution = [...f.subarray(4, 7)];
    terms.push({
      layer,
      kind,
      index: s.index[6 * i],
      column: placed ? f[1] : null,
      row: f[2],
      weight: f[3],
      contribution,
      value: [...f.subarray(7, 10)]
    });
    for (let c = 0; c < 3; c++) sum[c] += contribution[c];
  }
  const rest = [...s.rounding.subarray(3 * pixel, 3 * pixel + 3)];
  return {x, y, terms, rest, pixel: sum.map((v, c) => v + rest[c])};
}

function number(x) {
  return x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-4 ? x.toExponential(3) : x.toPrecision(4);
}

function row(table, cells, kind) {
  const tr = make("tr", table, kind ? {class: kind} : {});
  cells.forEach((text, i) => make("td", tr, i < 2 ? {class: "text", text} : {text}));
  return tr;
}

function showExplanation(run, article, x, y) {
  const explanation = tell(run, x, y), box = article.querySelector(".explanation");
  box.replaceChildren();
  make("h3", box, {text: "The explanation of pixel " + x + ", " + y});
  const table = make("table", box), head = make("tr", table);
  for (const text of ["what", "layer", "weight", "holds (R G B)", "adds R", "G", "B", ""])
    make("th", head, {text, scope: "col"});
  const size = t => t.contribution.reduce((sum, c) => sum + Math.abs(c), 0);
  const most = Math.max(...explanation.terms.map(size), 1e-30);
  for (const t of explanation.terms) {
    const name =
        t.kind + (t.kind.startsWith("smaller") || t.column === null && t.index === 0 ? "" : " " + t.index);
    const tr =
        row(table,
            [name, t.layer, number(t.weight), t.value.map(number).join(" "), ...t.contribution.map(number)]);
    make("span", make("td", tr), {class: "bar"}).style.width = (6 * size(t) / most) + "em";
  }
  row(table, ["rounding", "", "", "", ...explanation.rest.map(number)]);
  row(table, ["the pixel", "", "", "", ...explanation.pixel.map(number)], "sum");
  article.querySelector(".picture svg.marks").innerHTML =
      `<rect class="pixel" x="${x}" y="${y}" width="1" height="1"/>` +
      explanation.terms.filter(t => t.column !== null)
          .map(t => `<circle class="maker" cx="${t.column}" cy="${t.row}" r="1.6"/>`)
          .join("");
  article.dataset.explanation = JSON.stringify(explanation.pixel);
}

/* ---- what people do ---- */

const main = document.querySelector("main");
main.className = runs.length > 1 ? "beside" : "";
const articles = runs.map((run, i) => addArticle(main, run, i));
const place = {
  x: Math.floor(runs[0].width / 2),
  y: Math.floor(runs[0].height / 2)
};

function choose(x, y) {
  place.x = Math.min(Math.max(x, 0), runs[0].width - 1);
  place.y = Math.min(Math.max(y, 0), runs[0].height - 1);
  articles.forEach((article, i) => showExplanation(runs[i], article, place.x, place.y));
}

articles.forEach((article, i) => {
  const run = runs[i], picture = article.querySelector(".picture"),
        slider = article.querySelector("input[type=range]");
  run.unpacked = unpack(run.explanations);
  slider.addEventListener("input", () => showSnapshot(run, article, Number(slider.value)));
  showSnapshot(run, article, Number(slider.value));
  picture.addEventListener("click", event => {
    const box = picture.querySelector("img").getBoundingClientRect();
    choose(
        Math.floor((event.clientX - box.left) / box.width * run.width),
        Math.floor((event.clientY - box.top) / box.height * run.height));
    picture.focus({preventScroll: true});
  });
  picture.addEventListener("keydown", event => {
    const step = event.shiftKey ? 10 : 1;
    const move = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, -step],
      ArrowDown: [0, step],
      Enter: [0, 0],
      " ": [0, 0]
    }[event.key];
    if (!move) return;
    event.preventDefault();
    choose(place.x + move[0], place.y + move[1]);
  });
});
})();
