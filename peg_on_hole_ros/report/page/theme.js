// Colours and axes of plots, of the page's light or dark theme.
"use strict";

function cssColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

function translucent(hex, alpha) {
  const part = (i) => parseInt(hex.slice(i, i + 2), 16);
  return `rgba(${part(1)},${part(3)},${part(5)},${alpha})`;
}

function axisStyle(more) {
  return {
    gridcolor: cssColor("grid"), zerolinecolor: cssColor("line"), linecolor: cssColor("line"),
    ...more,
  };
}

function paperStyle() {
  return {
    margin: { l: 62, r: 12, t: 8, b: 34 },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, sans-serif", size: 12, color: cssColor("ink") },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: cssColor("muted"), activecolor: cssColor("accent") },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    hoverlabel: { bgcolor: cssColor("page"), bordercolor: cssColor("line"), font: { color: cssColor("ink") } },
  };
}
