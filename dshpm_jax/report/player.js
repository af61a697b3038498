// Plays the recording in DATA: a stick figure on the left, a timeline of its labels on the right. Lengths are mm.

const {frames, columns, names, parts, links, step, centre, rate} = DATA;
const CAMERA = columns - 1;  // the last column is the path of the camera's target
const MISSING = -32768;
const NO_COLOUR = "#7c8794";
const SURENESS = [  // from which confidence on, colour, words
  [0.99, "#3d8f86", "from .99"], [0.95, "#8fbf9a", "from .95"], [0.9, "#d8c25f", "from .9"], [0.7, "#e08e3c", "from .7"],
  [-1, "#c9453b", "less"],
];

const element = id => document.getElementById(id);
const stage = element("stage"), canvas = stage.firstElementChild, pen = canvas.getContext("2d");
const timeline = element("timeline"), scroll = element("scroll"), tip = element("tip"), slider = element("frame");
const points = decode(DATA.points);

// The part of each marker (the first that has it), and its trajectories in the order of frames.
const partOf = names.map((_, c) => parts.findIndex(part => part.columns.includes(c)));
const spans = Array.from({length: columns}, () => []);
for (const [column, first, last, confidence, reason] of DATA.spans) {
  spans[column].push({first, last, confidence, reason: DATA.reasons[reason]});
}
for (const list of spans) list.sort((a, b) => a.first - b.first);

const view = {frame: 0, yaw: DATA.yaw, pitch: 0.21, zoom: 1, shift: [0, 0], playing: false, chosen: -1, hovered: -1};
let theme = {}, dots = [];

function decode(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return new Int16Array(bytes.buffer);
}

const seen = (frame, column) => points[3 * (frame * columns + column)] !== MISSING;

function place(frame, column) {
  const k = 3 * (frame * columns + column);
  return [points[k] * step + centre[0], points[k + 1] * step + centre[1], points[k + 2] * step + centre[2]];
}

function spanAt(column, frame) {
  const list = spans[column];
  let low = 0, high = list.length - 1;
  while (low <= high) {
    const middle = (low + high) >> 1;
    if (list[middle].last < frame) low = middle + 1;
    else if (list[middle].first > frame) high = middle - 1;
    else return list[middle];
  }
  return null;
}

const colourOf = column => partOf[column] < 0 ? theme.accent : parts[partOf[column]].colour;
const sureness = confidence => SURENESS.find(([least]) => confidence >= least)[1];

// ---- The stage

// Turns a place into pixels: right, down, and how far away it is.
function camera() {
  const {width, height} = canvas.getBoundingClientRect();
  const [targetX, targetY] = place(element("follow").checked ? view.frame : 0, CAMERA);
  const away = 6 * DATA.radius, scale = 0.44 * Math.min(width, height * 1.1) / DATA.radius * view.zoom;
  const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
  return ([x, y, z]) => {
    [x, y, z] = [x - targetX, y - targetY, z - DATA.height];  // it follows along the ground, never up and down
    const right = x * cy - y * sy, forward = x * sy + y * cy;
    const top = forward * sp + z * cp, depth = forward * cp - z * sp;
    const near = away / Math.max(away + depth, 0.05 * away);
    return [width / 2 + view.shift[0] + right * scale * near, height / 2 + view.shift[1] - top * scale * near, depth];
  };
}

function drawFloor(project) {
  const target = place(element("follow").checked ? view.frame : 0, CAMERA), tile = 500;
  const reach = Math.ceil(2.2 * DATA.radius / tile) * tile;
  const [x, y] = [Math.round(target[0] / tile) * tile, Math.round(target[1] / tile) * tile];
  pen.strokeStyle = theme.line;
  pen.lineWidth = 1;
  pen.beginPath();
  for (let d = -reach; d <= reach; d += tile) {
    for (const ends of [[[x + d, y - reach], [x + d, y + reach]], [[x - reach, y + d], [x + reach, y + d]]]) {
      const [from, to] = ends.map(end => project([...end, DATA.floor]));
      pen.moveTo(from[0], from[1]);
      pen.lineTo(to[0], to[1]);
    }
  }
  pen.stroke();
}

