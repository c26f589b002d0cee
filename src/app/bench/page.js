"use strict";
/* Makes the page of the report's Markdown, as far as that goes there: headings, tables, plots, `code`,
 * **bold**, *emphasis*, [text](#place). */
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const main = document.querySelector("main");

  const entities = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
  const escaped = text => text.replace(/[&<>"]/g, c => entities[c]);

  function words(text) {
    return escaped(text).split(/(`[^`]*`)/).map(part =>
      part[0] === "`" ? "<code>" + part.slice(1, -1) + "</code>" :
      part.replace(/\*\*(.+?)\*\*/g, "<b>$1</b>").replace(/\*(.+?)\*/g, "<em>$1</em>")
        .replace(/\[([^\]]*)\]\((#[^)]*)\)/g, '<a href="$2">$1</a>')).join("");
  }

  /* Words stand at the left, figures at the right. */
  function row(line, tag) {
    const cells = line.split("|").slice(1, -1).map(cell => cell.trim());
    const side = cell => /^[a-z`]/i.test(cell) ? ' class="t"' : "";
    return "<tr>" + cells.map(cell => `<${tag}${side(cell)}>${words(cell)}</${tag}>`).join("") + "</tr>";
  }

  function table(lines) {
    return '<div class="wide"><table>' + row(lines[0], "th") +
      lines.slice(2).map(line => row(line, "td")).join("") + "</table></div>";
  }

  function markdown(text, plots) {
    let html = "", lines = [];
    for (const line of (text + "\n").split("\n")) {
      const heading = line.match(/^(#+) (.*)/), plot = line.match(/^!\[.*, (.*)\]/);
      if (line[0] === "|") lines.push(line);
      else if (lines.length) html += table(lines), lines = [];
      const tag = heading && "h" + heading[1].length;
      if (heading) html += `<${tag} id="${escaped(heading[2])}">${words(heading[2])}</${tag}>`;
      else if (plot) html += '<div class="wide">' + (plots[plot[1]] || "") + "</div>";
      else if (line && line[0] !== "|") html += "<p>" + words(line) + "</p>";
    }
    return html;
  }

  function figures(title, note, all) {
    if (!all.length) return "";
    return `<h3>${title}</h3><p>${note}</p><div class="grid">` + all.map(f =>
      `<figure><img alt="${escaped(f.title)}" src="data:image/png;base64,${f.picture}">` +
      `<figcaption>${escaped(f.title)}<br><span class="soft">${escaped(f.note)}</span></figcaption></figure>`
    ).join("") + "</div>";
  }

  main.innerHTML = markdown(data.overview, {}) + data.scenes.map(scene => markdown(scene.text, scene.plots) +
    figures("Where the error sits", "Each picture against its own light paths: blue is too dark, red too " +
            "bright, full colour at 50 %; grey is not compared.", scene.differences) +
    figures("What the methods cannot see", "", scene.references)).join("");
})();
