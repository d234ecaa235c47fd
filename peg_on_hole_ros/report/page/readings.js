// The numbers beside the drawing.
"use strict";

// To so many digits, without a power of ten.
function number(value, digits = 3) {
  if (value === null || value === undefined) return "not determined";
  if (value === 0) return "0";
  const places = digits - 1 - Math.floor(Math.log10(Math.abs(value)));
  const text = places >= 0 ? value.toFixed(Math.min(places, 20)) : String(Math.round(value * 10 ** places) / 10 ** places);
  const short = text.includes(".") ? text.replace(/\.?0+$/, "") : text;
  return short === "-0" ? "0" : short;
}

function showReadings(at, time, alarms) {
  const put = (name, text) => { document.querySelector(`[data-reading="${name}"]`).textContent = text; };
  put("t", `${time.toFixed(3)} s`);
  put("mode", at.mode === "" ? "no estimate" : at.mode || "–");
  put("gamma", at.gamma === null ? number(null) : `${number(1e3 * at.gamma, 4)} mrad`);
  for (const name of ["psi", "phi"]) {
    const known = at[name] !== null && at[name + "_stddev"] !== null;
    put(name, known ? `${number(at[name])} rad` : "not determined");
  }
  for (const name of CONTACTS) {
    const known = at[name] !== null, bound = 1.96 * at[name + "_stddev"];
    const silent = at.mode === "open" ? "no contact" : "not determined";
    put(name, known ? `${number(at[name])} ± ${number(bound, 2)} N` : silent);
  }
  put("friction", number(at.friction));
  put("risk", number(at.jamming_risk, 2));
  put("alarms", alarms.join(", ") || "none");
}
