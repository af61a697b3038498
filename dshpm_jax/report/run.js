// The report of a run: tiles, charts and three tables over DATA, all built as text nodes, never as HTML.

const GOOD = ["labelled", "up to date", "passed over"], PART = ["partly labelled", "kept"];
const STEP = 25;  // rows of a table shown at first

const tone = outcome => GOOD.includes(outcome) ? "good" : PART.includes(outcome) ? "warn" : "bad";
const percent = x => x == null ? "" : x === 1 ? "100 %" : (Math.floor(1000 * x) / 10).toFixed(1) + " %";
const count = x => x == null ? "" : x.toLocaleString("en");
const seconds = x => x == null ? "" : x >= 7200 ? (x / 3600).toFixed(1) + " h" : x >= 100 ? count(Math.round(x)) + " s"
  : x.toFixed(x < 1 ? 2 : 1) + " s";
const sum = (rows, key) => rows.reduce((total, row) => total + (row[key] ?? 0), 0);

function make(tag, parent, text, className) {
  const node = document.createElement(tag);
  if (text != null) node.textContent = text;
  if (className) node.className = className;
  parent?.append(node);
  return node;
}

function meter(cell, share) {
  if (share == null) return;
  const fill = make("i", make("span", cell, null, "meter"));
  fill.style.width = 100 * share + "%";
  cell.append(percent(share));
}

function fileLink(cell, file) {
  const target = file.page ?? file.link;
  const name = make(target ? "a" : "span", cell, file.name);
  if (target) name.href = target;
  name.title = file.input ?? "";
}

// A sortable, searchable table. A column: title, key (what to sort by), show(cell, row), number, falling (sorts so first).
function table(section, columns, rows, sorted, text) {
  const node = make("table", make("div", section, null, "wide"));
  const head = make("tr", make("thead", node)), body = make("tbody", node);
  const more = make("button", section, null, "more");
  let by = sorted, falling = by.falling ?? false, limit = STEP, wanted = () => true;

  const compare = (a, b) => {
    const [x, y] = [by.key(a), by.key(b)];
    if (x == null || y == null) return (x == null) - (y == null);  // what is not known comes last
    return (typeof x === "number" ? x - y : x.localeCompare(y)) * (falling ? -1 : 1);
  };
  const draw = () => {
    const shown = rows.filter(wanted).sort(compare);
    body.replaceChildren();
    for (const row of shown.slice(0, limit)) {
      const line = make("tr", body);
      for (const column of columns) column.show(make("td", line, null, column.kind), row);
    }
    for (const [k, column] of columns.entries()) {
      const order = column === by ? (falling ? "descending" : "ascending") : "none";
      head.children[k].setAttribute("aria-sort", order);
    }
    more.hidden = shown.length <= limit;
    more.textContent = `Show ${count(Math.min(10 * STEP, shown.length - limit))} more of ${count(shown.length)}`;
  };
  for (const column of columns) {
    make("button", make("th", head, null, column.kind), column.title).onclick = () => {
      falling = column === by ? !falling : column.falling ?? false;
      by = column;
      draw();
    };
  }
  more.onclick = () => { limit += 10 * STEP; draw(); };
  const search = section.querySelector("input");
  let chosen = () => true;
  const filter = () => {
    const word = search.value.toLowerCase();
    wanted = row => chosen(row) && (!word || text(row).toLowerCase().includes(word));
    limit = STEP;
    draw();
  };
  search.oninput = filter;
  draw();
  return test => { chosen = test; filter(); };
}

function histogram(title, about, values, places, format) {
  if (!values.length) return;
  const box = make("div", document.getElementById("charts"));
  make("span", make("h3", box, title), ` ${about}`, "soft");
  const bars = make("div", box, null, "bars"), scale = make("div", box, null, "scale");
  const counts = places.slice(1).map(() => 0);
  for (const value of values) {
    let k = places.findIndex(edge => value < edge) - 1;
    counts[k < 0 ? counts.length - 1 : k] += 1;
  }
  const top = Math.max(...counts);
  for (const [k, n] of counts.entries()) {
    const bar = make("div", bars);
    bar.style.height = n ? `max(3px, ${100 * n / top}%)` : 0;
    bar.title = `${format(places[k])} to ${format(places[k + 1])}: ${count(n)} files`;
  }
  for (const edge of [places[0], places[counts.length >> 1], places.at(-1)]) make("span", scale, format(edge));
}

function even(low, high, steps) {
  return Array.from({length: steps + 1}, (_, k) => low + (high - low) * k / steps);
}

const files = DATA.files;
document.querySelector("h1").textContent = DATA.name;

// Tiles: totals; those of outcomes choose files.
const tiles = document.getElementById("tiles");
function tile(value, name, tag = "div", className = "") {
  const node = make(tag, tiles, null, "tile");
  make("b", node, value, className);
  make("span", node, name);
  return node;
}
const outcomes = [...new Set(files.map(file => file.outcome))];
const severity = outcome => ["bad", "warn", "good"].indexOf(tone(outcome));
outcomes.sort((a, b) => severity(b) - severity(a) || a.localeCompare(b));
let only = null;
for (const outcome of outcomes) {
  const n = files.filter(file => file.outcome === outcome).length;
  const node = tile(count(n), outcome, "button", tone(outcome));
  node.title = "Show these files only";
  node.onclick = () => {
    only = only === outcome ? null : outcome;
    for (const other of tiles.querySelectorAll("button")) other.ariaPressed = other === node && only !== null;
    chooseFiles(file => only === null || file.outcome === only);
  };
}
tile(count(sum(files, "frames")), "frames");
tile(`${count(sum(files, "labelled_trajectories"))} of ${count(sum(files, "trajectories"))}`, "trajectories labelled");
const timed = files.filter(file => file.seconds != null);
if (timed.length) tile(seconds(sum(timed, "seconds")), "labelling");

