// Strip charts of the last seconds, on canvases: twenty times a second must not cost a core.
"use strict";

const SPAN = 20, LEFT = 46, BOTTOM = 18, TOP = 16, RIGHT = 8;

// Points of all lines by name; what has left the window is let go of.
class Points {
  // Without a point for `silence` [s] a line breaks.
  constructor(silence) {
    this.silence = silence;
    this.columns = new Map();
    this.modes = [];
    this.rises = [];
    this.end = 0;
  }

  // From when to when no estimate came.
  gaps() {
    const points = this.columns.get("gamma") || [];
    return points.slice(1).map(([t], i) => [points[i][0], t]).filter(([from, to]) => to - from > this.silence);
  }

  add(frame) {
    for (const [name, points] of Object.entries(frame.lines || {})) {
      if (!this.columns.has(name)) this.columns.set(name, []);
      this.columns.get(name).push(...points);
    }
    this.modes.push(...(frame.modes || []));
    this.rises.push(...(frame.rises || []));
    if (frame.t !== undefined) this.end = frame.t;
    const begin = this.end - SPAN - 1;
    for (const points of this.columns.values()) {
      let gone = 0;
      while (gone < points.length && points[gone][0] < begin) gone++;
      if (gone > 200) points.splice(0, gone);
    }
    while (this.modes.length > 1 && this.modes[1][0] < begin) this.modes.shift();
    while (this.rises.length && this.rises[0].t < begin) this.rises.shift();
  }
}

function niceStep(span, count) {
  const raw = span / count, power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= raw);
}

class Strip {
  constructor(canvas, plot) {
    this.canvas = canvas;
    this.plot = plot;
  }

  begin() {
    const ratio = devicePixelRatio || 1, { clientWidth: w, clientHeight: h } = this.canvas;
    if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
      this.canvas.width = Math.round(w * ratio);
      this.canvas.height = Math.round(h * ratio);
    }
    const pen = this.canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.font = "11px system-ui, sans-serif";
    pen.textBaseline = "middle";
    this.w = w; this.h = h; this.pen = pen;
  }

  x(t) { return LEFT + (t - this.from) / SPAN * (this.w - LEFT - RIGHT); }
  y(v) { return this.h - BOTTOM - (v - this.low) / (this.high - this.low) * (this.h - TOP - BOTTOM); }

  draw(points) {
    this.begin();
    this.from = Math.max(points.end - SPAN, 0);
    this.range(points);
    this.grid();
    const { pen } = this;
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, TOP - 2, this.w - LEFT - RIGHT, this.h - TOP - BOTTOM + 4);
    pen.clip();
    for (const level of this.plot.levels) this.level(level);
    this.plot.lines.forEach((line) => this.line(line, points.columns.get(line.column) || [], points.silence));
    if (this.plot.rises) points.rises.forEach((rise) => this.rise(rise));
    pen.restore();
    this.legend();
  }

  range(points) {
    [this.low, this.high] = this.plot.range || [0, 0];
    if (this.plot.range) return;
    for (const { column, scale = 1 } of this.plot.lines) {
      for (const [t, v] of points.columns.get(column) || []) {
        if (t < this.from || v === null) continue;
        this.low = Math.min(this.low, scale * v);
        this.high = Math.max(this.high, scale * v);
      }
    }
    this.high = Math.max(this.high, this.plot.least);
    const margin = 0.08 * (this.high - this.low);
    this.high += margin;
    if (this.low < 0) this.low -= margin;
  }

  grid() {
    const { pen } = this;
    pen.fillStyle = cssColor("muted");
    pen.strokeStyle = cssColor("grid");
    pen.lineWidth = 1;
    const step = niceStep(this.high - this.low, 4);
    pen.textAlign = "right";
    for (let v = Math.ceil(this.low / step) * step; v <= this.high; v += step) {
      this.stroke([[LEFT, this.y(v)], [this.w - RIGHT, this.y(v)]]);
      pen.fillText(Number(v.toPrecision(6)).toString(), LEFT - 5, this.y(v));
    }
    pen.textAlign = "center";
    for (let t = Math.max(Math.ceil(this.from / 5) * 5, 0); t <= this.from + SPAN; t += 5) {
      this.stroke([[this.x(t), TOP], [this.x(t), this.h - BOTTOM]]);
      pen.fillText(`${t} s`, Math.min(this.x(t), this.w - 16), this.h - BOTTOM / 2 + 1);
    }
  }

  stroke(points) {
    this.pen.beginPath();
    points.forEach(([x, y], i) => (i ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y)));
    this.pen.stroke();
  }

  line({ column, color, scale = 1 }, points, silence) {
    const { pen } = this;
    pen.strokeStyle = cssColor("c" + color);
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.beginPath();
    let before = null;
    for (const [t, v] of points) {
      const joined = before !== null && t - before <= silence;
      if (v !== null) pen[joined ? "lineTo" : "moveTo"](this.x(t), this.y(scale * v));
      before = v === null ? null : t;
    }
    pen.stroke();
  }

  level({ y, name, strong }) {
    const { pen } = this;
    pen.strokeStyle = pen.fillStyle = cssColor(strong ? "error" : "muted");
    pen.lineWidth = 1;
    pen.setLineDash([6, 3]);
    this.stroke([[LEFT, this.y(y)], [this.w - RIGHT, this.y(y)]]);
    pen.setLineDash([]);
    pen.textAlign = "left";
    pen.fillText(name, LEFT + 4, this.y(y) - 7);
  }

  rise({ t, level }) {
    const { pen } = this, x = this.x(t);
    pen.fillStyle = cssColor(level.toLowerCase());
    pen.beginPath();
    pen.moveTo(x, TOP + 11); pen.lineTo(x - 6, TOP); pen.lineTo(x + 6, TOP);
    pen.fill();
  }

  legend() {
    const { pen } = this;
    pen.textAlign = "left";
    let x = LEFT;
    for (const { name, color } of this.plot.lines) {
      pen.fillStyle = cssColor("c" + color);
      pen.fillRect(x, 6, 12, 2);
      pen.fillStyle = cssColor("ink");
      pen.fillText(name, x + 16, 7);
      x += 30 + pen.measureText(name).width;
    }
  }
}

class ModeStrip extends Strip {
  draw(points) {
    this.begin();
    this.from = Math.max(points.end - SPAN, 0);
    const { pen } = this, shown = [];
    points.modes.forEach(([t, mode], i) => {
      const end = i + 1 < points.modes.length ? points.modes[i + 1][0] : points.end;
      if (end < this.from) return;
      const x = this.x(Math.max(t, this.from));
      pen.fillStyle = cssColor(mode) || cssColor("muted");
      pen.fillRect(x, TOP, Math.max(this.x(end) - x, 0.5), this.h - TOP);
      if (!shown.includes(mode)) shown.push(mode);
    });
    for (const [from, to] of points.gaps()) {
      const x = this.x(Math.max(from, this.from));
      if (to > this.from) pen.clearRect(x, TOP, this.x(to) - x, this.h - TOP);
    }
    pen.textAlign = "left";
    let x = LEFT;
    for (const mode of shown) {
      pen.fillStyle = cssColor(mode) || cssColor("muted");
      pen.fillRect(x, 2, 10, 10);
      pen.fillStyle = cssColor("ink");
      pen.fillText(mode, x + 14, 7);
      x += 28 + pen.measureText(mode).width;
    }
  }
}
