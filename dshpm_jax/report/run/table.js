// Tables that are sorted by a click, searched, and drawn a few rows at a time.

const STEP = 25;  // rows shown at first

// A column: title, key (what to sort by), show(cell, row), kind (a class), falling (sorts so first).
// `fold(row)` gives what to unfold beneath a row: a function that fills a cell, or nothing.
function table(section, columns, rows, {sorted, text, fold = () => null}) {
  const node = make("table", make("div", section, null, "wide"));
  const head = make("tr", make("thead", node)), body = make("tbody", node);
  const more = make("button", section, null, "more"), search = section.querySelector("input");
  let by = sorted, falling = by?.falling ?? false, limit = STEP, wanted = () => true, chosen = () => true;

  const compare = (a, b) => {
    const [x, y] = [by.key(a), by.key(b)];
    if (x == null || y == null) return (x == null) - (y == null);  // what is not known comes last
    return (typeof x === "number" ? x - y : x.localeCompare(y)) * (falling ? -1 : 1);
  };
  const draw = () => {
    const shown = rows.filter(wanted);
    if (by) shown.sort(compare);
    body.replaceChildren();
    for (const row of shown.slice(0, limit)) {
      const line = make("tr", body);
      for (const column of columns) column.show(make("td", line, null, column.kind), row, line);
      const fill = fold(row);
      if (fill) foldable(line, columns.length, fill);
    }
    for (const [k, column] of columns.entries()) {
      head.children[k].setAttribute("aria-sort", column === by ? (falling ? "descending" : "ascending") : "none");
    }
    more.hidden = shown.length <= limit;
    more.textContent = `Show ${count(Math.min(10 * STEP, shown.length - limit))} more of ${count(shown.length)}`;
    if (!shown.length) make("td", make("tr", body), "None", "soft").colSpan = columns.length;
  };
  const filter = () => {
    const word = search.value.toLowerCase();
    wanted = row => chosen(row) && (!word || text(row).toLowerCase().includes(word));
    limit = STEP;
    draw();
  };
  for (const column of columns) {
    make("button", make("th", head, null, column.kind), column.title).onclick = () => {
      falling = column === by ? !falling : column.falling ?? false;
      by = column;
      draw();
    };
  }
  more.onclick = () => { limit += 10 * STEP; draw(); };
  search.oninput = filter;
  draw();
  return test => { chosen = test; filter(); };
}

// A row that a click unfolds, anywhere but on its links.
function foldable(line, width, fill) {
  const button = line.querySelector("button.fold");
  let under = null;
  line.className = "folds";
  button.ariaExpanded = "false";
  line.onclick = event => {
    if (event.target.closest("a")) return;
    if (!under) {
      under = make("tr", null, null, "under");
      fill(Object.assign(make("td", under), {colSpan: width}));
      line.after(under);
    } else under.hidden = !under.hidden;
    button.ariaExpanded = String(!under.hidden);
  };
}

const numeric = (title, key, format, {kind = "", falling = true} = {}) => (
  {title, kind: `number ${kind}`, falling, key: row => row[key], show: (cell, row) => cell.append(format(row[key]))});
const measured = (title, key, kind = "") => (
  {title, kind: `word ${kind}`, key: row => row[key], show: (cell, row) => meter(cell, row[key])});
const say = (section, text) => section.querySelector(".soft").textContent = text;
