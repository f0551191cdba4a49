"use strict";

/** Error over time and over samples, by plotly.js. */
const Plots = (() => {
  const SYMBOLS = {
    o: "circle", s: "square", "^": "triangle-up", D: "diamond", v: "triangle-down", P: "cross", X: "x",
    "<": "triangle-left", ">": "triangle-right",
  };
  const AXES = { seconds: "rendering time [s]", spp: "samples per pixel" };
  const OPTIONS = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };

  function faint(colour, opacity) {
    const [r, g, b] = [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
    return `rgba(${r},${g},${b},${opacity})`;
  }

  function escaped(text) {
    return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
  }

  function chosen(curve, indices, name) {
    return indices.map((i) => curve[name][i]);
  }

  /** A band, a line, and apart from it what is below the noise of the reference. */
  function traces(curve, style, axis, name) {
    const all = curve.error.map((_, i) => i).filter((i) => curve.error[i] > 0 && curve[axis][i] > 0);
    const [sure, noisy] = [all.filter((i) => !curve.noisy[i]), all.filter((i) => curve.noisy[i])];
    const banded = sure.filter((i) => curve.low[i] > 0 && curve.high[i] > 0);
    const colour = style.colour;
    const shared = { legendgroup: name, mode: "lines", hoverinfo: "skip", showlegend: false, line: { width: 0 } };
    const x = chosen(curve, banded, axis);
    const symbol = SYMBOLS[style.marker] ?? "circle";
    const found = [
      { ...shared, x, y: chosen(curve, banded, "low") },
      { ...shared, x, y: chosen(curve, banded, "high"), fill: "tonexty", fillcolor: faint(colour, 0.18) },
    ];
    for (const [indices, isSure] of [[sure, true], [noisy, false]]) {
      if (!isSure && !indices.length) continue;
      const open = style.foreign || !isSure ? "-open" : "";
      found.push({
        x: chosen(curve, indices, axis),
        y: chosen(curve, indices, "error"),
        customdata: indices.map((i) => [curve.low[i] ?? "–", curve.high[i] ?? "–", curve.seeds[i], curve.spp[i], curve.seconds[i]]),
        name: escaped(name),
        legendgroup: name,
        showlegend: isSure,
        mode: isSure ? "lines+markers" : "markers",
        opacity: isSure ? 1 : 0.5,
        line: { color: colour, width: 2, dash: style.foreign ? "dash" : "solid" },
        marker: { color: colour, symbol: symbol + open, size: 8 },
        hovertemplate:
          `<b>${escaped(name)}</b><br>%{y:.4g}  [%{customdata[0]:.3g}, %{customdata[1]:.3g}]<br>` +
          `%{customdata[4]:.3g} s, %{customdata[3]:.4g} spp, %{customdata[2]} seeds` +
          `${isSure ? "" : "<br>below the noise of the reference"}<extra></extra>`,
      });
    }
    return found;
  }

  function floor(level, data) {
    const xs = data.flatMap((trace) => trace.x);
    return {
      x: [Math.min(...xs), Math.max(...xs)],
      y: [level, level],
      mode: "lines",
      line: { color: "#888", width: 1.5, dash: "dot" },
      name: "noise of the reference",
      hoverinfo: "skip",
    };
  }

  function draw(place, scene, styles, metric, label, axis) {
    const curves = scene.curves.filter((curve) => curve.metric === metric);
    const machines = new Set(curves.map((curve) => curve.hardware));
    const data = curves.flatMap((curve) => {
      const name = machines.size > 1 ? `${curve.method} (${curve.hardware})` : curve.method;
      return traces(curve, styles[curve.method] ?? { colour: "#888888", marker: "o" }, axis, name);
    });
    const level = scene.noise[metric];
    const lowest = Math.min(...data.flatMap((trace) => trace.y));
    // Far below all errors it would only press them together.
    if (level > 0.1 * lowest) data.push(floor(level, data));
    const dark = matchMedia("(prefers-color-scheme: dark)").matches && !matchMedia("print").matches;
    const [text, line] = dark ? ["#e8e8e8", "#3c3c3c"] : ["#1b1b1b", "#e2e2e2"];
    const axisLook = (values) => ({
      type: "log",
      gridcolor: line,
      zeroline: false,
      // Three ticks to a decade, as long as there is room for them.
      dtick: Math.max(...values) / Math.min(...values) > 1e3 ? 1 : "D2",
      automargin: true,
      exponentformat: "power",
    });
    const layout = {
      margin: { l: 62, r: 12, t: 8, b: 48 },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: text, size: 13 },
      hovermode: "closest",
      legend: { orientation: "h", y: -0.2 },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: "#999", activecolor: text },
      xaxis: { ...axisLook(data.flatMap((trace) => trace.x)), title: { text: AXES[axis] } },
      yaxis: { ...axisLook(data.flatMap((trace) => trace.y)), title: { text: escaped(label) } },
    };
    return Plotly.react(place, data, layout, OPTIONS);
  }

  /** All plots of a scene, as the controls ask for. */
  function show(section, scene, styles, metric, label, axis) {
    const place = section.querySelector(".plots");
    if (!place) return;
    const axes = axis === "both" ? ["seconds", "spp"] : [axis];
    while (place.children.length > axes.length) place.lastChild.remove();
    while (place.children.length < axes.length) {
      const plot = document.createElement("div");
      plot.className = "plot";
      place.append(plot);
    }
    axes.forEach((each, i) => {
      const plot = place.children[i];
      plot.setAttribute("role", "img");
      plot.setAttribute("aria-label", `${scene.name}: ${label} against ${AXES[each]}`);
      draw(plot, scene, styles, metric, label, each);
    });
  }

  return { show };
})();
