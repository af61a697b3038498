// What a click picks, and keys.

function choose(column) {
  view.chosen = column === view.chosen ? -1 : column;
  drawTimeline();
  refresh();
}

const pick = column => choose(column < names.length ? column : -1);

slider.max = frames - 1;
slider.oninput = () => show(+slider.value);
element("pause").onclick = () => play(!view.playing);
for (const id of ["named", "others"]) element(id).onchange = refresh;
element("follow").onchange = () => { fit(); refresh(); };
for (const where of ["front", "side", "top"]) element(where).onclick = () => lookFrom(where);
element("earlier").onclick = () => goToDoubt(-1);
element("later").onclick = () => goToDoubt(1);
addEventListener("keydown", event => {
  const {tagName, type} = event.target;
  if (["SELECT", "TEXTAREA"].includes(tagName) || (tagName === "INPUT" && !["range", "checkbox"].includes(type))) return;
  const far = event.shiftKey ? 10 : 1;
  const keys = {
    " ": () => play(!view.playing), arrowleft: () => show(view.frame - far), arrowright: () => show(view.frame + far),
    home: () => show(0), end: () => show(frames - 1), n: () => goToDoubt(1), p: () => goToDoubt(-1),
    f: () => lookFrom("front"), s: () => lookFrom("side"), t: () => lookFrom("top"), r: () => lookFrom("start"),
    l: () => element("named").click(), u: () => element("others").click(),
  };
  const key = event.key.toLowerCase();
  if (!keys[key] || event.ctrlKey || event.metaKey || event.altKey) return;
  if (key === " " && event.target.tagName === "BUTTON") return;  // which it presses
  event.preventDefault();
  keys[key]();
});
