"use strict";
(() => {
const story = JSON.parse(document.getElementById("story").textContent);
const at = (id) => document.getElementById(id);
const svgSpace = at("scale").namespaceURI;

// Elements; words from the run are set as text, never as markup.
function make(name, attributes = {}, ...inside) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...inside);
  return element;
}
function draw(parent, name, attributes, text) {
  const element = document.createElementNS(svgSpace, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}
function unpack(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Uint16Array(bytes.buffer);
}
function keyBox() {
  const key = document.createElementNS(svgSpace, "svg");
  key.setAttribute("viewBox", "0 0 22 10");
  key.setAttribute("aria-hidden", "true");
  return key;
}
const short = (v, digits = 4) => (v === 0 ? "0" : String(Number(v.toPrecision(digits))).replace("-", "−"));
const ms = (t) => (1e3 * t).toFixed(end < 0.01 ? 3 : 2) + " ms";

// ---- the run
const times = story.times_s, frames = times.length, beads = story.beads, end = times[frames - 1];
const place = unpack(story.positions.data), [lowX, lowY] = story.positions.low_m, stepM = story.positions.step_m;
const rowColours = 64;

function mixed(anchors, share) {
  const at = share * (anchors.length - 1), i = Math.min(Math.floor(at), anchors.length - 2);
  const channel = (k) => {
    const [a, b] = [anchors[i], anchors[i + 1]].map((hex) => parseInt(hex.slice(k, k + 2), 16));
    return Math.round(a + (b - a) * (at - i));
  };
  return `rgb(${channel(1)},${channel(3)},${channel(5)})`;
}
const scales = story.colours.map((given) => {
  const bend = (v) => (given.soft ? Math.asinh(v / given.soft) : v);
  const low = bend(given.low), span = bend(given.high) - low;
  const share = (v) => (bend(v) - low) / span;
  const values = unpack(given.data), step = (given.high - given.low) / 65535;
  const shades = Uint8Array.from(values, (q) => Math.round((rowColours - 1) * share(given.low + step * q)));
  const row = Array.from({length: rowColours}, (_, i) => mixed(given.anchors, i / (rowColours - 1)));
  return {...given, share, shades, row};
});
let scale = scales[0];

// ---- the clock: everything that moves listens to it
const listeners = [];
const clock = {t: 0, playing: false, seconds: 8, last: null};
function setTime(t) {
  clock.t = Math.min(Math.max(t, 0), end);
  for (const listener of listeners) listener(clock.t);
}
function setPlaying(on) {
  if (on && clock.t >= end) setTime(0);
  clock.playing = on;
  clock.last = null;
  at("play").textContent = on ? "Pause" : "Play";
  if (on) requestAnimationFrame(tick);
}
function tick(now) {
  if (!clock.playing) return;
  if (clock.last !== null) setTime(clock.t + (Math.min(now - clock.last, 100) / 1e3) * (end / clock.seconds));
  clock.last = now;
  if (clock.t >= end) setPlaying(false);
  else requestAnimationFrame(tick);
}
function frameAt(t) {
  let low = 0, high = frames - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  const share = high > low ? (t - times[low]) / (times[high] - times[low]) : 0;
  return [low, high, Math.min(Math.max(share, 0), 1)];
}
function stepFrame(by) {
  setPlaying(false);
  const [low, , share] = frameAt(clock.t);
  const index = by > 0 ? low + (share > 0.999 ? 2 : 1) : low - (share < 0.001 ? 1 : 0);
  setTime(times[Math.min(Math.max(index, 0), frames - 1)]);
}

// ---- the stage
const finger = story.finger;
const box = (() => {
  let highX = 0, highY = 0;
  for (let i = 0; i < place.length; i += 2) { highX = Math.max(highX, place[i]); highY = Math.max(highY, place[i + 1]); }
  const edge = story.thickness_m, r = finger.radius_m;
  const x0 = Math.min(lowX, finger.reach_m[0]) - edge, x1 = Math.max(lowX + highX * stepM, finger.reach_m[1]) + edge;
  const y0 = Math.min(lowY, -r) - edge, y1 = Math.max(lowY + highY * stepM, r) + edge;
  return {x0, y0, width: x1 - x0, height: y1 - y0};
})();
const shade = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const screenInk = () => ({finger: shade("--finger"), edge: shade("--finger-edge"), ghost: shade("--ghost"), soft: shade("--soft")});
const paperInk = {finger: "#e6dfd4", edge: "#b9ad9a", ghost: "#b5b0a8", soft: "#444"};

// A hand moves its finger; the last frame is the one before the hit.
function fingerAt(t) {
  if (finger.way_m === null) return finger.centre_m;
  const [low, high, share] = frameAt(t);
  return finger.centre_m + finger.way_m[low] + share * (finger.way_m[high] - finger.way_m[low]);
}
function outline(context, frame, toX, toY) {
  context.beginPath();
  for (let i = 0, k = 2 * frame * beads; i < beads; i++, k += 2) context.lineTo(toX(place[k]), toY(place[k + 1]));
  if (!story.open) context.closePath();
}
function paint(canvas, width, height, density, t, ink) {
  canvas.width = Math.round(width * density);
  canvas.height = Math.round(height * density);
  const context = canvas.getContext("2d");
  context.scale(density, density);
  const zoom = Math.min((width - 16) / box.width, (height - 16) / box.height);
  const left = (width - zoom * box.width) / 2, top = (height - zoom * box.height) / 2;
  const toX = (q) => left + zoom * (lowX + q * stepM - box.x0);
  const toY = (q) => top + zoom * (box.y0 + box.height - lowY - q * stepM);
  const thick = Math.max(zoom * story.thickness_m, 2);
  if (!story.open && (finger.until_s === null || t < finger.until_s)) {
    context.beginPath();
    const radius = Math.max(zoom * finger.radius_m - thick / 2, 1), centre = left + zoom * (fingerAt(t) - box.x0);
    context.arc(centre, top + zoom * (box.y0 + box.height), radius, 0, 2 * Math.PI);
    context.fillStyle = ink.finger; context.fill();
    context.strokeStyle = ink.edge; context.lineWidth = 1; context.stroke();
    context.fillStyle = ink.soft; context.font = "13px system-ui, sans-serif"; context.textAlign = "center";
    context.fillText("finger", centre, top + zoom * (box.y0 + box.height) + 4);
  }
  if (story.peg) {
    context.beginPath();
    const radius = Math.max(zoom * story.peg.radius_m - thick / 2, 1);
    context.arc(left + zoom * (story.peg.centre_m - box.x0), top + zoom * (box.y0 + box.height), radius, 0, 2 * Math.PI);
    if (t <= story.peg.until_s) { context.fillStyle = ink.finger; context.fill(); }
    context.strokeStyle = ink.edge; context.lineWidth = 1; context.stroke();
  }
  outline(context, 0, toX, toY);
  context.strokeStyle = ink.ghost; context.lineWidth = 1; context.setLineDash([4, 4]); context.stroke(); context.setLineDash([]);

  // Bonds of equal shade are stroked together.
  const [low, high, share] = frameAt(t), a = low * beads, b = high * beads;
  const x = (i) => toX(place[2 * (a + i)] + share * (place[2 * (b + i)] - place[2 * (a + i)]));
  const y = (i) => toY(place[2 * (a + i) + 1] + share * (place[2 * (b + i) + 1] - place[2 * (a + i) + 1]));
  const colour = (i) => Math.round(scale.shades[a + i] + share * (scale.shades[b + i] - scale.shades[a + i]));
  context.lineWidth = thick; context.lineCap = "round"; context.lineJoin = "round";
  const bonds = story.open ? beads - 1 : beads;
  for (let i = 0; i < bonds;) {
    const here = colour(i);
    context.beginPath();
    context.moveTo(x(i), y(i));
    do { i++; context.lineTo(x(i % beads), y(i % beads)); } while (i < bonds && colour(i) === here);
    context.strokeStyle = scale.row[here];
    context.stroke();
  }

  // Where parts of the band touch each other.
  context.strokeStyle = ink.soft; context.lineWidth = 1.5;
  for (const [px, py] of story.touches_m[share < 0.5 ? low : high] ?? []) {
    context.beginPath();
    context.arc(left + zoom * (px - box.x0), top + zoom * (box.y0 + box.height - py), thick + 4, 0, 2 * Math.PI);
    context.stroke();
  }
  if (finger.hit_s !== null && t >= times[frames - 1]) {
    context.beginPath();
    context.arc(left + zoom * (fingerAt(t) - finger.radius_m - box.x0), top + zoom * (box.y0 + box.height), 3 * thick, 0, 2 * Math.PI);
    context.strokeStyle = "#D55E00"; context.lineWidth = 3; context.stroke();
    context.fillStyle = "#D55E00"; context.font = "13px system-ui, sans-serif"; context.textAlign = "right";
    context.fillText(`hit at ${short(1e3 * finger.hit_s)} ms`, left + zoom * (fingerAt(t) - finger.radius_m - box.x0) - 4 * thick, top + zoom * (box.y0 + box.height) - 3 * thick);
  }

  // A bar to measure with.
  const bar = roundBelow(box.width / 4), ends = [10, 10 + zoom * bar];
  context.strokeStyle = context.fillStyle = ink.soft; context.lineWidth = 1.5; context.lineCap = "butt";
  context.beginPath();
  context.moveTo(ends[0], height - 14); context.lineTo(ends[0], height - 9);
  context.lineTo(ends[1], height - 9); context.lineTo(ends[1], height - 14);
  context.stroke();
  context.font = "12px system-ui, sans-serif"; context.textAlign = "left";
  context.fillText(`${short(1e3 * bar)} mm`, ends[0], height - 19);
}
// Room for the bar below a strip, which is flat.
const heightFor = (width) => Math.max(width * (box.height / box.width) + 24, 72);
function paintStage() {
  const canvas = at("stage"), width = canvas.parentElement.clientWidth - 26;
  if (width <= 0) return;
  const height = Math.round(Math.min(heightFor(width), 0.62 * Math.max(innerHeight, 420)));
  canvas.height = height;
  paint(canvas, width, height, window.devicePixelRatio || 1, clock.t, screenInk());
}

// ---- the row of colours, with its values
function drawScale() {
  const svg = at("scale"), width = 300;
  svg.setAttribute("viewBox", `0 0 ${width} 44`);
  const symbol = scale.name === "stretch" ? "λ" : "κ";
  const title = `${scale.label} ${symbol}${scale.unit ? ` (${scale.unit})` : ""}`;
  svg.setAttribute("aria-label", `colours: ${title} from ${short(scale.low)} to ${short(scale.high)}`);
  svg.replaceChildren();
  draw(svg, "text", {x: 8, y: 11}, title);
  for (let i = 0; i < rowColours; i++) {
    draw(svg, "rect", {x: 8 + ((width - 16) * i) / rowColours, y: 16, width: (width - 16) / rowColours + 0.4, height: 10, fill: scale.row[i]});
  }
  const marks = scale.soft
    ? [-1000, -100, 0, 100, 1000].filter((v) => Math.abs(v) <= scale.high)
    : ticks(scale.low, scale.high, 5);
  for (const v of marks) {
    draw(svg, "text", {x: 8 + (width - 16) * scale.share(v), y: 40, "text-anchor": "middle"}, short(v));
  }
}

// ---- charts
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [5, 2, 1].find((m) => m * power <= value * 1.001);
}
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((m) => m * power >= rough * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}
function decades(low, high) {
  const found = [], many = Math.log10(high / low) > 1.6;
  for (let p = Math.floor(Math.log10(low)); p <= Math.ceil(Math.log10(high)); p++) {
    for (const m of many ? [1] : [1, 2, 5]) if (m * 10 ** p >= low * 0.999 && m * 10 ** p <= high * 1.001) found.push(m * 10 ** p);
  }
  return found;
}
function valueAt(curve, t) {
  const {t_s: ts, values} = curve;
  if (t < ts[0] || t > ts[ts.length - 1]) return null;
  let i = 1;
  while (i < ts.length - 1 && ts[i] < t) i++;
  const share = (t - ts[i - 1]) / (ts[i] - ts[i - 1] || 1);
  return values[i - 1] + share * (values[i] - values[i - 1]);
}
function addChart(given) {
  const card = make("article", {class: "chart", "data-key": given.key});
  const heading = make("h3", {}, make("span", {}, `${given.title} (${given.unit})`));
  let logarithmic = given.logarithmic;
  if (given.logarithmic) {
    const tick = make("input", {type: "checkbox"});
    tick.checked = true;
    tick.addEventListener("change", () => { logarithmic = tick.checked; lay(); });
    heading.append(make("label", {}, tick, " log–log"));
  }
  const svg = document.createElementNS(svgSpace, "svg");
  svg.setAttribute("role", "img");
  const list = make("ul");
  card.append(heading, svg, list);
  at("charts").append(card);

  // Shares lie on top of each other; the rest are lines.
  let below = null;
  const curves = given.curves.map((curve, i) => {
    const bottom = below, tops = given.stacked ? curve.values.map((v, k) => v + (bottom ? bottom[k] : 0)) : curve.values;
    if (given.stacked) below = tops;
    return {...curve, bottom, tops, ink: i % 4, main: curve.style === "line"};
  });
  const readings = curves.map((curve) => {
    const reading = make("b"), key = keyBox();
    if (given.stacked) draw(key, "rect", {x: 2, y: 0, width: 18, height: 10, class: `area f${curve.ink}`});
    else draw(key, "line", {x1: 2, x2: 20, y1: 5, y2: 5, class: `curve s${curve.ink} ${curve.style}`});
    list.append(make("li", {}, key, make("span", {}, curve.name), reading));
    return reading;
  });
  if (given.window_s) {
    const key = keyBox();
    draw(key, "rect", {x: 2, y: 0, width: 18, height: 10, class: "shade"});
    list.append(make("li", {}, key, make("span", {}, given.window_name)));
  }
  const summary = curves.filter((c) => c.main).map((c) => `${c.name} from ${short(c.values[0])} to ${short(c.values[c.values.length - 1])} ${given.unit}`);
  svg.setAttribute("aria-label", `${given.title} over time: ${summary.join("; ")}`);

  const margin = {left: 46, right: 10, top: 8, bottom: 36};
  let geometry = null;
  function lay() {
    const width = Math.max(card.clientWidth - 26, 220), height = Math.round(Math.min(Math.max(width * 0.62, 190), 280));
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.replaceChildren();
    const inner = {x0: margin.left, x1: width - margin.right, y0: height - margin.bottom, y1: margin.top};
    const usable = (c) => c.t_s.map((t, k) => [t, c.tops[k]]).filter(([t, v]) => !logarithmic || (t > 0 && v > 0));
    const points = curves.map(usable), all = points.flat();
    const lastT = Math.max(...all.map((p) => p[0]));
    const tLow = logarithmic ? Math.min(...all.map((p) => p[0])) : 0;
    let vLow = Math.min(0, ...all.map((p) => p[1])), vHigh = Math.max(...all.map((p) => p[1]));
    if (logarithmic) vLow = Math.min(...all.map((p) => p[1]));
    else if (given.stacked) vHigh = Math.max(100, vHigh);
    else vHigh += 0.06 * (vHigh - vLow) || 1;
    const bend = logarithmic ? Math.log : (v) => v;
    const toX = (t) => inner.x0 + ((inner.x1 - inner.x0) * (bend(t) - bend(tLow))) / (bend(lastT) - bend(tLow));
    const toY = (v) => inner.y0 - ((inner.y0 - inner.y1) * (bend(v) - bend(vLow))) / (bend(vHigh) - bend(vLow));
    if (given.window_s) {
      const [x0, x1] = given.window_s.map((t) => Math.min(Math.max(toX(Math.max(t, tLow)), inner.x0), inner.x1));
      draw(svg, "rect", {x: x0, y: inner.y1, width: Math.max(x1 - x0, 0), height: inner.y0 - inner.y1, class: "shade"});
    }
    const tMarks = logarithmic ? decades(1e3 * tLow, 1e3 * lastT) : ticks(0, 1e3 * lastT, Math.max(3, width / 90));
    const vMarks = logarithmic ? decades(vLow, vHigh) : ticks(vLow, vHigh, 5);
    for (const t of tMarks) {
      const x = toX(t / 1e3);
      draw(svg, "line", {x1: x, x2: x, y1: inner.y0, y2: inner.y1, class: "grid"});
      draw(svg, "text", {x, y: inner.y0 + 15, "text-anchor": "middle"}, short(t));
    }
    for (const v of vMarks) {
      const y = toY(v);
      draw(svg, "line", {x1: inner.x0, x2: inner.x1, y1: y, y2: y, class: "grid"});
      draw(svg, "text", {x: inner.x0 - 6, y: y + 4, "text-anchor": "end"}, short(v));
    }
    draw(svg, "text", {x: (inner.x0 + inner.x1) / 2, y: inner.y0 + 31, "text-anchor": "middle"}, "time (ms)");
    curves.forEach((curve, i) => {
      const path = points[i].map(([t, v]) => `${toX(t).toFixed(1)},${toY(v).toFixed(1)}`);
      if (given.stacked) {
        const back = curve.t_s.map((t, k) => `${toX(t).toFixed(1)},${toY(curve.bottom ? curve.bottom[k] : 0).toFixed(1)}`).reverse();
        draw(svg, "polygon", {points: path.concat(back).join(" "), class: `area f${curve.ink}`});
      } else draw(svg, "polyline", {points: path.join(" "), class: `curve s${curve.ink} ${curve.style}`});
    });
    draw(svg, "line", {x1: inner.x0, x2: inner.x1, y1: inner.y0, y2: inner.y0, class: "axis"});
    const cursor = draw(svg, "line", {y1: inner.y0, y2: inner.y1, class: "cursor"});
    const dots = curves.map((c) => (c.main && !given.stacked ? draw(svg, "circle", {r: 4, class: `dot f${c.ink}`}) : null));
    geometry = {inner, bend, tLow, lastT, toX, toY, cursor, dots, width};
    follow(clock.t);
  }
  function follow(t) {
    const {toX, toY, cursor, dots, tLow, inner} = geometry;
    const x = Math.min(Math.max(toX(Math.max(t, logarithmic ? tLow : 0)), inner.x0), inner.x1);
    cursor.setAttribute("x1", x);
    cursor.setAttribute("x2", x);
    curves.forEach((curve, i) => {
      const value = valueAt(curve, t), top = valueAt({t_s: curve.t_s, values: curve.tops}, t);
      readings[i].textContent = value === null ? "" : short(value, 3);
      if (!dots[i]) return;
      const seen = top !== null && (!logarithmic || (top > 0 && t >= tLow));
      dots[i].setAttribute("visibility", seen ? "visible" : "hidden");
      if (seen) { dots[i].setAttribute("cx", x); dots[i].setAttribute("cy", toY(top)); }
    });
  }
  function drag(event) {
    const {inner, bend, tLow, lastT, width} = geometry, frame = svg.getBoundingClientRect();
    const x = ((event.clientX - frame.left) * width) / frame.width;
    const share = Math.min(Math.max((x - inner.x0) / (inner.x1 - inner.x0), 0), 1);
    const bent = bend(tLow) + share * (bend(lastT) - bend(tLow));
    setPlaying(false);
    setTime(logarithmic ? Math.exp(bent) : bent);
  }
  svg.addEventListener("pointerdown", (event) => { svg.setPointerCapture(event.pointerId); drag(event); });
  svg.addEventListener("pointermove", (event) => { if (event.buttons) drag(event); });
  return {lay, follow};
}

