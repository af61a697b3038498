// The timeline: a row for each label, its trajectories coloured by how sure they are, its gaps white.

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
  const list = stretches(row.column);
  for (const {first, last, colour} of list) {
    ink.fillStyle = colour;
    const x = frameX(first, width);
    ink.fillRect(x, y + 3, Math.max(frameX(last + 1, width) - x, 0.7), ROW - 6);
  }
  [...list, {first: frames}].forEach(({first}, k, all) => {
    const from = k ? all[k - 1].last + 1 : 0, x = frameX(from, width);
    if (first === from) return;
    ink.fillStyle = theme.panel;
    ink.fillRect(x, y + 3, Math.max(frameX(first, width) - x, 0.7), ROW - 6);
    ink.fillStyle = theme.line;
    ink.fillRect(x, y + ROW / 2 - 0.5, frameX(first, width) - x, 1);
  });
  if (outlined()?.column === row.column) drawOutline(ink, y, ROW, width);
}

function drawOutline(ink, y, high, width) {
  const {first, last} = outlined(), x = frameX(first, width);
  ink.strokeStyle = theme.ink;
  ink.strokeRect(x - 1.5, y + 1.5, Math.max(frameX(last + 1, width) - x, 1) + 3, high - 3);
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
  if (outlined()?.column >= names.length) drawOutline(ink, y, 28, width);
}

// Shows the row of a column in the middle, if it is not in view.
function scrollToRow(column) {
  const top = tops[rows.findIndex(row => row.column === column || (row.others && column >= names.length))];
  if (top < scroll.scrollTop || top + ROW > scroll.scrollTop + scroll.clientHeight) scroll.scrollTop = top - scroll.clientHeight / 2;
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
