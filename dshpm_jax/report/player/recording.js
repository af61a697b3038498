// The recording in DATA: its points, its trajectories, and how it is looked at. Lengths are mm.

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
const spanOf = ([column, first, last, confidence, reason, doubtful]) => (
  {column, first, last, confidence, reason: DATA.reasons[reason], doubtful: Boolean(doubtful)});
const doubts = DATA.doubts.map(spanOf);  // trajectories whose label is in doubt, in the order of frames
for (const span of DATA.spans.map(spanOf)) spans[span.column].push(span);
for (const list of [...spans, doubts]) list.sort((a, b) => a.first - b.first || a.column - b.column);

const view = {
  frame: 0, yaw: DATA.yaw, pitch: 0.21, zoom: 1, shift: [0, 0], playing: false, chosen: -1, hovered: -1, doubt: -1,
};
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

// Unbroken stretches of a column, cut where its trajectory changes.
const stretchesOf = [];
function stretches(column) {
  if (stretchesOf[column]) return stretchesOf[column];
  const found = stretchesOf[column] = [];
  for (let t = 0; t < frames; t++) {
    if (!seen(t, column)) continue;
    const span = spanAt(column, t), stop = span ? span.last : frames - 1, first = t;
    while (t + 1 <= stop && t + 1 < frames && seen(t + 1, column)) t++;
    found.push({first, last: t, colour: span ? sureness(span.confidence) : NO_COLOUR, doubtful: span?.doubtful});
  }
  return found;
}

const colourOf = column => partOf[column] < 0 ? theme.accent : parts[partOf[column]].colour;
const sureness = confidence => SURENESS.find(([least]) => confidence >= least)[1];

// The colour of the ring round a point, if it has one.
function ringOf(column, span) {
  if (column === view.chosen || column === view.hovered) return theme.ink;
  return span?.doubtful ? sureness(span.confidence) : null;
}

const outlined = () => doubts[view.doubt];  // the trajectory with a frame on the timeline
const drawMore = () => {};  // besides the figure
