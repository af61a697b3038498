// To begin with: colours, texts, and what the address says.

function dress() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "faint", "line", "panel", "accent"]) theme[name] = style.getPropertyValue(`--${name}`);
  theme.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  drawTimeline();
  refresh();
}

function fillLegend() {
  const entry = (colour, text) => {
    const node = document.createElement("span"), swatch = document.createElement("i");
    swatch.style.background = colour;
    node.append(swatch, text);
    element("legend").append(node);
  };
  if (!DATA.spans.length) return entry(NO_COLOUR, "seen; a gap where it is missing");
  element("legend").append("Confidence");
  for (const [, colour, words] of SURENESS) entry(colour, words);
}

// The address may say where to begin: #frame=100, #labels, #play, #marker=LKNE, #doubt, #view=top.
function obey() {
  const wanted = new URLSearchParams(location.hash.slice(1)), frame = +wanted.get("frame") || 0;
  if (wanted.has("labels")) element("named").checked = true;
  if (wanted.has("marker")) view.chosen = names.indexOf(wanted.get("marker"));
  const marked = span => span.first === frame && (!wanted.has("marker") || span.column === view.chosen);
  const k = wanted.has("doubt") ? doubts.findIndex(marked) : -1;
  if (k >= 0) showDoubt(k);
  else show(frame);
  lookFrom(wanted.get("view") in VIEWS ? wanted.get("view") : "start");
  if (wanted.has("play")) play(true);
}

document.querySelector("h1").textContent = DATA.name;
element("about").textContent = `${names.length} labels, ${frames.toLocaleString("en")} frames, `
  + `${(frames / rate).toFixed(1)} s at ${+rate.toFixed(2)} Hz`;
for (const kind of ["troubles", "notes"]) {
  for (const text of DATA[kind]) element(kind).append(Object.assign(document.createElement("p"), {textContent: text}));
  element(kind).hidden = !DATA[kind].length;
}
element("doubting").hidden = !doubts.length;
element("doubtkeys").hidden = !doubts.length;
tellDoubt();
fillLegend();
matchMedia("(prefers-color-scheme: dark)").onchange = dress;
new ResizeObserver(() => { dress(); fit(); draw(); }).observe(stage);
addEventListener("hashchange", obey);
dress();
obey();
