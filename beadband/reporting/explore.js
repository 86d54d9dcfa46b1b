"use strict";
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);

// ---- laws: nominal stress, tangent and energy over the stretch, Pa
const excess = (s) => (s - 1) ** 2 * (s + 2) / s;
const excessSlope = (s) => 2 * (s - 1 / s ** 2);
const excessCurve = (s) => 2 + 4 / s ** 3;
const LAWS = {
  "linear": (c) => ({
    energy: (s) => 0.5 * c.modulus_pa * (s - 1) ** 2, stress: (s) => c.modulus_pa * (s - 1), tangent: () => c.modulus_pa,
  }),
  "neo-hookean": (c) => ({
    energy: (s) => 0.5 * c.mu_pa * excess(s), stress: (s) => 0.5 * c.mu_pa * excessSlope(s),
    tangent: (s) => 0.5 * c.mu_pa * excessCurve(s),
  }),
  "mooney-rivlin": (c) => ({
    energy: (s) => c.c10_pa * excess(s) + c.c01_pa * (s - 1) ** 2 * (2 * s + 1) / s ** 2,
    stress: (s) => 2 * (s - 1 / s ** 2) * (c.c10_pa + c.c01_pa / s),
    tangent: (s) => 2 * (c.c10_pa * (1 + 2 / s ** 3) + 3 * c.c01_pa / s ** 4),
  }),
  "yeoh": (c) => ({
    energy: (s) => { const i = excess(s); return i * (c.c1_pa + i * (c.c2_pa + i * c.c3_pa)); },
    stress: (s) => { const i = excess(s); return excessSlope(s) * (c.c1_pa + i * (2 * c.c2_pa + 3 * i * c.c3_pa)); },
    tangent: (s) => {
      const i = excess(s);
      return excessCurve(s) * (c.c1_pa + i * (2 * c.c2_pa + 3 * i * c.c3_pa))
        + excessSlope(s) ** 2 * (2 * c.c2_pa + 6 * i * c.c3_pa);
    },
  }),
  "gent": (c) => {
    const room = (s) => 1 - excess(s) / c.jm;
    return {
      energy: (s) => -0.5 * c.mu_pa * c.jm * Math.log1p(-excess(s) / c.jm),
      stress: (s) => 0.5 * c.mu_pa * excessSlope(s) / room(s),
      tangent: (s) => 0.5 * c.mu_pa / room(s) * (excessCurve(s) + excessSlope(s) ** 2 / room(s) / c.jm),
      longest: root((s) => excess(s) - c.jm, 1, 2 + Math.sqrt(c.jm)),
    };
  },
};

// Bisection: slow, sure, and to the last digit.
function root(f, low, high) {
  const sign = Math.sign(f(low));
  for (let i = 0; i < 200; i++) {
    const middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    if (Math.sign(f(middle)) === sign) low = middle; else high = middle;
  }
  return 0.5 * (low + high);
}

// Where the tension first stops to rise; Infinity if it rises up to a stretch of 12, or up to where the law locks.
function peak(law) {
  const end = Math.min(12, law.longest ?? 12);
  let before = 1;
  for (let s = 1; s < end; s += 0.01) {
    if (law.tangent(s) <= 0) return s === 1 ? 1 : root(law.tangent, before, s);
    before = s;
  }
  return Infinity;
}

