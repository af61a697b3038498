// Names from a list given to points by clicking: a still, or any frame, labelled from nothing.

let naming = false, current = 0, sources = null;

const isHere = name => shownTracks.some(track => track.label === name && track.first <= view.frame && view.frame <= track.last);

function tellNames() {
  const tab = element("names-tab");
  if (tab.hidden) return;
  const place = tab.querySelector(".names")?.scrollTop ?? 0;
  tab.replaceChildren();
  const count = names.filter((_, k) => isHere(k)).length;
  make("h2", tab, names.length ? `${count} of ${names.length} are in this frame` : "No names yet");
  if (names.length) {
    make("p", tab, "Click the point of the name in blue; the next name follows. The name holds for the whole trajectory.", "soft");
    const list = make("div", tab, null, "names");
    for (const [k, name] of names.entries()) {
      const node = make("button", list, null, k === current ? "now" : "");
      make("i", node).style.background = colourOf(k);
      make("span", node, name, "what");
      make("span", node, isHere(k) ? "\u2713" : "", "number");
      node.onclick = () => { current = k; tellNames(); };
    }
    list.scrollTop = place;
    list.children[current]?.scrollIntoView({block: "nearest"});
    const tools = make("div", tab, null, "tools");
    keyed(tools, "Enter", "Name the point in hand", () => nameTrack(trackInHand()));
    keyed(tools, "\u21e7\u2193", "Skip", () => stepName(1));
  }
  tellSources(tab);
}

function stepName(by) {
  if (!names.length) return;
  current = (current + by + names.length) % names.length;
  tellNames();
}

function nextName() {
  for (let k = 1; k <= names.length; k++) {
    const next = (current + k) % names.length;
    if (!isHere(next)) { current = next; break; }
  }
  tellNames();
}

async function nameTrack(track) {
  if (!track || !names.length) return toast(names.length ? "Choose a point first" : "Choose where the names come from");
  anchor = {slot: track.slot, frame: view.frame};
  if (await send({kind: "assign", track: track.index, first: track.first, last: track.last + 1, label: names[current]})) nextName();
}

async function tellSources(tab) {
  if (DATA.knows_body) return;  // its names are those of its model
  const box = make("div", tab, null, "sources"), about = make("label", box, "Names from "), list = make("select", about);
  sources ??= await call("names").catch(() => []);
  make("option", list, names.length ? "as they are" : "choose \u2026").value = "";
  for (const {id, text, count} of sources) make("option", list, `${text}, ${several(count, "name")}`).value = id;
  list.onchange = () => list.value && giveNames({source: list.value});
  const own = make("input", box);
  own.placeholder = "Add names: LASI RASI \u2026";
  own.setAttribute("aria-label", "Add names, with blanks between");
  own.onkeydown = event => {
    event.stopPropagation();
    if (event.key === "Enter" && own.value.trim()) giveNames({add: own.value.trim().split(/[\s,;]+/)});
  };
}

async function giveNames(body) {
  try {
    await call(`names/${DATA.id}`, {version: state.version, ...body});
    openTrial(DATA.id, {tab: "names", frame: view.frame});
  } catch (error) {
    toast(error.message);
  }
}
