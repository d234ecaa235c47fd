// Joins stream, drawing, strips and alarms; comes back by itself where the stream breaks off.
"use strict";

const SAID = {
  open: "No contact", three_point: "Three-point contact",
  two_point: "Two-point contact: the peg is in the hole", unknown: "Contact not known",
  elsewhere: "Contact beside the hole, as with a plate",
  inserted: "Inserted: in the hole as deep as is stated",
};
const RECONNECT_MS = 1000;

class LiveDrawing extends Drawing {
  constructor(settings) {
    super({ moving: {}, scene: settings.scene, greatest_force: Math.min(...settings.max_normal) / 2 });
    this.latest = null;
  }

  moment() { return this.latest; }
}

function plotsOf(settings) {
  const limit = Math.min(...settings.max_normal);
  return {
    tilt: {
      lines: [{ column: "gamma", name: "gamma", color: 0, scale: 1e3 }],
      levels: [{ y: 1e3 * settings.gamma0, name: "gamma0" }], least: 1.5e3 * settings.gamma0,
    },
    reactions: {
      lines: CONTACTS.map((name, color) => ({ column: name, name: `N_${name}`, color })),
      levels: [{ y: limit, name: "limit", strong: true }], least: 1,
    },
    risk: {
      lines: [
        { column: "jamming_risk", name: "risk", color: 1 },
        { column: "transition_probability", name: "transition", color: 0 },
      ],
      levels: [
        { y: settings.jamming_warn, name: "WARN" },
        { y: settings.jamming_error, name: "ERROR", strong: true },
      ],
      range: [0, 1.1], rises: true,
    },
  };
}

class Page {
  constructor() {
    this.status = document.querySelector("#status");
    this.lead = document.querySelector("#said");
    this.points = new Points(1);
    this.mode = null;
    this.alarms = [];
    this.raised = [];
    this.causes = [];
    this.waiting = false;
    for (const query of ["(prefers-color-scheme: dark)", "print"]) {
      matchMedia(query).addEventListener("change", () => this.later());
    }
    addEventListener("resize", () => this.later());
    this.connect();
  }

  connect() {
    const stream = new WebSocket(`ws://${location.host}/stream`);
    stream.onmessage = (event) => this.take(JSON.parse(event.data));
    stream.onclose = () => {
      this.tell("peg-on-hole watch does not answer: has it ended? This page goes on trying.");
      setTimeout(() => this.connect(), RECONNECT_MS);
    };
  }

  take(message) {
    if (message.frames) {
      this.points = new Points(this.points.silence);
      this.mode = null;
      this.settle(message.settings);
      message.frames.forEach((frame) => this.add(frame));
      document.documentElement.dataset.ready = "yes";
    } else {
      if (message.settings) this.settle(message.settings);
      this.add(message);
      this.tell(message.status);
    }
    this.later();
  }

  settle(settings) {
    const plots = plotsOf(settings), latest = this.drawing ? this.drawing.latest : null;
    this.drawing = new LiveDrawing(settings);
    this.drawing.latest = latest;
    this.points.silence = settings.silence;
    this.strips = [...document.querySelectorAll("canvas.strip")].map((canvas) => {
      const name = canvas.dataset.strip;
      return name === "modes" ? new ModeStrip(canvas) : new Strip(canvas, plots[name]);
    });
  }

  add(frame) {
    if (frame.anew) this.points = new Points(this.points.silence);
    this.points.add(frame);
    if (frame.modes) this.mode = frame.modes[frame.modes.length - 1][1];
    if (frame.moment) this.drawing.latest = frame.moment;
    if (frame.alarms) this.showAlarms(frame.alarms);
    if (frame.causes) this.causes = frame.causes;
    if (frame.alarms || frame.causes) this.showBanners();
  }

  showAlarms(alarms) {
    const on = alarms.filter((alarm) => alarm.level !== "OK");
    const text = JSON.stringify(on);
    if (text === this.shownAlarms) return;
    this.shownAlarms = text;
    this.raised = on;
    this.alarms = on.map((alarm) => `${alarm.name} ${alarm.level}`);
    const list = document.querySelector("#alarmlist");
    list.replaceChildren(...(on.length ? on : [null]).map((alarm) => {
      const item = document.createElement("li");
      item.textContent = alarm ? `${alarm.name} ${alarm.level}: ${alarm.said}` : "none";
      return item;
    }));
  }

  // What is wrong stands above the drawing: alarms first, errors before warnings.
  showBanners() {
    const text = JSON.stringify([this.raised, this.causes]);
    if (text === this.shownBanners) return;
    this.shownBanners = text;
    const graver = (a, b) => (b.level === "ERROR") - (a.level === "ERROR");
    const banner = ({ level, kind, headline, lines }) => {
      const div = document.createElement("div");
      div.className = `banner ${kind} ${level.toLowerCase()}`;
      for (const [i, line] of [headline, ...lines].entries()) {
        const p = document.createElement("p");
        if (i === 0) p.className = "headline";
        p.textContent = line;
        div.append(p);
      }
      return div;
    };
    const alarms = [...this.raised].sort(graver).map(({ name, level, said }) => ({
      level, kind: "alarm", headline: `${level}: ${name.replaceAll("_", " ")}`, lines: [said],
    }));
    const causes = [...this.causes].sort(graver).map((cause) => ({
      ...cause, kind: "cause", headline: `${cause.about === "filter" && cause.lines.length ? "Suspected" : cause.about}: ${cause.headline}`,
    }));
    document.querySelector("#banners").replaceChildren(...[...alarms, ...causes].map(banner));
  }

  tell(status) {
    this.status.hidden = !status;
    if (this.status.textContent !== status) this.status.textContent = status || "";
  }

  // However fast frames come, it is drawn once for each of the screen's.
  later() {
    if (this.waiting || !this.strips) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const { latest } = this.drawing;
    for (const strip of this.strips) strip.draw(this.points);
    this.lead.textContent = latest ? SAID[this.mode] || "Contact not declared yet" : "No estimate yet";
    if (!latest) return;
    const at = this.drawing.show(0, this.mode);
    showReadings(at, this.points.end, this.alarms);
  }
}

new Page();