// Corners of the convex outline of flat places, in order round it.
function outline(flat) {
  const sorted = [...flat].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = list => {
    const kept = [];
    for (const p of list) {
      while (kept.length > 1) {
        const [a, b] = kept.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        kept.pop();
      }
      kept.push(p);
    }
    return kept.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

function path(corners) {
  pen.beginPath();
  for (const [x, y] of corners) pen.lineTo(x, y);
}

// The skin of each part, the farthest first, and its sticks.
function drawParts(at) {
  const groups = parts.length ? parts.map((part, p) => ({part, p})) : [{part: {columns: [], colour: theme.accent}, p: -1}];
  for (const group of groups) {
    group.held = group.part.columns.filter(c => at[c]).map(c => at[c]);
    group.depth = group.held.reduce((total, q) => total + q[2], 0) / group.held.length;
  }
  for (const {part, p, held} of groups.sort((a, b) => b.depth - a.depth)) {
    if (held.length > 2) {
      pen.globalAlpha = 0.16;
      pen.fillStyle = part.colour;
      path(outline(held));
      pen.fill();
    }
    pen.globalAlpha = 0.9;
    pen.strokeStyle = part.colour;
    pen.lineWidth = 2;
    for (const [from, to, of] of links) {
      if (of !== p || !at[from] || !at[to]) continue;
      path([at[from], at[to]]);
      pen.stroke();
    }
  }
  pen.globalAlpha = 1;
}

function drawDot([x, y], column) {
  const known = column < names.length, span = spanAt(column, view.frame);
  pen.beginPath();
  pen.arc(x, y, known ? 3.6 : 2.6, 0, 7);
  pen.fillStyle = known ? colourOf(column) : theme.faint;
  pen.fill();
  if (known) {
    pen.lineWidth = 1;
    pen.strokeStyle = theme.panel;
    pen.stroke();
  }
  const doubtful = known && span && span.confidence < 0.9;
  if (doubtful || column === view.chosen || column === view.hovered) {
    pen.beginPath();
    pen.arc(x, y, 7.5, 0, 7);
    pen.lineWidth = 1.6;
    pen.strokeStyle = column === view.chosen || column === view.hovered ? theme.ink : sureness(span.confidence);
    pen.stroke();
  }
}

function drawName([x, y], name) {
  pen.lineWidth = 3;
  pen.strokeStyle = theme.panel;
  pen.strokeText(name, x + 7, y - 4);
  pen.fillStyle = theme.ink;
  pen.fillText(name, x + 7, y - 4);
}

function draw() {
  const ratio = devicePixelRatio || 1, {width, height} = canvas.getBoundingClientRect();
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = theme.font;
  pen.lineCap = pen.lineJoin = "round";
  const project = camera();
  drawFloor(project);
  const shown = element("others").checked ? CAMERA : names.length;
  const at = Array.from({length: shown}, (_, c) => seen(view.frame, c) ? project(place(view.frame, c)) : null);
  dots = at.map((q, column) => q && {column, x: q[0], y: q[1], depth: q[2]}).filter(Boolean);
  dots.sort((a, b) => b.depth - a.depth);
  for (const {column} of dots) if (column >= names.length) drawDot(at[column], column);
  drawParts(at);
  for (const {column} of dots) if (column < names.length) drawDot(at[column], column);
  for (const {column} of dots) {
    if (column < names.length && (element("labels").checked || column === view.chosen)) drawName(at[column], names[column]);
  }
}

function describe(column, frame) {
  const span = spanAt(column, frame);
  const lines = [column < names.length ? names[column] : "unlabelled"];
  if (column < names.length && partOf[column] >= 0) lines[0] += ` (${parts[partOf[column]].name})`;
  if (!span) return lines[0];
  lines.push(`confidence ${span.confidence.toFixed(2)}: ${span.reason}`);
  lines.push(`frames ${span.first} to ${span.last}`);
  return lines.join("\n");
}

// ---- The timeline

const ROW = 14, GUTTER = 108, HEAD = 20;
const rows = [];  // {title} of a part, {column}, or {others}
for (const p of [...parts.keys(), -1]) {
  const own = names.map((_, c) => c).filter(c => partOf[c] === p);
  if (!own.length) continue;
  if (parts.length) rows.push({title: p < 0 ? "no segment" : parts[p].name, colour: p < 0 ? NO_COLOUR : parts[p].colour});
  rows.push(...own.map(column => ({column})));
}
if (CAMERA > names.length) rows.push({others: true});
const tops = [];
let bottom = 4;
for (const row of rows) {
  tops.push(bottom);
  bottom += row.title != null ? HEAD : row.others ? 30 : ROW;
}

// Unbroken stretches of a column, cut where its trajectory changes.
function stretches(column) {
  const found = [];
  for (let t = 0; t < frames; t++) {
    if (!seen(t, column)) continue;
    const span = spanAt(column, t), stop = span ? span.last : frames - 1, first = t;
    while (t + 1 <= stop && t + 1 < frames && seen(t + 1, column)) t++;
    found.push({first, last: t, colour: span ? sureness(span.confidence) : NO_COLOUR});
  }
  return found;
}

const frameX = (frame, width) => GUTTER + frame / frames * (width - GUTTER - 10);
const frameAt = (x, width) => Math.max(0, Math.min(frames - 1, Math.floor((x - GUTTER) / (width - GUTTER - 10) * frames)));

function drawTimeline() {
  const ratio = devicePixelRatio || 1, width = scroll.clientWidth, ink = timeline.getContext("2d");
  [timeline.width, timeline.height] = [Math.round(width * ratio), Math.round((bottom + 6) * ratio)];
  timeline.style.height = element("playhead").style.height = bottom + 6 + "px";
  ink.setTransform(ratio, 0, 0, ratio, 0, 0);
  ink.font = theme.font;
  ink.textBaseline = "middle";
  for (const [k, row] of rows.entries()) {
    const y = tops[k];
    if (row.title != null) {
      ink.fillStyle = row.colour;
      ink.fillRect(10, y + HEAD / 2 - 1, 8, 8);
      ink.fillStyle = theme.soft;
      ink.fillText(row.title, 24, y + HEAD / 2 + 3.5, width - 34);
      continue;
    }
    const high = row.others ? 26 : ROW;
    ink.fillStyle = row.column === view.chosen ? theme.accent : theme.ink;
    ink.fillText(row.others ? "unlabelled" : names[row.column], 24, y + high / 2 + 0.5, GUTTER - 32);
    if (row.others) drawOthers(ink, y, width);
    else drawStretches(ink, row, y, width);
  }
  movePlayhead();
}

// Bars first, then every gap at least a good half pixel wide, so that none is too short to be seen.
function drawStretches(ink, row, y, width) {
  row.stretches ??= stretches(row.column);
  for (const {first, last, colour} of row.stretches) {
    ink.fillStyle = colour;
    const x = frameX(first, width);
    ink.fillRect(x, y + 3, Math.max(frameX(last + 1, width) - x, 0.7), ROW - 6);
  }
  [...row.stretches, {first: frames}].forEach(({first}, k, all) => {
    const from = k ? all[k - 1].last + 1 : 0, x = frameX(from, width);
    if (first === from) return;
    ink.fillStyle = theme.panel;
    ink.fillRect(x, y + 3, Math.max(frameX(first, width) - x, 0.7), ROW - 6);
    ink.fillStyle = theme.line;
    ink.fillRect(x, y + ROW / 2 - 0.5, frameX(first, width) - x, 1);
  });
}

// How many unlabelled points there are.
function drawOthers(ink, y, width) {
  const counts = new Uint16Array(frames);
  for (let t = 0; t < frames; t++) for (let c = names.length; c < CAMERA; c++) counts[t] += seen(t, c);
  const top = counts.reduce((a, b) => Math.max(a, b), 1);
  ink.fillStyle = theme.faint;
  for (let t = 0; t < frames; t++) {
    const high = 22 * counts[t] / top, x = frameX(t, width);
    ink.fillRect(x, y + 26 - high, Math.max(frameX(t + 1, width) - x, 0.7), high);
  }
}

function rowAt(y) {
  const k = tops.findLastIndex(top => top <= y);
  return rows[k] ?? {};
}

function describeRow(row, frame) {
  if (row.column == null) return row.others ? `unlabelled points, frame ${frame}` : "";
  if (seen(frame, row.column)) return describe(row.column, frame);
  let [first, last] = [frame, frame];
  while (first > 0 && !seen(first - 1, row.column)) first--;
  while (last < frames - 1 && !seen(last + 1, row.column)) last++;
  return `${names[row.column]}\nmissing in frames ${first} to ${last} (${((last - first + 1) / rate).toFixed(2)} s)`;
}

function movePlayhead() {
  element("playhead").style.left = frameX(view.frame + 0.5, scroll.clientWidth) + "px";
}

// ---- Time

let last = 0, owed = 0, waiting = false;

function show(frame) {
  view.frame = ((Math.round(frame) % frames) + frames) % frames;
  slider.value = view.frame;
  element("time").textContent = `frame ${view.frame} of ${frames} \u00b7 ${(view.frame / rate).toFixed(2)} s`;
  movePlayhead();
  refresh();
}

function refresh() {
  if (!waiting) requestAnimationFrame(now => { waiting = false; advance(now); draw(); });
  waiting = true;
}

function advance(now) {
  if (!view.playing) return;
  owed += Math.min(now - last, 250) / 1000 * rate * element("speed").value;
  last = now;
  const whole = Math.floor(owed);
  owed -= whole;
  if (whole) show(view.frame + whole);
  refresh();
}

function play(on) {
  [view.playing, last, owed] = [on, performance.now(), 0];
  element("play").textContent = on ? "Pause" : "Play";
  refresh();
}

// ---- Hands

function showTip(text, event) {
  tip.hidden = !text;
  tip.textContent = text;
  tip.style.left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8) + "px";
  tip.style.top = Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8) + "px";
}