// ---- words and tables
function fill(id, rows) {
  const body = at(id).tBodies[0];
  for (const [name, text] of rows) body.append(make("tr", {}, make("th", {scope: "row"}, name), make("td", {}, text)));
}
document.title = `${story.title} – beadband`;
at("name").textContent = story.name;
at("title").textContent = story.title;
at("headline").textContent = story.headline;
fill("results", story.results);
fill("scene", story.scene);
fill("versions", story.versions);
at("warnings").hidden = story.warnings.length === 0;
at("warnings").querySelector("ul").append(...story.warnings.map((text) => make("li", {}, text)));
at("notes").textContent = story.notes.join(" ");

// ---- controls
for (const one of scales) {
  const button = make("input", {type: "radio", name: "colour", value: one.name});
  button.checked = one === scale;
  button.addEventListener("change", () => { scale = one; drawScale(); paintStage(); paintPrints(); });
  at("colours").append(make("label", {}, button, ` ${one.label}`));
}
for (const [seconds, name] of [[32, "¼"], [16, "½"], [8, "1"], [4, "2"], [2, "4"]]) {
  const option = make("option", {value: seconds}, `${name} ×`);
  option.selected = seconds === clock.seconds;
  at("speed").append(option);
}
function tellSpeed() {
  at("slow").textContent = `Slowed down ${Math.round(clock.seconds / end).toLocaleString("en")} times.`;
}
at("speed").addEventListener("change", (event) => { clock.seconds = Number(event.target.value); tellSpeed(); });
at("play").addEventListener("click", () => setPlaying(!clock.playing));
at("clock").max = end;
at("clock").addEventListener("input", (event) => { setPlaying(false); setTime(Number(event.target.value)); });
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target, kind = target.tagName;
  const choosing = kind === "SELECT" || (kind === "INPUT" && target.type !== "range");
  if (choosing || (kind === "BUTTON" && event.key === " ")) return;
  const does = {
    " ": () => setPlaying(!clock.playing),
    ArrowLeft: () => stepFrame(-1),
    ArrowRight: () => stepFrame(1),
    Home: () => { setPlaying(false); setTime(0); },
    End: () => { setPlaying(false); setTime(end); },
  }[event.key];
  if (!does) return;
  event.preventDefault();
  does();
});

