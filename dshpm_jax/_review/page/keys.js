// Keys: everything can be done with them.

const TABS = {label: ["", "Label"], names: ["K", "Names"], gaps: ["G", "Gaps"], done: ["D", "Done"]};

function showTab(which) {
  for (const name of Object.keys(TABS)) element(`${name}-tab`).hidden = name !== which;
  for (const node of element("tabs").children) node.ariaSelected = String(node.dataset.tab === which);
  naming = which === "names";
  if (which === "names") tellNames();
  if (which === "gaps") loadGaps();
  refresh();
}

const tabShown = () => Object.keys(TABS).find(name => !element(`${name}-tab`).hidden);

// The points of this frame, from the top of the picture to its bottom.
function stepPoint(by) {
  const list = [...dots].sort((a, b) => a.y - b.y || a.x - b.x), now = list.findIndex(dot => dot.column === view.chosen);
  const next = list[now < 0 ? (by > 0 ? 0 : list.length - 1) : (now + by + list.length) % list.length];
  if (next) select(spanAt(next.column, view.frame)?.index ?? -1);
}

function toEnd(which) {
  const track = trackInHand();
  if (track) show(track[which]);
}

const HELP = [
  ["N  P", "next, previous doubt"], ["\u21e7N  \u21e7P", "next, previous trial"], ["1 \u2026 9", "it is this label"], ["0", "it is no marker"],
  ["/", "any label, by its name"], ["Enter", "right as it is; accept"], ["Esc", "refuse; leave"], ["\u21e7Enter", "all labels of the trial are right"], ["J", "accept just mine"],
  ["W", "all of the trajectory"], [",  .", "up to this frame, from this frame on"], ["I  O", "from this frame, to this frame"],
  ["C", "cut before this frame"], ["X", "exchange two labels"], ["M", "join two trajectories"], ["Z  Y", "undo, redo"],
  ["\u2190  \u2192", "frame, with \u21e7 ten"], ["[  ]", "ends of the trajectory"], ["space", "play"], ["\u2191  \u2193", "points of this frame"],
  ["F  S  T  R", "front, side, top, as at first"], ["A  E", "turn to the left, to the right"], ["+  \u2212", "nearer, farther"], ["V", "close up"],
  ["L  U", "labels, unlabelled points"], ["K", "name markers from a list"], ["G", "gaps"], ["D", "what was done"], ["?", "these keys"],
];

function tellHelp() {
  const box = element("help");
  box.replaceChildren();
  make("h2", box, "Keys");
  const list = make("div", box, null, "help");
  for (const [keys, text] of HELP) {
    const cell = make("span", list);
    for (const key of keys.split("  ")) make("kbd", cell, key);
    make("span", list, text);
  }
  box.onclick = () => box.close();
  box.showModal();
}

function turn(by) {
  view.yaw += by;
  refresh();
}

function zoom(by) {
  view.zoom = Math.max(0.1, Math.min(40, view.zoom * by));
  refresh();
}

function enter(event) {
  if (event.shiftKey) return confirmAll();
  if (state.proposal) return send({kind: "accept"});
  if (tabShown() === "gaps") return fillGap(true);
  if (naming) return nameTrack(trackInHand());
  return confirm();
}

function escape() {
  if (element("help").open) return element("help").close();
  if (state.proposal) return send({kind: "refuse"});
  if (choosing) return stopChoosing();
  if (extent !== "whole") return setExtent("whole");
  return select(-1);
}

function digit(number) {
  if (state.proposal) return toast("Accept or refuse first");
  if (choosing) return choosing.list[number - 1] && choosing.pick(choosing.list[number - 1].one);
  if (view.track < 0) return toast("Choose a point first");
  const label = optionFor(number);
  return label === undefined ? toast("No label has that key") : assign(label);
}

const inGaps = () => tabShown() === "gaps";
const KEYS = {
  " ": () => play(!view.playing), home: () => show(0), end: () => show(frames - 1), "[": () => toEnd("first"), "]": () => toEnd("last"),
  n: event => event.shiftKey ? neighbourTrial(1) : inGaps() ? stepGap(1) : nextDoubt(1),
  p: event => event.shiftKey ? neighbourTrial(-1) : inGaps() ? stepGap(-1) : nextDoubt(-1),
  arrowleft: event => show(view.frame - (event.shiftKey ? 10 : 1)), arrowright: event => show(view.frame + (event.shiftKey ? 10 : 1)),
  arrowdown: event => event.shiftKey && naming ? stepName(1) : stepPoint(1), arrowup: event => event.shiftKey && naming ? stepName(-1) : stepPoint(-1),
  enter, escape, j: () => state.proposal && send({kind: "accept", mine_only: true}), backspace: () => inGaps() && fillGap(false),
  w: () => setExtent("whole"), ",": () => setExtent("upto"), ".": () => setExtent("from"), i: () => mark("in"), o: () => mark("out"),
  c: cut, x: startExchange, m: startJoin, "/": openFind,
  z: event => send({kind: event.shiftKey ? "redo" : "undo"}), y: () => send({kind: "redo"}),
  f: () => lookFrom("front"), s: () => lookFrom("side"), t: () => lookFrom("top"), r: () => lookFrom("start"), v: closeUp,
  a: () => turn(0.15), e: () => turn(-0.15), "+": () => zoom(1.2), "-": () => zoom(1 / 1.2),
  l: () => element("named").click(), u: () => element("others").click(),
  k: () => showTab(naming ? "label" : "names"), g: () => showTab(inGaps() ? "label" : "gaps"), d: () => showTab(tabShown() === "done" ? "label" : "done"),
  "?": tellHelp,
};

addEventListener("keydown", event => {
  const {tagName, type} = event.target, key = event.key.toLowerCase();
  if (["SELECT", "TEXTAREA"].includes(tagName) || (tagName === "INPUT" && !["range", "checkbox"].includes(type))) {
    if (key === "escape") event.target.blur();
    return;
  }
  if ((event.ctrlKey || event.metaKey) && !["z", "y"].includes(key) || event.altKey) return;
  const number = /^Digit(\d)$/.exec(event.code)?.[1] ?? /^Numpad(\d)$/.exec(event.code)?.[1];
  if (number === undefined && !KEYS[key]) return;
  if ([" ", "enter"].includes(key) && tagName === "BUTTON" && event.target.closest("nav, #tabs, .names, .gaps, .options, .changes")) return;
  event.preventDefault();
  if (number !== undefined && !event.shiftKey) digit(+number);
  else KEYS[key]?.(event);
});

slider.max = frames - 1;
slider.oninput = () => show(+slider.value);
element("pause").onclick = () => play(!view.playing);
for (const id of ["named", "others"]) element(id).onchange = refresh;
element("follow").onchange = () => { fit(); refresh(); };
for (const where of ["front", "side", "top"]) element(where).onclick = () => lookFrom(where);
element("near").onclick = closeUp;
for (const [name, [key, text]] of Object.entries(TABS)) {
  const node = keyed(element("tabs"), key, text, () => showTab(name));
  node.role = "tab";
  node.dataset.tab = name;
}
keyed(element("tabs"), "?", "", tellHelp, "keys").title = "Keys";
