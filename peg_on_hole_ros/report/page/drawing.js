// The peg on the rim from the side and from above, at one moment; 100 units are a hole's diameter.
"use strict";

const SVG = "http://www.w3.org/2000/svg";
const CONTACTS = ["K", "B1", "B2"];
// Angles alone do not tell where a peg is that does not lie on the rim.
const WHERE = {
  open: "no contact: place not known", two_point: "in the hole: depth not known", unknown: "contact not known",
  elsewhere: "on something beside the hole: place not known", inserted: "in the hole, as deep as is stated",
};
const CONE = 26, LONGEST = 55;

function element(parent, kind, attributes, text) {
  const made = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text) made.textContent = text;
  parent.append(made);
  return made;
}

function pointsText(points) {
  return points.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
}

// Convex hull, Andrew's monotone chain.
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

function circle(center, along, across, radius, count = 24) {
  return Array.from({ length: count }, (_, i) => {
    const c = radius * Math.cos(2 * Math.PI * i / count), s = radius * Math.sin(2 * Math.PI * i / count);
    return center.map((x, k) => x + c * along[k] + s * across[k]);
  });
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(v) {
  const length = Math.hypot(...v);
  return v.map((x) => x / length);
}

class Drawing {
  constructor(model) {
    this.columns = model.moving;
    this.scale = 100 / model.scene.hole_diameter;
    this.scene = model.scene;
    this.friction = model.scene.friction;
    this.newton = LONGEST / Math.max(model.greatest_force, 1e-9);
    this.side = document.querySelector("#side");
    this.top = document.querySelector("#top");
    const H = model.scene.peg_height * this.scale;
    this.side.setAttribute("viewBox", `-105 ${-(H + 45)} 210 ${H + 85}`);
    this.top.setAttribute("viewBox", "-105 -85 210 170");
  }

  // Row of the moment that holds at a time.
  row(t) {
    const times = this.columns.t;
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  moment(t) {
    const i = this.row(t), at = {};
    for (const [name, column] of Object.entries(this.columns)) at[name] = column[i];
    return at;
  }

  show(t, mode) {
    const at = { ...this.moment(t), mode };
    this.drawSide(at);
    this.drawTop(at);
    return at;
  }

  // Contact points and normals in the axes of the tilt (h, e, z), by the rim's geometry.
  contacts(at) {
    const R = 50, k = this.scale, found = [];
    const rests = at.S1 !== null;
    const edge = [
      at.p_h * k + this.scene.peg_diameter / 2 * k * Math.cos(at.gamma), 0,
      at.p_z * k + this.scene.peg_diameter / 2 * k * Math.sin(at.gamma),
    ];
    for (const name of CONTACTS) {
      const sign = name === "B1" ? -1 : 1;
      const point = name === "K" ? [-R, 0, 0] : rests ? [at.S1 * k, sign * at.b * k, 0] : edge;
      const normal = !rests ? null : name === "K"
        ? [Math.cos(at.gamma), 0, Math.sin(at.gamma)]
        : unit([-at.S1, -sign * at.b, at.a1]);
      const force = ["h", "e", "z"].map((axis) => at[`${axis}_${name}`]);
      found.push({ name, point, normal, closed: at[`${name}_closed`] > 0.5, force: force[0] === null ? null : force });
    }
    return found;
  }

  // Height of the peg's lowest point above the rim.
  height(at) {
    return at.p_z - this.scene.peg_diameter / 2 * Math.sin(at.gamma);
  }

  // How far the peg is drawn from where it is, so that one far above stays in view.
  lift(at) {
    return Math.max(0, this.height(at) * this.scale - 20);
  }

  touches(at) {
    return CONTACTS.some((name) => at[`${name}_closed`] > 0.5);
  }

  pegClass(at) {
    return this.touches(at) ? "peg" : "peg free";
  }

  drawSide(at) {
    const svg = this.side, k = this.scale, s = Math.sin(at.gamma), c = Math.cos(at.gamma);
    svg.replaceChildren();
    element(svg, "rect", { class: "block", x: -105, y: 0, width: 55, height: 60 });
    element(svg, "rect", { class: "block", x: 50, y: 0, width: 55, height: 60 });
    element(svg, "path", { class: "edge", d: "M-105,0 H-50 V60 M105,0 H50 V60" });
    element(svg, "path", { class: "axis", d: "M0,60 V-60" });
    if (at.p_h === null) return;
    const d = this.scene.peg_diameter * k / 2, H = this.scene.peg_height * k, lift = this.lift(at);
    const corner = (side, up) => [
      at.p_h * k + side * d * c - up * H * s, -(at.p_z * k - lift + side * d * s + up * H * c),
    ];
    const outline = [corner(-1, 0), corner(1, 0), corner(1, 1), corner(-1, 1)];
    element(svg, "polygon", { class: this.pegClass(at), points: pointsText(outline) });
    element(svg, "polyline", { class: "axis", points: pointsText([corner(0, 0), corner(0, 1)]) });
    const high = this.height(at) > 1e-3;
    const said = high ? `${(1e3 * this.height(at)).toFixed(1)} mm above the rim` : this.touches(at) ? "" : WHERE[at.mode];
    if (said) element(svg, "text", { class: "label", x: 0, y: 16, "text-anchor": "middle" }, said);
    if (lift > 0) return;
    this.drawContacts(svg, at, ([h, , z]) => [h, -z], { K: [-12, 12], B1: [6, 12], B2: null });
  }

  drawTop(at) {
    const svg = this.top, k = this.scale, c = Math.cos(at.psi), s = Math.sin(at.psi);
    svg.replaceChildren();
    const project = ([h, e]) => [c * h - s * e, -(s * h + c * e)];
    element(svg, "circle", { class: "edge", cx: 0, cy: 0, r: 50 });
    element(svg, "path", { class: "axis", d: "M-100,0 H100 M0,-80 V80" });
    element(svg, "text", { class: "label", x: 97, y: -4, "text-anchor": "end" }, "x");
    element(svg, "text", { class: "label", x: 4, y: -74 }, "y");
    if (at.p_h === null) return;
    const d = this.scene.peg_diameter * k / 2, H = this.scene.peg_height * k;
    const lower = [at.p_h * k, 0, 0], across = [Math.cos(at.gamma), 0, 0];
    const upper = [lower[0] - H * Math.sin(at.gamma), 0, 0];
    const disc = (center) => circle(center, across, [0, 1, 0], d, 48).map(project);
    element(svg, "polygon", { class: this.pegClass(at), points: pointsText(hull([...disc(lower), ...disc(upper)])) });
    element(svg, "polygon", { class: "mark", points: pointsText(disc(upper)) });
    const turn = [lower[0] + d * Math.cos(at.phi) * Math.cos(at.gamma), d * Math.sin(at.phi), 0];
    element(svg, "polyline", { class: "mark", points: pointsText([project(lower), project(turn)]) });
    if (this.lift(at) === 0) this.drawContacts(svg, at, project, { K: [4, 10], B1: [5, 10], B2: [5, -5] });
  }

  drawContacts(svg, at, project, labels) {
    const friction = at.friction === null ? this.friction : at.friction;
    for (const { name, point, normal, closed, force } of this.contacts(at)) {
      const [x, y] = project(point);
      if (closed && normal) this.drawCone(svg, point, normal, friction, project);
      if (closed && force) this.drawForce(svg, point, force, project);
      const kind = closed ? "dot" : "dot open";
      if (closed || (normal && this.touches(at))) element(svg, "circle", { class: kind, cx: x, cy: y, r: 2.6 });
      const place = labels[name], both = labels.B2 === null && name === "B1";
      if (place && closed) {
        element(svg, "text", { class: "label", x: x + place[0], y: y + place[1] }, both ? "B1, B2" : name);
      }
    }
  }

  drawCone(svg, apex, normal, friction, project) {
    const side = unit(cross(normal, Math.abs(normal[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]));
    const base = apex.map((x, i) => x + CONE * normal[i]);
    const mantle = circle(base, side, cross(normal, side), CONE * friction);
    element(svg, "polygon", { class: "cone", points: pointsText(hull([apex, ...mantle].map(project))) });
  }

  drawForce(svg, point, force, project) {
    const [x, y] = project(point), [u, v] = project(point.map((p, i) => p + this.newton * force[i]));
    const length = Math.hypot(u - x, v - y);
    if (length < 1.5) return;
    const [a, b] = [(u - x) / length, (v - y) / length], head = Math.min(7, length);
    const root = [u - head * a, v - head * b];
    element(svg, "line", { class: "force", x1: x, y1: y, x2: root[0], y2: root[1] });
    const wings = [[u, v], [root[0] - 3 * b, root[1] + 3 * a], [root[0] + 3 * b, root[1] - 3 * a]];
    element(svg, "polygon", { class: "head", points: pointsText(wings) });
  }
}
