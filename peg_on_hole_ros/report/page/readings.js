// The numbers beside the drawing.
"use strict";

function number(value, digits = 4) {
  return value === null || value === undefined ? "–" : Number(value.toPrecision(digits)).toString();
}

function showReadings(at, time, alarms) {
  const put = (name, text) => { document.querySelector(`[data-reading="${name}"]`).textContent = text; };
  put("t", `${time.toFixed(3)} s`);
  put("mode", at.mode || "–");
  put("gamma", `${number(1e3 * at.gamma)} mrad`);
  put("psi", `${number(at.psi)} rad`);
  put("phi", `${number(at.phi)} rad`);
  for (const name of CONTACTS) {
    const known = at[name] !== null, bound = 1.96 * at[name + "_stddev"];
    const silent = at.mode === "open" ? "no contact" : "not determined";
    put(name, known ? `${number(at[name], 3)} ± ${number(bound, 2)} N` : silent);
  }
  put("friction", number(at.friction, 3));
  put("risk", number(at.jamming_risk, 2));
  put("alarms", alarms.join(", ") || "none");
}