function nearest(event) {
  const box = canvas.getBoundingClientRect(), [x, y] = [event.clientX - box.left, event.clientY - box.top];
  let best = -1, least = 12;
  for (const dot of dots) {
    const distance = Math.hypot(dot.x - x, dot.y - y) - (dot.column < names.length ? 2 : 0);
    if (distance <= least) [best, least] = [dot.column, distance];
  }
  return best;
}

function choose(column) {
  view.chosen = column === view.chosen ? -1 : column;
  drawTimeline();
  refresh();
}

let held = null;  // a drag: where it began and whether it moved
canvas.onpointerdown = event => {
  canvas.setPointerCapture(event.pointerId);
  held = {x: event.clientX, y: event.clientY, move: event.shiftKey || event.button !== 0, moved: false};
};
canvas.onpointermove = event => {
  if (!held) {
    view.hovered = nearest(event);
    showTip(view.hovered < 0 ? "" : describe(view.hovered, view.frame), event);
    return refresh();
  }
  const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
  if (!held.moved && Math.hypot(dx, dy) < 3) return;
  if (held.move) view.shift = [view.shift[0] + dx, view.shift[1] + dy];
  else [view.yaw, view.pitch] = [view.yaw - dx * 0.008, Math.max(-1.57, Math.min(1.57, view.pitch + dy * 0.008))];
  Object.assign(held, {x: event.clientX, y: event.clientY, moved: true});
  tip.hidden = true;
  refresh();
};
canvas.onpointerup = event => {
  if (held && !held.moved) {
    const column = nearest(event);
    choose(column < names.length ? column : -1);
  }
  held = null;
};
canvas.onpointercancel = () => { held = null; };
canvas.onpointerleave = () => { tip.hidden = true; view.hovered = -1; refresh(); };
canvas.oncontextmenu = event => event.preventDefault();
canvas.onwheel = event => {
  event.preventDefault();
  view.zoom = Math.max(0.1, Math.min(40, view.zoom * Math.exp(-event.deltaY * 0.0015)));
  refresh();
};
canvas.ondblclick = () => { Object.assign(view, {yaw: DATA.yaw, pitch: 0.21, zoom: 1, shift: [0, 0]}); refresh(); };