// Charts.
const known = key => files.map(file => file[key]).filter(value => value != null);
const whole = x => Math.round(100 * x) + " %";
histogram("Completeness", "files by share of markers found", known("completeness"), even(0, 1, 20), whole);
const doubted = known("confidence").map(c => Math.max(c, 0.8));
const fromLow = x => (x === 0.8 ? "up to " : "") + x.toFixed(2);
histogram("Confidence", "files by mean over their labels", doubted, even(0.8, 1, 20), fromLow);
const longest = timed.reduce((most, file) => Math.max(most, file.seconds), 0);
histogram("Time", "files by seconds taken", timed.map(file => file.seconds), even(0, longest * 1.001 || 1, 20), seconds);
if (!known("completeness").length) document.getElementById("charts").parentNode.hidden = true;

// Files, the worst first.
const numeric = (title, key, format, falling = true) => (
  {title, kind: "number", falling, key: row => row[key], show: (cell, row) => cell.append(format(row[key]))});
const measured = (title, key) => ({title, kind: "word", key: row => row[key], show: (cell, row) => meter(cell, row[key])});
const outcomeColumn = {
  title: "Outcome", kind: "word", key: file => severity(file.outcome) * 10 + (file.completeness ?? 0),
  show: (cell, file) => make("span", cell, file.outcome, tone(file.outcome)),
};
const fileColumns = [
  outcomeColumn,
  {
    title: "File", key: file => file.name,
    show: (cell, file) => {
      fileLink(cell, file);
      if (file.message) make("small", cell, file.message);
    },
  },
  measured("Completeness", "completeness"),
  numeric("Confidence", "confidence", x => x == null ? "" : x.toFixed(3), false),
  numeric("To look at", "suspects", x => x ? count(x) : ""),
  {
    title: "Trajectories", kind: "number", falling: true, key: file => file.trajectories,
    show: (cell, file) => {
      if (file.trajectories != null) cell.append(`${count(file.labelled_trajectories)} of ${count(file.trajectories)}`);
    },
  },
  numeric("Frames", "frames", count),
  ...(timed.length ? [numeric("Time", "seconds", seconds)] : []),
];
const [filesSection, suspectsSection, markersSection] = ["files", "suspects", "markers"].map(id => document.getElementById(id));
const say = (section, text) => section.querySelector(".soft").textContent = text;
say(filesSection, "the worst first; names lead to the result, or to its page where 'dshpm-jax view' has made one");
const chooseFiles = table(filesSection, fileColumns, files, outcomeColumn, file => `${file.name} ${file.message ?? ""}`);

// Labels to look at, those with most at stake first.
const fileOf = row => files[row.file];
const stake = numeric("At stake", "stake", seconds);
const suspectColumns = [
  stake,
  {
    title: "Label", key: row => row.label ?? "",
    show: (cell, row) => make("span", cell, row.label ?? "withheld", row.label ? "" : "soft"),
  },
  {title: "Could be", key: row => row.could_be[0], show: (cell, row) => cell.append(row.could_be.join(" or "))},
  numeric("Confidence", "confidence", x => x.toFixed(3), false),
  {
    title: "File", key: row => fileOf(row).name,
    show: (cell, row) => {
      fileLink(cell, fileOf(row));
      if (fileOf(row).page) cell.querySelector("a").href += "#" + new URLSearchParams({frame: row.first, marker: row.label ?? ""});
    },
  },
  {
    title: "Frames from 0", kind: "number", key: row => row.first,
    show: (cell, row) => cell.append(`${row.first} to ${row.last}`),
  },
  numeric("Length", "seconds", seconds),
  {title: "Reason", key: row => row.reason, show: (cell, row) => cell.append(row.reason)},
];
const some = DATA.all_suspects > DATA.suspects.length ? `the first ${count(DATA.suspects.length)} of ${count(DATA.all_suspects)}: ` : "";
say(suspectsSection, some + `less sure than ${DATA.sure}, or withheld because two labels fit almost equally well, as where two `
  + "are swapped; by the seconds expected to be wrong");
table(suspectsSection, suspectColumns, DATA.suspects, stake, row => `${fileOf(row).name} ${row.label ?? ""} ${row.could_be.join(" ")}`);

// Markers, the one found least first.
const found = measured("Found", "found");
const markerColumns = [
  {title: "Label", key: row => row.label, show: (cell, row) => cell.append(row.label)},
  found,
  numeric("Confidence", "confidence", x => x == null ? "" : x.toFixed(3), false),
  numeric("Gaps", "gaps", count),
  numeric("Longest gap", "longest", x => x ? seconds(x) : ""),
  numeric("Files", "files", count),
  numeric("Never found in", "absent", x => x ? count(x) : ""),
];
say(markersSection, "over all files whose model has them; the one found in the smallest share of frames first");
table(markersSection, markerColumns, DATA.markers, found, row => row.label);
for (const section of [suspectsSection, markersSection]) section.hidden = !section.querySelector("tbody").childElementCount;
