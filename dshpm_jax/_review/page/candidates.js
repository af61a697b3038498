// The trajectory in hand: what it is, what it may be, and the keys for that.

const optionsKnown = new Map();  // by version and trajectory
let options = [], choosing = null, anchor = null;

function select(index, frame = view.frame) {
  const track = shownTracks[index];
  choosing = null;
  view.track = track ? index : -1;
  view.chosen = track ? track.column : -1;
  anchor = track ? {slot: track.slot, frame: Math.max(track.first, Math.min(track.last, frame))} : null;
  if (track && track.label < 0) element("others").checked = true;
  if (extent === "span" && marks.in === null && marks.out === null) extent = "whole";
  fetchOptions();
  drawTimeline();
  refresh();
}

// The same trajectory after labels have changed, in which it may have another number and other ends.
function selectAgain() {
  const track = anchor && shownTracks.find(one => one.slot === anchor.slot && one.first <= anchor.frame && anchor.frame <= one.last);
  select(track ? track.index : -1, anchor?.frame);
}

const choose = column => {
  const track = spanAt(column, view.frame) ?? spans[column]?.find(one => one.last >= view.frame) ?? spans[column]?.at(-1);
  if (track) select(track.index);
};

function pick(column) {
  const track = column < 0 ? null : spanAt(column, view.frame);
  if (choosing && track) return choosing.pick(track);
  if (naming && track) return nameTrack(track);
  if (track) select(track.index);
  else select(-1);
}

async function fetchOptions() {
  const track = trackInHand();
  options = [];
  tellTrack();
  if (!track || state.proposal) return;
  const name = `${state.version}/${track.index}`;
  if (!optionsKnown.has(name)) optionsKnown.set(name, call(`candidates/${DATA.id}/${name}`).catch(() => []));
  const found = await optionsKnown.get(name);
  if (trackInHand() !== track) return;
  options = found.map(([label, chance]) => ({label, chance}));
  tellTrack();
}

function tellTrack() {
  const tab = element("label-tab"), track = trackInHand();
  tab.replaceChildren();
  if (state.proposal) return tellProposal(tab);
  if (!track) return tellNothing(tab);
  const head = make("div", tab, null, "head");
  make("h2", head, labelText(nameOf(track)));
  make("span", head, sureText(track), `chip ${track.known ? "set" : track.doubtful ? "doubt" : ""}`);
  make("p", tab, `${track.reason[0].toUpperCase()}${track.reason.slice(1)}.`, "soft");
  make("p", tab, null, "soft").id = "extent-text";
  drawExtents(tab);
  if (choosing) return tellChoosing(tab);
  make("h3", tab, "What is it?");
  const list = make("div", tab, null, "options");
  if (!options.length) make("p", list, "looking …", "soft");
  let key = 0;
  for (const {label, chance} of options) {
    const node = keyed(list, label === null ? "0" : String(++key), "", () => assign(label), "option");
    make("span", node, label ?? "no marker", "what");
    make("i", make("span", node, null, "meter")).style.width = `${100 * chance}%`;
    make("span", node, percent(chance), "number");
    if (label === nameOf(track)) node.classList.add("now");
    node.onpointerenter = () => hint(label);
    node.onpointerleave = () => hint(null);
  }
  if (!options.some(one => one.label === null)) keyed(list, "0", "no marker", () => assign(null), "option");
  keyed(list, "/", "another label …", openFind, "option");
  tellTools(tab, track);
  tellExtent();
}

function tellExtent() {
  const track = trackInHand(), node = element("extent-text");
  if (!track || !node) return;
  const {first, last} = extentOf(track), text = `Frames ${first}\u2013${last}, ${seconds((last - first + 1) / rate)}`;
  if (node.textContent !== text) node.textContent = text;
}

const sureText = track => track.known ? "set by you" : track.label < 0 ? (track.doubtful ? "in doubt" : "left out") : `${percent(track.confidence)} sure`;

function tellNothing(tab) {
  make("h2", tab, "No point in hand");
  make("p", tab, "Click a point or a row of the timeline, or step through the points of this frame with the arrow keys.", "soft");
  keyed(tab, "N", doubts.length ? `Next of ${several(doubts.length, "doubt")}` : "Next trial", () => nextDoubt(1), "wide");
  if (DATA.in_file && !state.confirmed && tracks.some(track => track.label >= 0)) keyed(tab, "\u21e7Enter", "All labels of this trial are right", confirmAll, "wide");
  if (state.confirmed) make("p", tab, "You said that all labels are right; a model can learn from them.");
  keyed(tab, "K", "Name markers from a list", () => showTab("names"), "wide");
}

// Where the label is now that the pointer is on.
function hint(label) {
  view.hovered = label === null ? -1 : names.indexOf(label);
  refresh();
}

function optionFor(digit) {
  if (digit === 0) return null;
  return options.filter(one => one.label !== null)[digit - 1]?.label;
}

function assign(label) {
  const track = trackInHand();
  if (!track || label === undefined) return;
  if (state.proposal) return toast("Accept or refuse first");
  send({kind: "assign", track: track.index, ...framesMeant(track), label});
}

function confirm() {
  const track = trackInHand();
  if (!track) return nextDoubt(1);
  if (track.known) return nextDoubt(1);
  send({kind: "confirm", track: track.index}).then(done => done && nextDoubt(1));
}

function confirmAll() {
  if (state.proposal) return toast("Accept or refuse first");
  send({kind: "all"}).then(done => done && toast("Confirmed: all labels of this trial are right"));
}