timeline.onpointermove = event => {
  const row = rowAt(event.offsetY), frame = frameAt(event.offsetX, scroll.clientWidth);
  showTip(event.offsetX < GUTTER ? "" : describeRow(row, frame), event);
  if (event.buttons) show(frame);
};
timeline.onpointerleave = () => { tip.hidden = true; };
timeline.onpointerdown = event => {
  const row = rowAt(event.offsetY);
  if (event.offsetX >= GUTTER) show(frameAt(event.offsetX, scroll.clientWidth));
  if (row.column != null && (event.offsetX < GUTTER || row.column !== view.chosen)) choose(row.column);
};

slider.max = frames - 1;
slider.oninput = () => show(+slider.value);
element("play").onclick = () => play(!view.playing);
for (const id of ["labels", "others", "follow"]) element(id).onchange = refresh;
addEventListener("keydown", event => {
  if (["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName) && event.target !== slider) return;
  const far = event.shiftKey ? 10 : 1;
  const keys = {
    " ": () => play(!view.playing), ArrowLeft: () => show(view.frame - far), ArrowRight: () => show(view.frame + far),
    Home: () => show(0), End: () => show(frames - 1),
  };
  if (!keys[event.key] || (event.key === " " && event.target === element("play"))) return;
  event.preventDefault();
  keys[event.key]();
});

// ---- To begin with

function dress() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "faint", "line", "panel", "accent"]) theme[name] = style.getPropertyValue(`--${name}`);
  theme.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  drawTimeline();
  refresh();
}

function fillLegend() {
  const entry = (colour, text) => {
    const node = document.createElement("span"), swatch = document.createElement("i");
    swatch.style.background = colour;
    node.append(swatch, text);
    element("legend").append(node);
  };
  if (!DATA.spans.length) return entry(NO_COLOUR, "seen; a gap where it is missing");
  element("legend").append("Confidence");
  for (const [, colour, words] of SURENESS) entry(colour, words);
}

// The address may say where to begin: #frame=100, #labels, #play.
function obey() {
  const wanted = new URLSearchParams(location.hash.slice(1));
  if (wanted.has("labels")) element("labels").checked = true;
  if (wanted.has("marker")) view.chosen = names.indexOf(wanted.get("marker"));
  show(+wanted.get("frame") || 0);
  if (wanted.has("play")) play(true);
}

document.querySelector("h1").textContent = DATA.name;
element("about").textContent = `${names.length} labels, ${frames.toLocaleString("en")} frames, `
  + `${(frames / rate).toFixed(1)} s at ${+rate.toFixed(2)} Hz`;
fillLegend();
matchMedia("(prefers-color-scheme: dark)").onchange = dress;
new ResizeObserver(() => { dress(); draw(); }).observe(stage);
addEventListener("hashchange", obey);
dress();
obey();
