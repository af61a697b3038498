// To begin with: colours, texts, and what the address says.

function dress() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "faint", "line", "panel", "accent"]) theme[name] = style.getPropertyValue(`--${name}`);
  theme.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  drawTimeline();
  refresh();
}

document.querySelector("h1").textContent = DATA.name;
element("about").textContent = `${names.length} labels, ${frames.toLocaleString("en")} frames, `
  + `${(frames / rate).toFixed(1)} s at ${+rate.toFixed(2)} Hz${DATA.solves ? "" : ", labels only: nothing else is solved anew"}`;
for (const trouble of DATA.troubles) make("p", element("troubles"), trouble);
element("troubles").hidden = !DATA.troubles.length;
make("span", element("legend"), "Sure", "words");
for (const [, colour, text] of [...SURENESS, [0, SET, "set by you"]]) {
  const entry = make("span", element("legend"));
  make("i", entry).style.background = colour;
  entry.append(text);
}
trialsKnown = QUEUE;
take(DATA);
matchMedia("(prefers-color-scheme: dark)").onchange = dress;
new ResizeObserver(() => { dress(); fit(); draw(); }).observe(stage);
dress();
show(0);
lookFrom("start");
tellQueue();
tellDone();
tellSaved("");

const wanted = new URLSearchParams(location.hash.slice(1));
showTab(wanted.get("tab") ?? (names.length && tracks.some(track => track.label >= 0) ? "label" : "names"));
if (wanted.has("frame")) show(+wanted.get("frame"));
else if (doubts.length) nextDoubt(1);
else select(-1);
document.body.dataset.ready = "yes";

// For who drives the page by mouse: where a place in the room (mm, as the file has it) is in the window.
window.reviewPlace = at => {
  const box = canvas.getBoundingClientRect(), [x, y] = camera()(DATA.axes.map(axis => at[axis]));
  return [box.left + x, box.top + y];
};
