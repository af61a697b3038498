// A row for each trial, those that need somebody first, with its doubts folded beneath.

const FIELDS = ["name", "outcome", "stake", "doubts", "confidence", "completeness", "frames", "labelled", "trajectories", "seconds"];
const trials = DATA.trials.map(list => Object.fromEntries([...FIELDS, "more"].map((field, k) => [field, list[k]])));
const all = DATA.all;
document.querySelector("h1").textContent = DATA.name;

// The trial's page, if there is one.
function pageOf(trial) {
  const {page} = trial.more;
  return page === 1 ? trial.name.replace(/\.[^./]*$/, ".html") : page;
}

function linked(parent, page, className) {
  const node = make(page ? "a" : "span", parent, null, className);
  if (page) node.href = page;
  return node;
}

const nameColumn = {
  title: "Trial", key: trial => trial.name,
  show: (cell, trial) => {
    breakable(linked(cell, pageOf(trial), "name"), trial.name);
    if (trial.more.said) make("small", cell, trial.more.said, "soft");
    for (const why of trial.more.why ?? []) make("small", cell, why, tone(trial.outcome) === "good" ? "soft" : tone(trial.outcome));
  },
};
const outcomeColumn = {
  title: "Outcome", kind: "outcome", key: trial => severity(trial.outcome) * 10 + (trial.completeness ?? 0),
  show: (cell, trial) => make("span", cell, trial.outcome, tone(trial.outcome)),
};
const stakeColumn = {
  title: "In doubt", kind: "number", falling: true, key: trial => trial.stake || null,
  show: (cell, trial) => {
    if (trial.doubts) make("button", cell, seconds(trial.stake), "fold").title = "Show the doubts";
    if (trial.doubts) make("small", cell, several(trial.doubts, "doubt"));
  },
};
const trialColumns = [
  outcomeColumn, nameColumn, stakeColumn,
  measured("Completeness", "completeness", "second"),
  numeric("Confidence", "confidence", x => x == null ? "" : x.toFixed(3), {kind: "third", falling: false}),
  {
    title: "Trajectories", kind: "number third", falling: true, key: trial => trial.trajectories,
    show: (cell, trial) => {
      if (trial.trajectories != null) cell.append(`${count(trial.labelled)} of ${count(trial.trajectories)}`);
    },
  },
  numeric("Frames", "frames", count, {kind: "third"}),
  ...(trials.some(trial => trial.seconds != null) ? [numeric("Took", "seconds", seconds, {kind: "third"})] : []),
];

// A line for each doubt: the label and where it is, how long, how likely, and why; it leads to the place on the page.
function listDoubts(trial) {
  const list = DATA.doubts[trial.name], page = pageOf(trial);
  if (!list) return trial.doubts ? cell => make("p", cell, "Listed on the trial's page only", "soft") : null;
  return cell => {
    const lines = make("div", cell, null, "doubts");
    for (const [label, first, last, length, chance, cause, ...couldBe] of list) {
      const line = linked(lines, page && page + "#" + new URLSearchParams({frame: first, ...(label ? {marker: label} : {}), doubt: 1}), "doubt");
      make("b", line, label ?? "no label");
      make("span", line, seconds(length), "number");
      make("span", line, `frames ${first}\u2013${last}`, "frames");
      const may = couldBe.length ? `may be ${couldBe.join(" or ")}: ` : "";
      make("span", line, `${may}${DATA.causes[cause]}; ${Math.floor(100 * chance)} % sure`, "why");
    }
    if (list.length < trial.doubts) make("p", cell, `and ${count(trial.doubts - list.length)} shorter ones`, "soft");
    if (!page) make("p", cell, "Its page is not made yet: dshpm-jax view makes it", "soft");
  };
}

const trialsSection = document.getElementById("trials");
const some = trials.length < all.trials ? `the first ${count(trials.length)} of ${count(all.trials)}, the others are in summary.csv; ` : "";
say(trialsSection, `${some}what needs you first: by outcome, then by the seconds of points in doubt, that is labels less sure than ${DATA.sure} or withheld`);
const chooseTrials = table(trialsSection, trialColumns, trials, {
  text: trial => `${trial.name} ${trial.outcome} ${(trial.more.why ?? []).join(" ")}`, fold: listDoubts,
});

// Those of one outcome and of one subject only.
const folderOf = trial => trial.name.slice(0, Math.max(trial.name.lastIndexOf("/"), 0));
const only = {outcome: null, subject: null};
const onlyNode = document.getElementById("only");
function choose(what, value) {
  only[what] = only[what] === value ? null : value;
  chooseTrials(trial => (only.outcome === null || trial.outcome === only.outcome)
    && (only.subject === null || folderOf(trial) === only.subject));
  for (const node of document.querySelectorAll(`[data-${what}]`)) node.ariaPressed = String(node.dataset[what] === only[what]);
  onlyNode.hidden = only.subject === null;
  onlyNode.textContent = `\u00d7 ${only.subject || "no folder"}`;
}
onlyNode.onclick = () => choose("subject", only.subject);

// Tiles: totals; those of outcomes choose trials.
const tiles = document.getElementById("tiles");
function tile(value, name, tag = "div", className = "") {
  const node = make(tag, tiles, null, "tile");
  make("b", node, value, className);
  make("span", node, name);
  return node;
}
const outcomes = Object.keys(all.outcomes).sort((a, b) => severity(a) - severity(b));
for (const outcome of outcomes) {
  const node = tile(count(all.outcomes[outcome]), outcome, "button", tone(outcome));
  node.title = "Show these trials only";
  node.dataset.outcome = outcome;
  node.onclick = () => choose("outcome", outcome);
}
if (all.doubts) tile(seconds(all.stake), `in ${several(all.doubts, "doubt")}`);
tile(count(all.sums.frames), "frames");
tile(`${count(all.sums.labelled_trajectories)} of ${count(all.sums.trajectories)}`, "trajectories labelled");
if (all.sums.seconds) tile(seconds(all.sums.seconds), "labelling");
