// Cut, exchange, join, any label by its name; undo and redo.

function tellTools(tab, track) {
  make("h3", tab, "Or");
  const group = make("div", tab, null, "tools");
  keyed(group, "Enter", track.known ? "Next" : "Right as it is", confirm);
  keyed(group, "C", "Cut here", cut);
  keyed(group, "X", "Exchange with \u2026", startExchange);
  keyed(group, "M", "Join with \u2026", startJoin);
}

function cut() {
  const track = trackInHand();
  if (!track) return toast("Choose a point first");
  if (view.frame <= track.first || view.frame > track.last) return toast("Go to a frame inside the trajectory, behind its first one");
  anchor.frame = view.frame;
  send({kind: "cut", track: track.index, frame: view.frame});
}

// Trajectories with a label in this frame, the nearest first.
function nearby(track) {
  const frame = Math.max(track.first, Math.min(track.last, view.frame)), here = slotPlace(frame, track.slot);
  return shownTracks.filter(one => one !== track && one.first <= frame && frame <= one.last)
    .map(one => ({one, far: Math.hypot(...slotPlace(frame, one.slot).map((x, k) => x - here[k]))}))
    .sort((a, b) => a.far - b.far);
}

function startExchange() {
  const track = trackInHand();
  if (!track) return toast("Choose a point first");
  if (track.label < 0) return toast("It has no label to exchange; give it one");
  const act = one => {
    if (one.label < 0) return toast("That one has no label to exchange");
    send({kind: "exchange", one: nameOf(track), other: nameOf(one), ...framesOfExchange(track)});
  };
  const found = nearby(track).filter(({one}) => one.label >= 0);
  const rank = one => options.findIndex(({label}) => label === nameOf(one));
  found.sort((a, b) => (rank(a.one) < 0) - (rank(b.one) < 0) || rank(a.one) - rank(b.one) || a.far - b.far);
  startChoosing(`Exchange ${nameOf(track)} with \u2026`, found.slice(0, 9).map(({one, far}) => ({one, text: nameOf(one), about: `${Math.round(far)} mm away`})), act);
}

// Marks may reach beyond the trajectory: an exchange is of labels.
function framesOfExchange(track) {
  if (extent !== "span") return framesMeant(track);
  const ends = [marks.in ?? track.first, marks.out ?? track.last];
  return {first: Math.min(...ends), last: Math.max(...ends) + 1};
}

// Trajectories that end before this one begins or begin behind it, those first that are near in time and place.
function startJoin() {
  const track = trackInHand();
  if (!track) return toast("Choose a point first");
  const found = [];
  for (const one of shownTracks) {
    const before = one.last < track.first;
    if (one === track || (!before && one.first <= track.last)) continue;
    const [from, to] = before ? [one, track] : [track, one], gap = (to.first - from.last) / rate;
    const [a, b] = [slotPlace(from.last, from.slot), slotPlace(to.first, to.slot)];
    const far = Math.hypot(...a.map((x, k) => x - b[k]));
    found.push({one, cost: far + 500 * gap, text: labelText(nameOf(one)), about: `${before ? "ends" : "begins"} ${seconds(gap)} ${before ? "before" : "behind"}, ${Math.round(far)} mm away`});
  }
  found.sort((a, b) => a.cost - b.cost);
  startChoosing(`Join ${labelText(nameOf(track))} with \u2026`, found.slice(0, 9), one => send({kind: "merge", track: track.index, with: one.index}));
}

function startChoosing(title, list, act) {
  choosing = {title, list, pick: one => { choosing = null; act(one); }};
  tellTrack();
}

function tellChoosing(tab) {
  make("h3", tab, choosing.title);
  const list = make("div", tab, null, "options");
  if (!choosing.list.length) make("p", list, "Nothing is near enough in time.", "soft");
  for (const [k, {one, text, about}] of choosing.list.entries()) {
    const node = keyed(list, String(k + 1), "", () => choosing.pick(one), "option two");
    make("span", node, text, "what");
    make("span", node, about, "soft");
    node.onpointerenter = () => { view.hovered = one.column; refresh(); };
  }
  make("p", tab, "Or click a point.", "soft");
  keyed(make("div", tab, null, "answers"), "Esc", "Leave it", stopChoosing);
  tellExtent();
}

function stopChoosing() {
  choosing = null;
  view.hovered = -1;
  tellTrack();
  refresh();
}

// Any label, by the beginning of its name.
function openFind() {
  const track = trackInHand();
  if (!track || state.proposal) return;
  const tab = element("label-tab"), box = make("div", null, null, "find"), input = make("input", box), list = make("div", box, null, "options");
  input.placeholder = "Label";
  input.setAttribute("aria-label", "Label");
  const matches = () => {
    const word = input.value.toLowerCase(), found = names.filter(name => name.toLowerCase().includes(word));
    return found.sort((a, b) => b.toLowerCase().startsWith(word) - a.toLowerCase().startsWith(word)).slice(0, 8);
  };
  const list_ = () => {
    list.replaceChildren();
    for (const [k, name] of matches().entries()) keyed(list, k ? "" : "Enter", name, () => assign(name), "option");
  };
  input.oninput = list_;
  input.onkeydown = event => {
    if (event.key === "Enter") { assign(matches()[0]); event.preventDefault(); }
    if (event.key === "Escape") tellTrack();
    event.stopPropagation();
  };
  tab.querySelector(".options").replaceWith(box);
  list_();
  input.focus();
}

function tellDone() {
  const tab = element("done-tab");
  for (const [id, key, text] of [["undo", "Z", "Undo"], ["redo", "Y", "Redo"]]) {
    const node = element(id), what = state[id];
    node.replaceChildren();
    make("kbd", node, key);
    make("span", node, text);
    if (what) make("span", node, what, "soft");
    node.disabled = !what;
    node.title = what ?? "";
    node.onclick = () => send({kind: id});
  }
  tab.replaceChildren();
  if (!state.history.length) make("p", tab, "Nothing was corrected yet. All that you do stands here, and can be taken back, also tomorrow.", "soft");
  if (state.history.length && DATA.learning.length) tellLearning(tab);
  for (const {text, time, by, stands} of [...state.history].reverse()) {
    const line = make("div", tab, null, stands ? "done" : "done gone");
    make("span", line, text);
    make("small", line, `${new Date(time).toLocaleString()}${by ? `, ${by}` : ""}${stands ? "" : ", undone"}`, "soft");
  }
}

// What was said can make the subject's model better, and the rest is labelled again with it.
function tellLearning(tab) {
  make("p", tab, "The model can learn from what you said and from labels that are sure. These commands make it again, and label with it what nobody confirmed; what you said stays:", "soft");
  make("pre", tab, DATA.learning.join("\n"), "command");
}
