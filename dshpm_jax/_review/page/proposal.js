// What the program answers: kept at once, or proposed because other labels change as well.

let before = Promise.resolve(), waitingFor = 0;  // what is asked goes out one by one

// What is about a trajectory is about the labels that are shown now; the rest about those that there are by then.
function send(body) {
  const version = "track" in body || "one" in body ? state.version : null;
  before = before.then(() => ask(body, version ?? state.version));
  return before;
}

async function ask(body, version) {
  waitingFor += 1;
  const late = setTimeout(() => document.body.classList.add("busy"), 120);
  try {
    takeAnswer(await call(`do/${DATA.id}`, {version, ...body}));
    return !state.proposal;
  } catch (error) {
    toast(error.message);
    if (error.status === 409) takeAnswer(await call(`trial/${DATA.id}`).catch(() => state));
    return false;
  } finally {
    clearTimeout(late);
    waitingFor -= 1;
    if (!waitingFor) document.body.classList.remove("busy");
  }
}

let tabBefore = null;  // a proposal is shown in the first tab; then the one before comes again

function takeAnswer(found) {
  const earlier = state.version;
  take(found);
  if (state.proposal && tabShown() !== "label") {
    tabBefore = tabShown();
    showTab("label");
  } else if (!state.proposal && tabBefore) {
    showTab(tabBefore);
    tabBefore = null;
    if (naming && isHere(current)) nextName();
  }
  if (!state.proposal) setExtentQuietly();
  selectAgain();
  tellDone();
  tellNames();
  tellQueue();
  if (state.version !== earlier) {
    tellSaved("kept");
    watchSaving();
    staleGaps();
  }
}

function setExtentQuietly() {
  [extent, marks] = ["whole", {in: null, out: null}];
}

function tellProposal(tab) {
  const {text, others} = state.proposal;
  make("h2", tab, text);
  make("p", tab, `This also changes ${others.length === 1 ? "another label" : `${others.length} other labels`}. Nothing counts before you accept.`);
  const list = make("div", tab, null, "changes");
  for (const {was, now, frames: count, first, last} of others) {
    const node = make("button", list);
    make("span", node, labelText(was), "was");
    make("span", node, "\u2192");
    make("span", node, labelText(now), "now");
    make("span", node, `${first}\u2013${last}, ${seconds(count / rate)}`, "soft");
    node.onclick = () => show(Math.round((first + last) / 2));
  }
  const foot = make("div", tab, null, "answers");
  keyed(foot, "Enter", "Accept all", () => send({kind: "accept"}), "main");
  keyed(foot, "J", "Just mine", () => send({kind: "accept", mine_only: true}));
  keyed(foot, "Esc", "Refuse", () => send({kind: "refuse"}));
}

function tellSaved(text, trouble = "") {
  element("saved").textContent = trouble || text;
  element("saved").className = trouble ? "bad" : "soft";
}

let watching = null;
function watchSaving() {
  clearTimeout(watching);
  watching = setTimeout(async () => {
    const {saved, trouble} = await call("status").catch(error => ({trouble: error.message}));
    tellSaved(saved ? DATA.in_file ? "written to the files" : "kept in this session" : "kept", trouble);
    if (!saved) watchSaving();
    else refreshQueue();
  }, 1500);
}

let toastEnds = null;
function toast(text) {
  element("toast").textContent = text;
  element("toast").hidden = false;
  clearTimeout(toastEnds);
  toastEnds = setTimeout(() => { element("toast").hidden = true; }, 5000);
}
