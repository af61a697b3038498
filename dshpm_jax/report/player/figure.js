// Draws the figure: floor, skin and sticks of the parts, points, names.

function drawFloor(project) {
  const target = place(follows() ? view.frame : 0, CAMERA), tile = 500;
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

// Where nobody knows the place of a marker, its neighbours in part `p` are linked across it: pairs of places.
function* acrossGaps(p, at, bridge) {
  for (const column of parts[p]?.columns ?? []) {
    if (at[column] || bridge[column]) continue;
    const near = links.filter(([from, to]) => from === column || to === column)
      .map(([from, to]) => from === column ? to : from).map(other => at[other] ?? bridge[other]).filter(Boolean);
    if (partOf[column] === p) for (const other of near.slice(1)) yield [near[0], other];
  }
}

// The skin of each part, the farthest first, and its sticks; `bridge` has places of markers that are not seen.
function drawParts(at, bridge) {
  const groups = [...parts.map((part, p) => ({part, p})), {part: {columns: [], colour: theme.accent}, p: -1}];
  for (const group of groups) {
    group.held = group.part.columns.filter(c => at[c]).map(c => at[c]);
    group.depth = group.held.reduce((total, q) => total + q[2], 0) / Math.max(group.held.length, 1);
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
      const ends = [from, to].map(column => at[column] ?? bridge[column]);
      if (of !== p || !ends[0] || !ends[1]) continue;
      pen.setLineDash(at[from] && at[to] ? [] : [3, 5]);
      path(ends);
      pen.stroke();
    }
    pen.setLineDash([3, 5]);
    for (const ends of acrossGaps(p, at, bridge)) {
      path(ends);
      pen.stroke();
    }
    pen.setLineDash([]);
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
  const ring = ringOf(column, span);
  if (ring) {
    pen.beginPath();
    pen.arc(x, y, 7.5, 0, 7);
    pen.lineWidth = 1.6;
    pen.strokeStyle = ring;
    pen.stroke();
  }
}

// A marker that is not seen, where it may be.
function drawGap([x, y], column) {
  pen.beginPath();
  pen.arc(x, y, 3, 0, 7);
  pen.lineWidth = 1;
  pen.strokeStyle = column === view.chosen ? theme.ink : colourOf(column);
  pen.stroke();
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
  const bridge = names.map((_, c) => !at[c] && bridged(c, view.frame)).map(spot => spot && project(spot));
  drawParts(at, bridge);
  for (const [column, q] of bridge.entries()) if (q) drawGap(q, column);
  for (const {column} of dots) if (column < names.length) drawDot(at[column], column);
  const named = dots.filter(({column}) => column < names.length).map(({column}) => column);
  drawNames(at, element("named").checked ? named : named.filter(column => column === view.chosen));
  drawMore(project);
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
