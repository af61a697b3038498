// The mouse on figure and timeline; what a click picks is said elsewhere.

function showTip(text, event) {
  tip.hidden = !text;
  tip.textContent = text;
  tip.style.left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8) + "px";
  tip.style.top = Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8) + "px";
}

function nearest(event) {
  const box = canvas.getBoundingClientRect(), [x, y] = [event.clientX - box.left, event.clientY - box.top];
  let best = -1, least = 12;
  for (const dot of dots) {
    const distance = Math.hypot(dot.x - x, dot.y - y) - (dot.column < names.length ? 2 : 0);
    if (distance <= least) [best, least] = [dot.column, distance];
  }
  return best;
}

let held = null;  // a drag: where it began and whether it moved
canvas.onpointerdown = event => {
  canvas.setPointerCapture(event.pointerId);
  held = {x: event.clientX, y: event.clientY, move: event.shiftKey || event.button !== 0, moved: false};
};
canvas.onpointermove = event => {
  if (!held) {
    view.hovered = nearest(event);
    showTip(view.hovered < 0 ? "" : describe(view.hovered, view.frame), event);
    return refresh();
  }
  const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
  if (!held.moved && Math.hypot(dx, dy) < 3) return;
  if (held.move) view.shift = [view.shift[0] + dx, view.shift[1] + dy];
  else [view.yaw, view.pitch] = [view.yaw - dx * 0.008, Math.max(-1.57, Math.min(1.57, view.pitch + dy * 0.008))];
  Object.assign(held, {x: event.clientX, y: event.clientY, moved: true});
  tip.hidden = true;
  refresh();
};
canvas.onpointerup = event => {
  if (held && !held.moved) pick(nearest(event));
  held = null;
};
canvas.onpointercancel = () => { held = null; };
canvas.onpointerleave = () => { tip.hidden = true; view.hovered = -1; refresh(); };
canvas.oncontextmenu = event => event.preventDefault();
canvas.onwheel = event => {
  event.preventDefault();
  view.zoom = Math.max(0.1, Math.min(40, view.zoom * Math.exp(-event.deltaY * 0.0015)));
  refresh();
};
canvas.ondblclick = () => lookFrom("start");

timeline.onpointermove = event => {
  const row = rowAt(event.offsetY), frame = frameAt(event.offsetX, scroll.clientWidth);
  showTip(event.offsetX < GUTTER ? "" : describeRow(row, frame), event);
  if (event.buttons) show(frame);
};
timeline.onpointerleave = () => { tip.hidden = true; };
timeline.onpointerdown = event => {
  const row = rowAt(event.offsetY);
  if (event.offsetX >= GUTTER) show(frameAt(event.offsetX, scroll.clientWidth));
  if (row.column != null && (event.offsetX < GUTTER || row.column !== view.chosen)) choose(row.column);
};
