"use strict";
/* The slider plays the refinement; a pixel, by mouse or keys, tells what made it. */
(function () {
  const runs = JSON.parse(document.getElementById("data").textContent);
  const articles = [...document.querySelectorAll("article")];

  function bytes(text) {
    const raw = atob(text), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }

  function percent(error) { return error < 0 ? "" : ", off by " + (100 * error).toPrecision(3) + " %"; }
  function number(x) { return x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-4 ? x.toExponential(3) : x.toPrecision(4); }
  function element(name, parent, text) {
    const e = document.createElement(name);
    if (text !== undefined) e.textContent = text;
    parent.append(e);
    return e;
  }

  /* ---- the refinement ---- */

  function lastUpTo(frames, snapshot, which) {
    for (let i = snapshot; i >= 0; i--) if (frames[i][which] !== null) return frames[i][which];
    return null;
  }

  function showSnapshot(run, article, snapshot) {
    const s = run.snapshots[snapshot];
    article.querySelector(".picture img").src = "data:image/png;base64," + s.picture;
    article.querySelector(".slider output").textContent =
      "batch " + s.batches + " of " + run.snapshots[run.snapshots.length - 1].batches + percent(s.error);
    for (const figure of article.querySelectorAll("figure.pass")) {
      const frames = run.steps[Number(figure.dataset.step)];
      const picture = lastUpTo(frames, snapshot, 0), marks = lastUpTo(frames, snapshot, 1);
      const image = figure.querySelector("img"), svg = figure.querySelector("svg.marks");
      const known = frames.some(f => f[0] !== null);
      if (picture !== null) image.src = "data:image/png;base64," + picture;
      else if (!known) image.src = "data:image/png;base64," + s.picture;
      figure.classList.toggle("not-yet", known ? picture === null : marks === null);
      if (svg) svg.innerHTML = marks || "";
    }
  }

  /* ---- the explanation of a pixel ---- */

  function unpack(explanations) {
    return { kinds: explanations.kinds, items: explanations.items, begin: new Uint32Array(bytes(explanations.begin)), item: new Uint32Array(bytes(explanations.item)),
             values: new Float32Array(bytes(explanations.values)), rounding: new Float64Array(bytes(explanations.rounding)) };
  }

  /* In the order of the terms, in double precision, the rest last: the picture's exact values. */
  function tell(run, x, y) {
    const s = run.unpacked, pixel = y * run.width + x, sum = [0, 0, 0], terms = [];
    for (let i = s.begin[pixel]; i < s.begin[pixel + 1]; i++) {
      const item = s.items[s.item[i]], given = s.values.subarray(7 * i, 7 * i + 7);
      terms.push({ layer: s.kinds[item[0]][0], kind: s.kinds[item[0]][1], index: item[1], column: item[2], row: item[3],
                   value: [...given.subarray(4)], weight: given[0], contribution: [...given.subarray(1, 4)] });
      for (let c = 0; c < 3; c++) sum[c] += given[1 + c];
    }
    const rest = [...s.rounding.subarray(3 * pixel, 3 * pixel + 3)];
    return { x, y, terms, rest, pixel: sum.map((v, c) => v + rest[c]) };
  }

  function row(table, cells, kind) {
    const tr = element("tr", table);
    if (kind) tr.className = kind;
    cells.forEach((text, i) => { const td = element("td", tr, text); if (i < 2) td.className = "text"; });
    return tr;
  }

  function showExplanation(run, article, x, y) {
    const explanation = tell(run, x, y), box = article.querySelector(".explanation");
    box.replaceChildren();
    element("h3", box, "The explanation of pixel " + x + ", " + y);
    const table = element("table", box), head = element("tr", table);
    for (const title of ["what", "layer", "weight", "holds (R G B)", "adds R", "G", "B", ""]) element("th", head, title).scope = "col";
    const size = t => Math.abs(t.contribution[0]) + Math.abs(t.contribution[1]) + Math.abs(t.contribution[2]);
    const most = Math.max(...explanation.terms.map(size), 1e-30);
    for (const t of explanation.terms) {
      const name = t.kind + (t.kind.startsWith("smaller") || t.column === null && t.index === 0 ? "" : " " + t.index);
      const tr = row(table, [name, t.layer, number(t.weight), t.value.map(number).join(" "), ...t.contribution.map(number)]);
      const bar = element("span", element("td", tr));
      bar.className = "bar";
      bar.style.width = (6 * size(t) / most) + "em";
    }
    row(table, ["rounding", "", "", "", ...explanation.rest.map(number)]);
    row(table, ["the pixel", "", "", "", ...explanation.pixel.map(number)], "sum");
    drawPlace(run, article, explanation);
    article.dataset.explanation = JSON.stringify(explanation.pixel);
  }

  function drawPlace(run, article, explanation) {
    const svg = article.querySelector(".picture svg.marks");
    let text = '<rect class="pixel" x="' + explanation.x + '" y="' + explanation.y + '" width="1" height="1"/>';
    for (const t of explanation.terms)
      if (t.column !== null) text += '<circle class="maker" cx="' + t.column + '" cy="' + t.row + '" r="1.6"/>';
    svg.innerHTML = text;
  }

  /* ---- what people do ---- */

  const place = { x: Math.floor(runs[0].width / 2), y: Math.floor(runs[0].height / 2) };

  function choose(x, y) {
    place.x = Math.min(Math.max(x, 0), runs[0].width - 1);
    place.y = Math.min(Math.max(y, 0), runs[0].height - 1);
    articles.forEach((article, i) => showExplanation(runs[i], article, place.x, place.y));
  }

  articles.forEach((article, i) => {
    const run = runs[i], picture = article.querySelector(".picture"), slider = article.querySelector("input[type=range]");
    run.unpacked = unpack(run.explanations);
    slider.addEventListener("input", () => showSnapshot(run, article, Number(slider.value)));
    showSnapshot(run, article, Number(slider.value));
    picture.addEventListener("click", event => {
      const box = picture.querySelector("img").getBoundingClientRect();
      choose(Math.floor((event.clientX - box.left) / box.width * run.width), Math.floor((event.clientY - box.top) / box.height * run.height));
      picture.focus({ preventScroll: true });
    });
    picture.addEventListener("keydown", event => {
      const step = event.shiftKey ? 10 : 1;
      const move = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step], Enter: [0, 0], " ": [0, 0] }[event.key];
      if (!move) return;
      event.preventDefault();
      choose(place.x + move[0], place.y + move[1]);
    });
  });
})();
