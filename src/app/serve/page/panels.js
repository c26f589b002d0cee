/* Tabs: one panel at a time beside the picture. */
const tabs = [...document.querySelectorAll("[role=tab]")];

export function show_panel(name) {
  for (const tab of tabs) {
    const is_chosen = tab.id === "tab-" + name;
    tab.setAttribute("aria-selected", String(is_chosen));
    tab.tabIndex = is_chosen ? 0 : -1;
    document.getElementById(tab.getAttribute("aria-controls")).hidden = !is_chosen;
  }
}

function key(event) {
  const by = {ArrowLeft: -1, ArrowRight: 1}[event.key], at = tabs.indexOf(event.target);
  if (!by) return;
  event.preventDefault();
  const next = tabs[(at + by + tabs.length) % tabs.length];
  next.focus();
  next.click();
}

export function begin_panels() {
  for (const tab of tabs) {
    tab.addEventListener("click", () => show_panel(tab.id.slice(4)));
    tab.addEventListener("keydown", key);
  }
  show_panel("method");
}
