// Elements made of text, never of HTML, and numbers as people read them.

const element = id => document.getElementById(id);

function make(tag, parent, text, className) {
  const node = document.createElement(tag);
  if (text != null) node.textContent = text;
  if (className) node.className = className;
  parent?.append(node);
  return node;
}

// A button with its key in front.
function keyed(parent, key, text, act, className) {
  const node = make("button", parent, null, className);
  if (key) make("kbd", node, key);
  if (text) make("span", node, text);
  node.onclick = act;
  return node;
}

const percent = share => share >= 0.995 ? (share >= 0.9995 ? "100 %" : "> 99 %") : share < 0.01 ? "< 1 %" : `${Math.round(100 * share)} %`;
const seconds = x => x >= 100 ? `${Math.round(x)} s` : `${x.toFixed(x < 1 ? 2 : 1)} s`;
const several = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
const labelText = label => label ?? "no label";

// A name that may break after each folder.
function breakable(node, name) {
  for (const part of name.split(/(?<=[/_])/)) node.append(part, document.createElement("wbr"));
  return node;
}
