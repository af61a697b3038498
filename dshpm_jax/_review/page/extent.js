// Of which frames of the trajectory in hand something is said: all of it, up to here, from here on, or a marked span.

const EXTENTS = {whole: ["W", "Whole"], upto: [",", "Up to here"], from: [".", "From here"], span: ["I O", "In to out"]};
let extent = "whole", marks = {in: null, out: null};

function extentOf(track) {
  const here = Math.max(track.first, Math.min(track.last, view.frame));
  if (extent === "upto") return {first: track.first, last: here};
  if (extent === "from") return {first: here, last: track.last};
  if (extent !== "span") return {first: track.first, last: track.last};
  const [one, other] = [marks.in ?? track.first, marks.out ?? track.last];
  return {first: Math.max(track.first, Math.min(one, other)), last: Math.min(track.last, Math.max(one, other))};
}

function setExtent(kind) {
  extent = kind;
  if (kind !== "span") marks = {in: null, out: null};
  tellTrack();
}

function mark(end) {
  extent = "span";
  marks[end] = view.frame;
  tellTrack();
}

// Frames with no trajectory in hand: where the marks are, or where the frame is.
function framesMeant(track) {
  const {first, last} = extentOf(track);
  return {first, last: last + 1};
}

function drawExtents(parent) {
  const group = make("div", parent, null, "choices");
  for (const [kind, [key, text]] of Object.entries(EXTENTS)) {
    const node = keyed(group, key, text, () => kind === "span" ? mark(marks.in === null ? "in" : "out") : setExtent(kind));
    node.ariaPressed = String(kind === extent);
    node.dataset.extent = kind;
  }
}
