// Reads the data of the page, then joins plots, drawing, slider and buttons at one time.
"use strict";

class PageController {
  constructor(model) {
    this.model = model;
    this.time = 0;
    this.playing = null;
    this.slider = document.querySelector("#time");
    this.drawing = model.moving ? new Drawing(model) : null;
    this.plots = new Plots(model, (t) => { if (!this.playing) this.setTime(t); });
    Object.assign(this.slider, { min: 0, max: model.end, step: "any" });
    this.slider.addEventListener("input", () => this.setTime(Number(this.slider.value)));
    document.querySelector("#play").addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    for (const [id, factor] of [["closer", 0.5], ["wider", 2]]) {
      document.getElementById(id).addEventListener("click", () => this.plots.zoom(factor));
    }
    document.querySelector("#all").addEventListener("click", () => this.plots.setRange(0, model.end));
    // Also where the address is that of now: it is asked for once more.
    for (const link of document.querySelectorAll("a.jump")) {
      link.addEventListener("click", () => this.follow(link.hash));
    }
    addEventListener("hashchange", () => this.follow(location.hash));
    for (const button of document.querySelectorAll("[data-get]")) {
      button.addEventListener("click", () => this.give(button.dataset));
    }
    this.followTheme();
    this.setTime(model.begin);
    this.follow(location.hash);
  }

  setTime(t) {
    this.time = Math.min(Math.max(t, 0), this.model.end);
    this.slider.value = this.time;
    this.plots.setTime(this.time);
    if (this.drawing) this.read(this.drawing.show(this.time, this.holding(this.model.modes[0].changes)));
  }

  // A time, or from when to when, as in #t=4.5 or #t=1.736,5.886.
  follow(hash) {
    const found = /^#t=(\d+(?:\.\d+)?)(?:,(\d+(?:\.\d+)?))?$/.exec(hash);
    if (found) this.jump(Number(found[1]), found[2] === undefined ? null : Number(found[2]));
  }

  // A plot's picture, or what it draws, as a file.
  give({ get, panel: name }) {
    const { panel, div } = this.plots.panels.find((each) => each.panel.name === name);
    const file = `${document.title.replace(/[^\w.-]+/g, "_")}_${name}`;
    if (get === "png") {
      Plotly.downloadImage(div, { format: "png", filename: file, width: 1200, height: 400, scale: 2 });
      return;
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([csvOf(this.model, panel)], { type: "text/csv" }));
    link.download = `${file}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  jump(from, end) {
    this.pause();
    this.plots.mark(from);
    const margin = end === null ? 0.05 * this.model.end : 0.05 * (end - from) + 0.01;
    const last = (end === null ? from : end) + margin;
    this.plots.setRange(Math.max(from - margin, 0), Math.min(last, this.model.end));
    this.setTime(from);
    document.querySelector("#plots").scrollIntoView({ behavior: "instant", block: "start" });
  }

  play() {
    if (this.time >= this.model.end) this.setTime(0);
    let before = null;
    const step = (now) => {
      const speed = Number(document.querySelector("#speed").value);
      if (before !== null) this.setTime(this.time + speed * (now - before) / 1000);
      before = now;
      if (this.time >= this.model.end) return this.pause();
      this.playing = requestAnimationFrame(step);
    };
    this.playing = requestAnimationFrame(step);
    document.querySelector("#play").textContent = "Pause";
  }

  pause() {
    if (this.playing) cancelAnimationFrame(this.playing);
    this.playing = null;
    document.querySelector("#play").textContent = "Play";
  }

  read(at) {
    const levels = new Map();
    for (const alarm of this.model.alarms) if (alarm.t <= this.time) levels.set(alarm.name, alarm.level);
    const on = [...levels].filter(([, level]) => level !== "OK").map((pair) => pair.join(" "));
    showReadings(at, this.time, on);
  }

  holding(changes) {
    let held = null;
    for (const [t, name] of changes) if (t <= this.time) held = name;
    return held;
  }

  // Colours are part of each plot: they follow the theme, and paper is light.
  followTheme() {
    for (const query of ["(prefers-color-scheme: dark)", "print"]) {
      matchMedia(query).addEventListener("change", () => this.plots.draw());
    }
    addEventListener("beforeprint", () => {
      for (const { div } of this.plots.panels) Plotly.relayout(div, { width: 690 });
    });
    addEventListener("afterprint", () => {
      for (const { div } of this.plots.panels) Plotly.relayout(div, { width: null, autosize: true });
    });
  }
}

async function start() {
  const waiting = document.querySelector(".waiting");
  try {
    runScript(await unpacked("library"));
    const desk = new PageController(JSON.parse(await unpacked("data")));
    document.documentElement.dataset.ready = "yes";
    waiting.remove();
    return desk;
  } catch (error) {
    waiting.className = "failed";
    waiting.textContent = `The plots cannot be drawn (${error.message}): open the page in a browser of 2023 or later.`;
    throw error;
  }
}

start();
