// Numbers and names as people read them, and elements made of text, never of HTML.

const TONES = {  // of outcomes, the worst first
  failed: "bad", kept: "warn", doubtful: "warn", "partly labelled": "warn", labelled: "good", "passed over": "good",
};
const tone = outcome => TONES[outcome] ?? "bad";
const severity = outcome => Object.keys(TONES).indexOf(outcome);  // one that nobody knows comes first

const percent = x => x == null ? "" : x === 1 ? "100 %" : (Math.floor(1000 * x) / 10).toFixed(1) + " %";
const count = x => x == null ? "" : x.toLocaleString("en");
const several = (n, word) => `${count(n)} ${word}${n === 1 ? "" : "s"}`;
const seconds = x => x == null ? "" : x >= 7200 ? (x / 3600).toFixed(1) + " h" : x >= 100 ? count(Math.round(x)) + " s"
  : x.toFixed(x < 1 ? 2 : 1) + " s";

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

// A name that may break after each folder, so that it fits into narrow columns.
function breakable(node, name) {
  for (const part of name.split(/(?<=[/_])/)) node.append(part, document.createElement("wbr"));
  return node;
}
