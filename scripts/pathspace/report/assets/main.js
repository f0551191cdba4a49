"use strict";

(() => {
  const { scenes, styles, magma } = JSON.parse(document.getElementById("data").textContent);
  const [metric, axis] = [document.getElementById("metric"), document.getElementById("axis")];
  const sections = [...document.querySelectorAll(".scene")];

  function plots() {
    if (!metric.value) return;
    const label = metric.selectedOptions[0].text;
    for (const section of sections) {
      Plots.show(section, scenes[section.dataset.scene], styles, metric.value, label, axis.value);
    }
  }

  /** Verdicts by other metrics than the chosen one are folded away. */
  function verdicts() {
    for (const cell of document.querySelectorAll('td[data-column="metric"]')) {
      cell.parentElement.hidden = Boolean(metric.value) && cell.textContent !== metric.value;
    }
  }

  metric.onchange = () => {
    plots();
    verdicts();
  };
  axis.onchange = plots;
  axis.value = innerWidth > 1100 ? "both" : "seconds";
  plots();
  verdicts();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", plots);
  addEventListener("beforeprint", plots);
  addEventListener("afterprint", plots);

  window.viewers = sections.flatMap((section) => {
    const place = section.querySelector(".viewer");
    return place ? [new Viewer(place, scenes[section.dataset.scene], magma)] : [];
  });
  window.ready = Promise.all(window.viewers.map((viewer) => viewer.start()));
})();
