// The plots of many bags: each try a point, which leads to its bag's report.
"use strict";

const OUTCOMES = { inserted: "c2", jammed: "error", aborted: "warn", unfinished: "muted" };

// B1 and B2 often carry the same: neither hides the other.
const SYMBOLS = ["circle", "square-open", "x-thin-open"];

function pointTraces(tries, plot) {
  return plot.lines.map((line) => ({
    x: tries.number, y: tries[line.column], text: tries.said, type: "scatter", mode: "markers",
    name: line.name, marker: { color: cssColor("c" + line.color), size: 7, symbol: SYMBOLS[line.color] },
    hovertemplate: `%{text}<br>${line.name}: %{y:.4g} ${plot.unit}<extra></extra>`,
  }));
}

function outcomeTraces(tries) {
  return Object.entries(OUTCOMES).map(([outcome, color]) => {
    const of = tries.number.filter((_, i) => tries.outcome[i] === outcome);
    return {
      x: of, y: of.map(() => 1), width: 0.9, type: "bar", name: `${outcome} (${of.length})`,
      text: of.map((n) => tries.said[n - 1]), textposition: "none", showlegend: of.length > 0,
      marker: { color: cssColor(color), line: { width: 0 } }, hovertemplate: "%{text}<extra></extra>",
    };
  });
}

function drawShift(model) {
  const config = { responsive: true, displaylogo: false, modeBarButtons: [["zoom2d", "pan2d", "resetScale2d"]] };
  const count = model.tries.number.length;
  for (const plot of model.plots) {
    const div = document.querySelector(`.plot[data-panel="${plot.name}"]`);
    const bars = plot.name === "outcomes";
    const layout = {
      ...paperStyle(), autosize: true, barmode: "overlay", hovermode: "closest", bargap: 0,
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
      xaxis: axisStyle({ range: [0.3, count + 0.7], tick0: 1, dtick: Math.max(1, Math.ceil(count / 8)), tickprefix: "try " }),
      yaxis: axisStyle({ title: { text: plot.unit, standoff: 4 }, rangemode: "tozero", visible: !bars }),
    };
    Plotly.react(div, bars ? outcomeTraces(model.tries) : pointTraces(model.tries, plot), layout, config);
  }
}

async function start() {
  const waiting = document.querySelector(".waiting");
  try {
    runScript(await unpacked("library"));
    const model = JSON.parse(await unpacked("data"));
    drawShift(model);
    for (const div of document.querySelectorAll(".plot")) {
      div.on("plotly_click", (event) => {
        const link = model.tries.link[event.points[0].x - 1];
        if (link) location.assign(link);
      });
    }
    for (const query of ["(prefers-color-scheme: dark)", "print"]) {
      matchMedia(query).addEventListener("change", () => drawShift(model));
    }
    document.documentElement.dataset.ready = "yes";
    waiting.remove();
  } catch (error) {
    waiting.className = "failed";
    waiting.textContent = `The plots cannot be drawn (${error.message}): open the page in a browser of 2023 or later.`;
    throw error;
  }
}

start();
