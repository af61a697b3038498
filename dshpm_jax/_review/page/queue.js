// The trials of the folder, those with the most at stake first, each with its doubts folded beneath.

let queueRows = null;

function listQueue({title, trials}, current, goTo) {
  element("folder").textContent = title;
  document.title = `${title}: review`;
  const stake = trials.reduce((sum, row) => sum + row.stake, 0), count = trials.reduce((sum, row) => sum + (row.count ?? 0), 0);
  element("left-over").textContent = count ? `${several(count, "doubt")}, ${seconds(stake)} at stake` : "nothing in doubt";
  const top = Math.max(...trials.map(row => row.stake), 0.01), list = element("trials"), place = list.scrollTop;
  list.replaceChildren();
  for (const row of trials) {
    const node = make("div", list, null, `trial${row.id === current ? " open" : ""}${row.opens ? "" : " shut"}`);
    const head = make("button", node, null, "row");
    head.disabled = !row.opens;
    head.title = row.why ?? `${row.name}: ${several(row.count, "doubt")}, ${seconds(row.stake)} of points likely wrong`;
    breakable(make("span", head, null, "name"), row.name.replace(/\.[^./]*$/, ""));
    make("span", head, row.new ? "new" : row.confirmed ? "\u2713 confirmed" : row.opens ? (row.count ? seconds(row.stake) : "\u2713") : "", "number");
    make("i", make("span", head, null, "stake")).style.width = `${100 * row.stake / top}%`;
    if (!row.opens) make("small", head, row.why);
    head.onclick = () => row.id === current ? node.classList.toggle("folded") : openTrial(row.id);
    if (row.id === current) for (const doubt of row.doubts) addDoubt(node, doubt, goTo);
  }
  list.scrollTop = place;
  element("search").oninput = () => {
    const word = element("search").value.toLowerCase();
    trials.forEach((row, k) => { list.children[k].hidden = !row.name.toLowerCase().includes(word); });
  };
}

function addDoubt(parent, doubt, goTo) {
  const node = make("button", parent, null, "doubt");
  make("b", node, doubt.label ?? "no label", doubt.given ? "" : "soft");
  make("span", node, `${doubt.first}\u2013${doubt.last}`, "soft");
  make("span", node, seconds(doubt.stake), "number");
  node.dataset.track = doubt.index;
  node.onclick = () => goTo(doubt);
}
