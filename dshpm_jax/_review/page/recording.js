// The trial in DATA: points of slots, and trajectories that lie in them; marker columns are made of those with a label.

const {frames, slots, step, centre, rate, names, parts, links} = DATA;
const SLOT = names.length, CAMERA = names.length + slots, columns = CAMERA + 1;
const MISSING = -32768, NO_COLOUR = "#7c8794", SET = "#4472c4";
const SURENESS = [  // from which confidence on, colour, words
  [0.99, "#3d8f86", "from .99"], [0.95, "#8fbf9a", "from .95"], [0.9, "#d8c25f", "from .9"], [0.7, "#e08e3c", "from .7"],
  [-1, "#c9453b", "less"],
];
const TRACK = ["slot", "first", "last", "label", "confidence", "reason", "stake", "known"];

const stage = element("stage"), canvas = stage.firstElementChild, pen = canvas.getContext("2d");
const timeline = element("timeline"), scroll = element("scroll"), tip = element("tip"), slider = element("frame");
const raw = DATA.points, points = new Int16Array(3 * frames * columns);
const partOf = names.map((_, c) => parts.findIndex(part => part.columns.includes(c)));
const view = {
  frame: 0, yaw: DATA.yaw, pitch: 0.21, zoom: 1, shift: [0, 0], playing: false, chosen: -1, hovered: -1, track: -1,
};
let theme = {}, dots = [], state = DATA, tracks = [], shownTracks = [], spans = [], doubts = [], stretchesOf = [], differing = new Set();

const columnOf = track => track.label < 0 ? SLOT + track.slot : track.label;
const nameOf = track => track.label < 0 ? null : names[track.label];

function tracksIn({tracks: rows, reasons}) {
  return rows.map((row, index) => {
    const track = Object.fromEntries(TRACK.map((field, k) => [field, row[k]]));
    return {...track, index, reason: reasons[track.reason], doubtful: track.stake > 0, column: columnOf(track)};
  });
}

// Shows other labels: those that are kept, or those that are proposed.
function lay(list) {
  shownTracks = list;
  const row = 3 * columns, from = 3 * (slots + 1), named = 3 * names.length;
  for (let t = 0; t < frames; t++) {
    points.fill(MISSING, t * row, t * row + named);
    points.set(raw.subarray(t * from, (t + 1) * from), t * row + named);
  }
  spans = Array.from({length: columns}, () => []);
  stretchesOf = [];
  for (const track of list) {
    spans[track.column].push(track);
    if (track.label < 0) continue;
    let target = 3 * (track.first * columns + track.label), source = 3 * (track.first * columns + SLOT + track.slot);
    for (let t = track.first; t <= track.last; t++, target += row, source += row) {
      for (let k = 0; k < 3; k++) {
        points[target + k] = points[source + k];
        points[source + k] = MISSING;
      }
    }
  }
  for (const some of spans) some.sort((a, b) => a.first - b.first);
}

// Takes over what the program says the labels are now.
function take(found) {
  state = found;
  if (found.links !== links) links.splice(0, found.links ? links.length : 0, ...found.links ?? []);
  tracks = tracksIn(found);
  doubts = tracks.filter(track => track.doubtful).sort((a, b) => b.stake - a.stake || a.first - b.first);
  const proposed = found.proposal && tracksIn(found.proposal);
  differing = new Set(proposed ? differences(proposed) : []);
  lay(proposed || tracks);
}

// Of the proposed tracks, those that hold a point with another label than now.
function* differences(proposed) {
  const now = Array.from({length: slots}, () => []);
  for (const track of tracks) now[track.slot].push(track);
  for (const track of proposed) {
    const others = now[track.slot].filter(one => one.first <= track.last && one.last >= track.first);
    if (others.some(one => one.label !== track.label)) yield track.index;
  }
}

const seen = (frame, column) => points[3 * (frame * columns + column)] !== MISSING;
const seenSlot = (frame, slot) => raw[3 * (frame * (slots + 1) + slot)] !== MISSING;
const scaled = (list, k) => [list[k] * step + centre[0], list[k + 1] * step + centre[1], list[k + 2] * step + centre[2]];
const place = (frame, column) => scaled(points, 3 * (frame * columns + column));
const slotPlace = (frame, slot) => scaled(raw, 3 * (frame * (slots + 1) + slot));

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

// Trajectories of a column, in the order of frames.
function stretches(column) {
  stretchesOf[column] ??= spans[column].map(track => ({...track, colour: colourOfTrack(track)}));
  return stretchesOf[column];
}

const colourOf = column => partOf[column] < 0 ? theme.accent : parts[partOf[column]].colour;
const sureness = confidence => SURENESS.find(([least]) => confidence >= least)[1];
const colourOfTrack = track => track.known ? SET : sureness(track.confidence);
const trackInHand = () => shownTracks[view.track] ?? null;

function ringOf(column, span) {
  if (column === view.hovered || (span && span.index === view.track)) return theme.ink;
  if (span && differing.has(span.index)) return SET;
  return span?.doubtful ? sureness(span.confidence) : null;
}
