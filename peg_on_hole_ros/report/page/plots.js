// The plots: one after the other below each other, zoomed together, with one cursor through all.
"use strict";

// Outlines of the stretches in which both bounds are known: gaps stay gaps.
function outline(t, low, high) {
  const x = [], y = [];
  let begin = null;
  for (let i = 0; i <= t.length; i++) {
    const known = i < t.length && low[i] !== null && high[i] !== null;
    if (known && begin === null) begin = i;
    if (known || begin === null) continue;
    for (let k = begin; k < i; k++) { x.push(t[k]); y.push(high[k]); }
    for (let k = i - 1; k >= begin; k--) { x.push(t[k]); y.push(low[k]); }
    x.push(null); y.push(null);
    begin = null;
  }
  return { x, y };
}

// Values without their bounds, which may be wide, and a margin.
function valueRange(model, panel) {
  let low = Infinity, high = -Infinity;
  for (const line of panel.lines) {
    for (const value of model.tables[line.table][line.column]) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (low > high) return [-1, 1];
  const margin = Math.max(0.15 * (high - low), 0.02);
  return [low - margin, high + margin];
}

function lineTraces(model, panel) {
  const traces = [], named = new Set();
  for (const line of panel.lines) {
    const table = model.tables[line.table], color = cssColor("c" + line.color);
    const truth = line.style === "truth", name = truth ? "truth" : line.name;
    const y = table[line.column];
    if (line.band && table[line.column + "_low"]) {
      traces.push({
        ...outline(table.t, table[line.column + "_low"], table[line.column + "_high"]),
        type: "scatter", mode: "lines", fill: "toself", fillcolor: translucent(color, 0.2),
        line: { width: 0 }, hoverinfo: "skip", showlegend: false, legendgroup: name,
      });
    }
    traces.push({
      x: table.t, y: panel.log ? y.map((v) => (v > 0 ? v : null)) : y,
      type: "scatter", mode: "lines", name, legendgroup: name, showlegend: !named.has(name),
      line: {
        // A broad pale line below that of the estimate.
        color: truth ? translucent(cssColor("muted"), 0.45) : line.style === "noise" ? translucent(color, 0.45) : color,
        width: truth ? 4.5 : line.style === "noise" ? 1 : 1.5,
        dash: line.style === "second" ? "dash" : "solid",
      },
      hovertemplate: `${truth ? line.name + " truth" : line.name}: %{y:.5g}<extra></extra>`,
    });
    named.add(name);
  }
  return traces;
}

function levelTraces(model, panel) {
  return panel.levels.map((level) => ({
    x: [0, model.end], y: [level.y, level.y], type: "scatter", mode: "lines", name: level.name,
    line: { color: cssColor(level.strong ? "error" : "muted"), width: 1, dash: "dashdot" },
    hovertemplate: `${level.name}: %{y:.5g}<extra></extra>`,
  }));
}

function alarmTraces(model) {
  return ["WARN", "ERROR"].map((severity) => {
    const found = model.alarms.filter((alarm) => alarm.level === severity && alarm.rises);
    return {
      x: found.map((alarm) => alarm.t), y: found.map(() => 1.04), text: found.map((a) => a.name),
      type: "scatter", mode: "markers", name: "alarm " + severity, showlegend: found.length > 0,
      marker: { symbol: "triangle-down", size: 11, color: cssColor(severity.toLowerCase()) },
      hovertemplate: `%{text} ${severity}<extra></extra>`,
    };
  });
}

function modeTraces(model) {
  // An empty one: no estimate came.
  const names = [...new Set(model.modes.flatMap((row) => row.changes.map((c) => c[1])))].filter(Boolean);
  return names.map((mode) => {
    const base = [], x = [], y = [];
    for (const row of model.modes) {
      row.changes.forEach(([t, name], i) => {
        if (name !== mode) return;
        base.push(t);
        x.push((i + 1 < row.changes.length ? row.changes[i + 1][0] : model.end) - t);
        y.push(row.name);
      });
    }
    return {
      type: "bar", orientation: "h", base, x, y, name: mode, width: 0.8,
      marker: { color: cssColor(mode) || cssColor("muted"), line: { width: 0 } },
      hovertemplate: `${mode}: from %{base:.3f} s for %{x:.3f} s<extra></extra>`,
    };
  });
}

// A wedged peg's bounds have no limit: the plot is for what is known.
function reactionRange(model, panel) {
  let top = 1;
  for (const line of panel.lines) {
    for (const value of model.tables[line.table][line.column]) if (value > top) top = value;
  }
  return [-0.06 * top, 1.15 * top];
}

function layoutOf(model, panel, range) {
  const y = axisStyle({ title: { text: panel.unit, standoff: 4 }, type: panel.log ? "log" : "linear" });
  if (panel.log) Object.assign(y, { tickformat: "~g", dtick: 1 });
  if (panel.floor) y.autorangeoptions = { minallowed: Math.log10(panel.floor) };
  if (panel.range === "unit") y.range = [-0.04, 1.12];
  if (panel.range === "values") y.range = valueRange(model, panel);
  if (panel.range === "reactions") y.range = reactionRange(model, panel);
  if (panel.bands) Object.assign(y, { type: "category", autorange: "reversed", showgrid: false });
  const coarse = matchMedia("(pointer: coarse)").matches;
  return {
    autosize: true, barmode: "overlay", bargap: 0.1, hovermode: panel.bands ? "closest" : "x unified",
    // A finger scrolls the page; the buttons zoom.
    dragmode: coarse ? false : "zoom",
    ...paperStyle(),
    xaxis: axisStyle({ range, ticksuffix: " s", hoverformat: ".4f" }),
    yaxis: y,
  };
}

// What a plot draws, a row for each point: sources have times of their own.
function csvOf(model, panel) {
  if (panel.bands) {
    const rows = model.modes.flatMap((row) => row.changes.map(([t, mode]) => [row.name, t, mode]));
    return [["source", "time_s", "mode"], ...rows].map((row) => row.join(",")).join("\n") + "\n";
  }
  const unit = panel.unit ? ` [${panel.unit}]` : "", rows = [["time_s", "line", `value${unit}`, "low", "high"]];
  for (const line of panel.lines) {
    const table = model.tables[line.table], column = table[line.column];
    const low = line.band && table[line.column + "_low"], high = line.band && table[line.column + "_high"];
    const name = line.style === "truth" ? `${line.name} truth` : line.name;
    column.forEach((value, i) => {
      rows.push([table.t[i], name, value, low ? low[i] : "", high ? high[i] : ""]);
    });
  }
  return rows.map((row) => row.map((cell) => (cell === null ? "" : cell)).join(",")).join("\n") + "\n";
}

class Plots {
  constructor(model, onTime) {
    this.model = model;
    this.range = [0, model.end];
    this.time = 0;
    this.syncing = false;
    this.panels = model.panels.map((panel) => ({
      panel, div: document.querySelector(`.plot[data-panel="${panel.name}"]`),
    }));
    this.marked = null;
    this.draw();
    for (const { div } of this.panels) {
      div.on("plotly_relayout", (event) => this.follow(event));
      div.on("plotly_hover", (event) => {
        const at = event.xvals ? event.xvals[0] : event.points[0].x;
        if (Number.isFinite(at)) onTime(at);
      });
      div.on("plotly_afterplot", () => this.placeCursor());
      for (const name of ["cursor", "cursor mark-line"]) {
        const line = document.createElement("div");
        line.className = name;
        div.append(line);
      }
    }
  }

  traces(panel) {
    if (panel.bands) return modeTraces(this.model);
    const traces = [...lineTraces(this.model, panel), ...levelTraces(this.model, panel)];
    return panel.alarms ? [...traces, ...alarmTraces(this.model)] : traces;
  }

  draw() {
    const config = {
      responsive: true, displayModeBar: matchMedia("(pointer: coarse)").matches ? false : "hover", displaylogo: false, doubleClick: "reset",
      modeBarButtons: [["zoom2d", "pan2d", "resetScale2d"]],
    };
    for (const { panel, div } of this.panels) {
      Plotly.react(div, this.traces(panel), layoutOf(this.model, panel, this.range), config);
    }
  }

  follow(event) {
    if (this.syncing) return;
    if (event["xaxis.autorange"]) return this.setRange(0, this.model.end);
    const range = event["xaxis.range"] || [event["xaxis.range[0]"], event["xaxis.range[1]"]];
    if (range[0] !== undefined) this.setRange(range[0], range[1]);
  }

  setRange(from, to) {
    const whole = Math.max(this.model.end, 1e-3);
    const span = Math.min(Math.max(to - from, 1e-3), whole);
    const begin = Math.min(Math.max(from, 0), whole - span);
    this.range = [begin, begin + span];
    this.syncing = true;
    const done = this.panels.map(({ div }) => Plotly.relayout(div, { "xaxis.range": [...this.range] }));
    return Promise.all(done).finally(() => { this.syncing = false; });
  }

  zoom(factor) {
    const half = (this.range[1] - this.range[0]) / 2 * factor;
    const inside = this.time >= this.range[0] && this.time <= this.range[1];
    const middle = inside ? this.time : (this.range[0] + this.range[1]) / 2;
    return this.setRange(middle - half, middle + half);
  }

  setTime(t) {
    this.time = t;
    this.placeCursor();
  }

  // The time that a link leads to stays marked, wherever the cursor goes.
  mark(t) {
    this.marked = t;
    this.placeCursor();
  }

  placeCursor() {
    for (const { div } of this.panels) {
      this.placeLine(div, ".cursor:not(.mark-line)", this.time);
      this.placeLine(div, ".mark-line", this.marked);
    }
  }

  placeLine(div, selector, t) {
    const line = div.querySelector(selector), size = div._fullLayout && div._fullLayout._size;
    if (!line || !size) return;
    const shown = t !== null && t >= this.range[0] && t <= this.range[1];
    const share = (t - this.range[0]) / (this.range[1] - this.range[0]);
    Object.assign(line.style, {
      display: shown ? "block" : "none", left: `${size.l + share * size.w}px`,
      top: `${size.t}px`, height: `${size.h}px`,
    });
  }
}
