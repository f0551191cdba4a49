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

  metric.onchange = axis.onchange = plots;
  axis.value = innerWidth > 1100 ? "both" : "seconds";
  plots();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", plots);
  addEventListener("beforeprint", plots);
  addEventListener("afterprint", plots);

  window.viewers = sections.flatMap((section) => {
    const place = section.querySelector(".viewer");
    return place ? [new Viewer(place, scenes[section.dataset.scene], magma)] : [];
  });
  window.ready = Promise.all(window.viewers.map((viewer) => viewer.start()));
})();