// ---- the unloading wave: along the lower convex envelope of the stress between the two stretches
function wave(law, ahead, behind, density) {
  const N = 256, s = [], y = [];
  for (let i = 0; i <= N; i++) { s.push(behind + (ahead - behind) * i / N); y.push(law.stress(s[i])); }
  s[N] = ahead; y[N] = law.stress(ahead);
  const rise = y[N] - y[0], slope = rise / (ahead - behind), slack = 1e-13 * Math.abs(y[N]);
  const touch = Math.max(1e-9, slack / Math.abs(rise)) * Math.abs(slope);
  let above = true;
  for (let i = 1; i < N; i++) if (y[i] < y[0] + slope * (s[i] - behind) - slack) above = false;
  if (above && law.tangent(ahead) <= slope + touch && law.tangent(behind) >= slope - touch) {
    const front = Math.sqrt(Math.max(slope, 0) / density);
    return {particle: front * (ahead - behind), front, single: true};
  }
  const hull = [];
  for (let i = 0; i <= N; i++) {
    const turn = (a, b) => (s[b] - s[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (s[i] - s[a]);
    while (hull.length > 1 && turn(hull[hull.length - 2], hull[hull.length - 1]) <= 1e-13 * Math.abs(y[N]) * (ahead - behind)) hull.pop();
    hull.push(i);
  }
  const cell = (ahead - behind) / N, pieces = [];
  let below = behind;
  for (let k = 0; k + 1 < hull.length; k++) {
    if (hull[k + 1] === hull[k] + 1) continue;
    let [low, high] = touching(law, s[hull[k]], s[hull[k + 1]], behind, ahead, cell);
    low = Math.max(low, below);
    if (low > below) pieces.push(["fan", below, low]);
    if (high > low) { pieces.push(["shock", low, high]); below = high; }
  }
  if (ahead > below) pieces.push(["fan", below, ahead]);
  let particle = 0, front = 0;
  for (const [kind, low, high] of pieces) {
    if (kind === "fan") {
      particle += fan(law, low, high) / Math.sqrt(density);
      front = Math.sqrt(Math.max(law.tangent(high), 0) / density);
    } else {
      front = Math.sqrt(Math.max((law.stress(high) - law.stress(low)) / (high - low), 0) / density);
      particle += front * (high - low);
    }
  }
  return {particle, front, single: pieces.length === 1 && pieces[0][0] === "shock"};
}
function touching(law, low, high, behind, ahead, cell) {
  const crossing = (f, guess, a, b, end) => {
    if (!(a < b)) return guess;
    const fa = f(a), fb = f(b);
    if (fa < 0 && fb > 0) return root(f, a, b);
    return (end === b && fb <= 0) || (end === a && fa >= 0) ? end : guess;
  };
  for (let i = 0; i < 20; i++) {
    const before = [low, high];
    const top = (x) => law.tangent(x) * (x - low) - (law.stress(x) - law.stress(low));
    high = crossing(top, high, Math.max(high - 2 * cell, low + 0.5 * cell), Math.min(high + 2 * cell, ahead), ahead);
    const bottom = (x) => law.tangent(x) * (high - x) - (law.stress(high) - law.stress(x));
    low = crossing(bottom, low, Math.max(low - 2 * cell, behind), Math.min(low + 2 * cell, high - 0.5 * cell), behind);
    if (Math.abs(low - before[0]) + Math.abs(high - before[1]) <= 1e-14 * high) break;
  }
  return [low, high];
}
// Integral of sqrt(tangent): Gauss's rule of five points on 64 panels.
const GAUSS = [[0, 128 / 225], ...[1, -1].flatMap((sign) => [[5 - 2 * Math.sqrt(10 / 7), 322 + 13 * Math.sqrt(70)],
  [5 + 2 * Math.sqrt(10 / 7), 322 - 13 * Math.sqrt(70)]].map(([x, w]) => [sign * Math.sqrt(x) / 3, w / 900]))];
function fan(law, low, high) {
  const panels = 64, half = 0.5 * (high - low) / panels;
  let sum = 0;
  for (let i = 0; i < panels; i++) {
    const middle = low + (2 * i + 1) * half;
    for (const [x, w] of GAUSS) sum += w * Math.sqrt(Math.max(law.tangent(middle + half * x), 0));
  }
  return sum * half;
}

// ---- the string limit: u sin(phi) = k (1 - sin(phi)), k = sqrt(stress1 stretch1/density)
function stringLimit(law, density, strain, phi) {
  const sine = Math.sin(phi), held = 1 + strain, heldStress = law.stress(held);
  const surplus = (behind, u) => u * sine - Math.sqrt(Math.max(law.stress(behind), 0) * behind / density) * (1 - sine);
  let behind = root((b) => surplus(b, Math.sqrt(Math.max((heldStress - law.stress(b)) * (held - b), 0) / density)), 1, held);
  let found = wave(law, held, behind, density);
  if (!found.single) {
    behind = root((b) => surplus(b, wave(law, held, b, density).particle), 1, held);
    found = wave(law, held, behind, density);
  }
  const V = found.particle * Math.cos(phi) / (1 - sine);
  const mean = found.single ? 1 : found.particle / (found.front * (held - behind));
  return {V, front: found.front, single: found.single, strain: behind - 1, stress: law.stress(behind), mean};
}

// ---- the correction: mean of small networks, with a bar and a region
function network(layers, inputs) {
  let state = inputs;
  layers.forEach(({matrix, bias}, k) => {
    const next = bias.slice();
    for (let i = 0; i < state.length; i++) for (let j = 0; j < next.length; j++) next[j] += state[i] * matrix[i][j];
    state = k + 1 < layers.length ? next.map(Math.tanh) : next;
  });
  return state[0];
}
function evaluated(map, numbers) {
  const given = map.columns.map((name) => numbers[name]);
  const inputs = given.map((value, i) => (value - map.origin[i]) / map.scatter[i]);
  const all = map.networks.map((layers) => network(layers, inputs));
  const mean = all.reduce((a, b) => a + b) / all.length;
  const parting = map.size * Math.sqrt(all.reduce((sum, one) => sum + (one - mean) ** 2, 0) / (all.length - 1));
  const terms = [1, Math.log(Math.hypot(parting, map.least_scatter)), ...inputs];
  const bar = Math.exp(terms.reduce((sum, term, i) => sum + term * map.bar[i], 0));
  const boxed = given.every((value, i) => value >= map.low[i] && value <= map.high[i]);
  let distance = 0;
  for (let i = 0; i < inputs.length; i++) for (let j = 0; j < inputs.length; j++) distance += inputs[i] * map.covariance_inverse[i][j] * inputs[j];
  return {value: map.mean + map.size * mean, bar, inside: boxed && distance <= map.farthest ** 2 && parting <= map.widest};
}
function corrected(map, n) {
  const fall = (Math.exp(n.ln_strain) - Math.exp(n.ln_residual_strain)) * Math.exp(n.ln_mean_speed);
  const rear = fall * Math.cos(n.half_angle_rad) / (1 - Math.sin(n.half_angle_rad)), bending = Math.exp(n.ln_spread);
  const share = bending / (bending + rear);
  const short = Math.max(map.low[map.columns.indexOf("ln_spread")] - n.ln_spread, 0);
  const found = evaluated(map, {...n, ln_spread: n.ln_spread + short, ln_crossover: n.ln_crossover + 2 * short});
  const value = share * found.value, bar = share * (found.bar + (short > 0 ? Math.abs(found.value) : 0));
  const stress = Math.exp(n.ln_strain + n.ln_secant);
  const layer = Math.exp(2 * n.ln_spread) / Math.sqrt(stress * (1 + Math.exp(n.ln_strain)));
  return {delta: value, error: Math.hypot(bar / (1 + value), map.floor), inside: found.inside && layer <= data.longest_layer};
}

// ---- a scene
function answer(s) {
  const law = LAWS[s.law](s.constants), phi = s.half_angle_deg * Math.PI / 180, held = 1 + s.strain;
  const refuse = (why) => ({refused: why});
  const numbers = [s.strain, s.half_angle_deg, s.circumference_m, s.thickness_m, s.density_kg_m3, s.modulus_pa, ...Object.values(s.constants)];
  if (!numbers.every(Number.isFinite)) return refuse("Every field needs a number.");
  if (!(law.tangent(1) > 0)) return refuse("The law has no stiffness at rest.");
  if (law.longest !== undefined && held >= law.longest) return refuse(`The law locks at a strain of ${short(law.longest - 1)}.`);
  const top = peak(law);
  if (held >= top) return refuse(`The tension peaks at a strain of ${short(top - 1)}: beyond it the band necks.`);
  if (held * Math.sin(phi) >= 1) return refuse("The wedge is too wide: (1 + strain) sin(half-angle) must stay below 1.");
  const h = s.thickness_m, round = s.section === "circle";
  const area = round ? Math.PI / 4 * h * h : s.width_m * h;
  const second = round ? Math.PI / 64 * h ** 4 : s.width_m * h ** 3 / 12;
  const slope = Math.tan(phi), leg = held * s.circumference_m / (2 + slope * (Math.PI + 2 * phi)), l0 = leg / held;
  const radius = leg * slope;
  if (radius <= 0.5 * h / Math.sqrt(held) || l0 <= h) return refuse("The band is too thick for this wedge.");
  const string = stringLimit(law, s.density_kg_m3, s.strain, phi);
  const ab = Math.sqrt(s.modulus_pa * second / (s.density_kg_m3 * area)), tf = l0 / string.front;
  const inertia = s.density_kg_m3 * string.front ** 2, behind = 1 + string.strain, stress = law.stress(held);
  const n = {
    ln_strain: Math.log(s.strain), half_angle_rad: phi, ln_spread: Math.log(Math.sqrt(ab * tf) / l0),
    ln_residual_strain: Math.log(string.strain), ln_secant: Math.log(stress / (inertia * s.strain)),
    ln_crossover: Math.log(ab * s.density_kg_m3 * behind / string.stress / tf),
    ln_stiffness_behind: Math.log(law.tangent(behind) / inertia), stiffness_ahead: law.tangent(held) / inertia,
    ln_mean_speed: Math.log(string.mean),
  };
  const c = corrected(data.map, n);
  const speeds = {
    bar: Math.sqrt(s.modulus_pa / s.density_kg_m3), rest: Math.sqrt(s.rest_modulus_pa / s.density_kg_m3),
    front: held * string.front * Math.cos(phi),
  };
  const V = c.inside ? string.V * (1 + c.delta) : string.V;
  const free = tf + (0.5 * s.circumference_m - l0) / string.front, arrives = (leg / Math.cos(phi) - radius) / string.V;
  return {
    value: V, error: c.inside ? c.error * V : null, inside: c.inside, string: string.V, speeds,
    published: s.strain / held / (1 - Math.sin(phi)), tf, leg, radius, stored: area * s.circumference_m * law.energy(held),
    tension: area * stress, pause: string.single && Math.sin(phi) < 0.5 ? arrives - free : null,
  };
}

// ---- the page
const short = (v, digits = 4) => (v === 0 ? "0" : String(Number(v.toPrecision(digits))).replace("-", "−"));
const controls = {};
function control(parent, key, label, unit, scale, low, high, slide) {
  const box = document.createElement("label"), number = document.createElement("input");
  number.type = "number"; number.step = "any"; number.id = `n-${key}`;
  box.append(`${label}${unit ? ` (${unit})` : ""}`, number);
  const entry = {scale, get: () => Number.parseFloat(number.value) / scale,
    set: (v) => { number.value = Number((v * scale).toPrecision(9)); if (entry.range) entry.range.value = number.value; }};
  if (slide) {
    entry.range = document.createElement("input");
    Object.assign(entry.range, {type: "range", min: low, max: high, step: (high - low) / 1000});
    entry.range.setAttribute("aria-label", label);
    entry.range.addEventListener("input", () => { number.value = Number(Number(entry.range.value).toPrecision(6)); update(); });
    box.append(entry.range);
  }
  number.addEventListener("input", () => { if (entry.range) entry.range.value = number.value; update(); });
  parent.append(box);
  controls[key] = entry;
}
const state = {band: data.default, law: data.bands[data.default].law};
function state_now() {
  const band = data.bands[state.band], constants = {};
  for (const one of data.laws[state.law]) constants[one.key] = controls[one.key].get();
  const own = (key) => controls[key] ? controls[key].get() : band[key];
  return {law: state.law, constants, section: band.section, strain: own("strain"), half_angle_deg: own("half_angle_deg"),
    circumference_m: own("circumference_m"), width_m: own("width_m"), thickness_m: own("thickness_m"),
    density_kg_m3: own("density_kg_m3"), modulus_pa: state.law === "linear" ? constants.modulus_pa : own("modulus_pa"),
    rest_modulus_pa: rest(band, constants)};
}
// E0 of the catalogue's band is that of its own law, whatever law is chosen for the release.
function rest(band, constants) {
  const own = state.law === "linear" ? {law: band.law, c: band.constants} : {law: state.law, c: constants};
  return LAWS[own.law](own.c).tangent(1);
}
function build() {
  const band = data.bands[state.band];
  for (const id of ["constants", "sizes"]) for (const child of [...at(id).querySelectorAll("label")]) child.remove();
  for (const key of Object.keys(controls)) if (!["strain", "half_angle_deg"].includes(key)) delete controls[key];
  for (const one of data.laws[state.law]) {
    const mega = one.unit === "Pa";
    control(at("constants"), one.key, one.label, mega ? "MPa" : "", mega ? 1e-6 : 1);
    controls[one.key].set(band.constants[one.key] ?? (one.key === "modulus_pa" ? band.modulus_pa : one.start));
  }
  control(at("sizes"), "circumference_m", "circumference", "mm", 1e3);
  if (band.section === "rectangle") control(at("sizes"), "width_m", "width", "mm", 1e3);
  control(at("sizes"), "thickness_m", band.section === "circle" ? "diameter" : "thickness", "mm", 1e3);
  control(at("sizes"), "density_kg_m3", "density", "kg/m³", 1);
  if (state.law !== "linear") control(at("sizes"), "modulus_pa", "E of the table, for EI", "MPa", 1e-6);
  for (const key of ["circumference_m", "width_m", "thickness_m", "density_kg_m3", "modulus_pa"]) if (controls[key] && !(key === "modulus_pa" && state.law === "linear")) controls[key].set(band[key]);
}
function row(name, text) {
  const line = document.createElement("tr"), head = document.createElement("th"), cell = document.createElement("td");
  head.scope = "row"; head.textContent = name; cell.textContent = text; line.append(head, cell);
  return line;
}
function update() {
  const s = state_now(), a = answer(s);
  at("note").hidden = true;
  if (a.refused) {
    at("speed").textContent = "No answer";
    at("note").textContent = a.refused; at("note").hidden = false;
    at("numbers").replaceChildren(); at("shape").replaceChildren();
  } else {
    const digits = a.inside ? Math.max(0, 1 - Math.floor(Math.log10(a.error))) : 2;
    at("speed").textContent = a.inside ? `V = ${a.value.toFixed(digits)} ± ${a.error.toFixed(digits)} m/s` : `V of the string: ${short(a.string)} m/s`;
    if (!a.inside) {
      at("note").textContent = "The correction for bending is not known here: beadband makes a run instead. This is the limit without bending.";
      at("note").hidden = false;
    }
    const times = (v) => `${short(1e3 * v)} ms`;
    at("numbers").replaceChildren(
      row("string limit, without bending", `${short(a.string)} m/s`),
      row("V/C, C = √(E/ρ)", `${short(a.value / a.speeds.bar)}; α = ${short(a.value / a.speeds.bar / a.published)}`),
      row("V/C, C = √(E₀/ρ)", `${short(a.value / a.speeds.rest)}; α = ${short(a.value / a.speeds.rest / a.published)}`),
      row("V/C, C of the front", `${short(a.value / a.speeds.front)}; α = ${short(a.value / a.speeds.front / a.published)}`),
      row("front reaches the finger after", times(a.tf)),
      row("stored energy, without bending", `${short(1e3 * a.stored)} mJ`),
      row("tension of a leg", `${short(a.tension)} N`),
      row("radius of the finger", `${short(1e3 * a.radius)} mm`),
      row("is the hand hit? (without bending)", a.pause === null ? "not known in closed form" : a.pause > 0
        ? `free for ${times(a.pause)} before the rear arrives` : `yes: the rear comes ${times(-a.pause)} before the finger is free`));
    draw(s, a);
  }
  const hash = new URLSearchParams({band: state.band, law: state.law});
  for (const [key, one] of Object.entries(controls)) hash.set(key, String(one.get()));
  at("link").href = `#${hash}`;
  at("command").textContent = command(s);
}
function command(s) {
  const band = data.bands[state.band], parts = [`beadband ask --band ${state.band} --strain ${s.strain} --half-angle ${s.half_angle_deg}`];
  const changed = state.law !== band.law || Object.entries(s.constants).some(([key, v]) => v !== (band.constants[key] ?? band[key]));
  if (state.law !== band.law) parts.push(`--law ${state.law}`);
  if (changed) for (const one of data.laws[state.law]) if (s.constants[one.key] !== band[one.key]) parts.push(`${one.flag} ${s.constants[one.key]}`);
  for (const key of ["circumference_m", "width_m", "thickness_m", "density_kg_m3", "modulus_pa"]) {
    if (key === "modulus_pa" && state.law === "linear") continue;
    if (s[key] !== undefined && s[key] !== band[key]) parts.push(`${data.flags[key]} ${s[key]}`);
  }
  return parts.join(" ");
}
function draw(s, a) {
  const svg = at("shape"), space = svg.namespaceURI, phi = s.half_angle_deg * Math.PI / 180;
  const add = (name, attributes) => {
    const one = document.createElementNS(space, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    svg.append(one);
  };
  svg.replaceChildren();
  const centre = a.leg / Math.cos(phi), width = centre + a.radius, height = 2 * Math.max(a.radius, a.leg * Math.sin(phi));
  const scale = Math.min(740 / width, 320 / height), X = (x) => 30 + scale * x, Y = (y) => 180 - scale * y;
  const thick = Math.max(1.5, scale * s.thickness_m / Math.sqrt(1 + s.strain));
  add("circle", {cx: X(centre), cy: Y(0), r: scale * a.radius, fill: "var(--finger)"});
  const [tx, ty] = [a.leg * Math.cos(phi), a.leg * Math.sin(phi)], r = scale * a.radius;
  const arc = `A ${r} ${r} 0 1 1 ${X(tx)} ${Y(-ty)}`;
  add("path", {d: `M ${X(0)} ${Y(0)} L ${X(tx)} ${Y(ty)} ${arc} Z`, fill: "none", stroke: "var(--held)", "stroke-width": thick, "stroke-linejoin": "round"});
  const x = a.string * a.tf, y = Math.min(x, tx) * Math.tan(phi);
  add("path", {d: `M ${X(tx)} ${Y(-ty)} L ${X(x)} ${Y(-y)} L ${X(x)} ${Y(y)} L ${X(tx)} ${Y(ty)}`, fill: "none", stroke: "var(--moved)", "stroke-width": Math.max(1.5, scale * s.thickness_m), "stroke-dasharray": "7 5"});
}
function read(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  if (data.bands[given.get("band")]) state.band = given.get("band");
  state.law = data.laws[given.get("law")] ? given.get("law") : data.bands[state.band].law;
  at("band").value = state.band; at("law").value = state.law;
  build();
  for (const [key, one] of Object.entries(controls)) if (given.has(key) && Number.isFinite(Number(given.get(key)))) one.set(Number(given.get(key)));
  update();
}
for (const name of Object.keys(data.bands)) at("band").add(new Option(name));
for (const name of Object.keys(data.laws)) at("law").add(new Option(name));
control(at("pull"), "strain", "strain", "", 1, 0.02, 2, true);
control(at("pull"), "half_angle_deg", "half-angle", "degrees", 1, 2, 45, true);
const standard = () => { controls.strain.set(data.strain); controls.half_angle_deg.set(data.half_angle_deg); };
at("band").addEventListener("change", () => { state.band = at("band").value; state.law = data.bands[state.band].law; at("law").value = state.law; build(); update(); });
at("law").addEventListener("change", () => { state.law = at("law").value; build(); update(); });
at("reset").addEventListener("click", () => { state.law = data.bands[state.band].law; at("law").value = state.law; standard(); build(); update(); });
at("version").textContent = data.version;
addEventListener("hashchange", () => read(location.hash));
standard();
read(location.hash);
window.beadband = {answer};
})();
