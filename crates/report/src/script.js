"use strict";
// The page is complete without this; it only makes reading more convenient.
(function () {
  const root = document.documentElement;
  const wantsDark = window.matchMedia("(prefers-color-scheme: dark)");
  const button = document.getElementById("theme");
  const isDark = () => (root.dataset.theme || (wantsDark.matches ? "dark" : "light")) === "dark";
  const name = () => {
    button.textContent = isDark() ? "Light" : "Dark";
    button.setAttribute("aria-label", "Switch to the " + (isDark() ? "light" : "dark") + " theme");
  };
  button.hidden = false;
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    name();
  });
  wantsDark.addEventListener("change", name);
  name();

  // Outcomes in the key become filters of the comparisons.
  const comparisons = document.getElementById("comparisons");
  const rows = [...comparisons.querySelectorAll("[data-outcome]")];
  const filters = [...comparisons.querySelectorAll("[data-filter]")];
  let chosen = null;
  const apply = () => {
    for (const row of rows) row.hidden = chosen !== null && row.dataset.outcome !== chosen;
    for (const card of comparisons.querySelectorAll(".subject")) {
      const shown = card.querySelectorAll("[data-outcome]:not([hidden])").length;
      card.hidden = chosen !== null && shown === 0;
      card.querySelector("details").open = chosen !== null && shown > 0;
    }
    for (const filter of filters)
      filter.firstElementChild.setAttribute("aria-pressed", String(filter.dataset.filter === chosen));
  };
  for (const filter of filters) {
    const toggle = document.createElement("button");
    toggle.type = "button";
    toggle.className = "filter";
    toggle.title = "Show only these pairs";
    toggle.setAttribute("aria-pressed", "false");
    toggle.append(...filter.childNodes);
    filter.append(toggle);
    toggle.addEventListener("click", () => {
      chosen = chosen === filter.dataset.filter ? null : filter.dataset.filter;
      apply();
    });
  }

  // The navigation says where the reader is.
  const list = document.querySelector("nav ul");
  const links = new Map();
  for (const link of document.querySelectorAll("nav a")) links.set(link.hash.slice(1), link);
  const watcher = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) {
        const link = links.get(entry.target.id);
        if (link && entry.isIntersecting) {
          for (const other of links.values()) other.removeAttribute("aria-current");
          link.setAttribute("aria-current", "true");
          list.scrollLeft = link.offsetLeft - list.offsetLeft - list.clientWidth / 3;
        }
      }
    },
    { rootMargin: "-20% 0px -75% 0px" },
  );
  for (const section of document.querySelectorAll("main > section")) watcher.observe(section);
})();