// ---- what follows the clock
listeners.push((t) => {
  const [low, high, share] = frameAt(t), frame = share > 0.5 ? high : low;
  const text = `${ms(t)}, frame ${frame} of ${frames - 1}`;
  at("clock").value = t;
  at("clock").setAttribute("aria-valuetext", text);
  at("time").textContent = text;
  paintStage();
});
at("stage").setAttribute("aria-label", `The band${story.open ? "" : " around the finger"}, coloured by stretch${story.open ? "" : " or curvature"}, moving with the clock. ${story.headline}`);

// ---- six pictures for paper
const prints = [0, 0.1, 0.25, 0.5, 0.75, 1].map((share) => {
  const canvas = make("canvas"), t = times[Math.round(share * (frames - 1))];
  at("prints").append(make("figure", {}, canvas, make("figcaption", {}, ms(t))));
  return [canvas, t];
});
function paintPrints() {
  for (const [canvas, t] of prints) paint(canvas, 420, heightFor(420), 2, t, paperInk);
}

// All are on the page before the first is laid out: the width of one depends on the others.
const charts = story.charts.map(addChart);
for (const chart of charts) { chart.lay(); listeners.push(chart.follow); }
drawScale();
tellSpeed();
setTime(0);
paintPrints();
let width = document.documentElement.clientWidth;
new ResizeObserver(() => {
  if (document.documentElement.clientWidth === width) return;
  width = document.documentElement.clientWidth;
  for (const chart of charts) chart.lay();
  paintStage();
}).observe(document.documentElement);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paintStage);
})();
