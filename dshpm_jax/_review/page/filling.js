// Gaps that can be filled: looked at one by one, accepted or left open; nothing is filled unless somebody says so.

let gaps = null, gapInHand = -1, filling = false;

function staleGaps() {
  if (filling) return;  // which changes no label
  gaps = null;
  if (!element("gaps-tab").hidden) loadGaps();
}

async function loadGaps() {
  const tab = element("gaps-tab");
  if (gaps) return tellGaps();
  tab.replaceChildren();
  make("p", tab, "Looking for gaps \u2026", "soft");
  const version = state.version;
  try {
    const found = await call(`gaps/${DATA.id}/${version}`);
    if (version !== state.version) return;
    gaps = found;
    gapInHand = Math.min(gapInHand, gaps.length - 1);
  } catch (error) {
    tab.replaceChildren();
    make("p", tab, error.message, "soft");
    return;
  }
  tellGaps();
  tellErrors(gaps);
}

// Expected errors come some at a time.
async function tellErrors(mine) {
  for (let first = 0; gaps === mine && first >= 0 && mine.length;) {
    const version = state.version, found = await call(`errors/${DATA.id}/${version}/${first}`).catch(() => []);
    found.forEach(([body, spline], k) => Object.assign(mine[first + k], {body, spline}));
    if (gaps === mine) tellGaps();
    if (!found.length && version === state.version) return;
    first = mine.findIndex(gap => gap.body === undefined);
  }
}

const millimetres = x => x === undefined ? "\u2026" : x === null ? "?" : `${x < 10 ? x.toFixed(1) : Math.round(x)} mm`;

function tellGaps() {
  const tab = element("gaps-tab"), place = tab.querySelector(".gaps")?.scrollTop ?? 0;
  if (!gaps || tab.hidden) return;
  tab.replaceChildren();
  const filled = gaps.filter(gap => gap.accepted).length;
  make("h2", tab, gaps.length ? `${several(gaps.length, "gap")}, ${filled} filled` : "No gap can be filled");
  if (!gaps.length) return;
  make("p", tab, "Expected errors, from gaps of the same length opened elsewhere: by the body, and by a spline. Filled points are marked as computed in the file.", "soft");
  const list = make("div", tab, null, "gaps");
  const head = make("div", list, null, "gap heads soft");
  for (const text of ["Marker", "Frames", "Body", "Spline", ""]) make("span", head, text);
  for (const [k, gap] of gaps.entries()) {
    const node = make("button", list, null, `gap${k === gapInHand ? " now" : ""}${gap.accepted ? " filled" : ""}`);
    make("b", node, names[gap.marker]);
    make("span", node, `${gap.first}\u2013${gap.last}`, "soft");
    make("span", node, millimetres(gap.body), "number");
    make("span", node, millimetres(gap.spline), "number soft");
    make("span", node, gap.accepted ? "\u2713" : "", "number");
    node.onclick = () => showGap(k);
  }
  list.scrollTop = place;
  list.children[gapInHand + 1]?.scrollIntoView({block: "nearest"});
  const tools = make("div", tab, null, "answers");
  keyed(tools, "Enter", "Fill", () => fillGap(true), "main");
  keyed(tools, "\u232b", "Leave open", () => fillGap(false));
  keyed(tools, "N", "Next", () => stepGap(1));
}

function showGap(k) {
  gapInHand = k;
  const gap = gaps[k];
  play(false);
  select(-1);
  view.chosen = gap.marker;
  show(Math.round((gap.first + gap.last) / 2));
  scrollToRow(gap.marker);
  drawTimeline();
  tellGaps();
}

function stepGap(by) {
  if (!gaps?.length) return;
  showGap((gapInHand + by + gaps.length) % gaps.length);
}

async function fillGap(accepted) {
  const gap = gaps?.[gapInHand];
  if (!gap) return stepGap(1);
  if (gap.accepted !== accepted) {
    filling = true;
    const done = await send({kind: "fill", marker: names[gap.marker], first: gap.first, last: gap.last + 1, accepted});
    filling = false;
    if (!done) return;
    gap.accepted = accepted;
  }
  stepGap(1);
}

// The way through the gap in hand, and the points of gaps that are filled.
function drawGaps(project) {
  if (!gaps || element("gaps-tab").hidden) return;
  for (const [k, gap] of gaps.entries()) {
    const inside = view.frame >= gap.first && view.frame <= gap.last;
    if (k !== gapInHand && !(gap.accepted && inside)) continue;
    if (k === gapInHand) {
      pen.beginPath();
      for (const at of gap.path) {
        const [x, y] = project(at);
        pen.lineTo(x, y);
      }
      pen.lineWidth = 1.6;
      pen.strokeStyle = SET;
      pen.stroke();
    }
    if (!inside) continue;
    const [x, y] = project(gap.path[view.frame - gap.first]);
    pen.beginPath();
    pen.arc(x, y, 4, 0, 7);
    pen.fillStyle = SET;
    pen.fill();
  }
}
