// The way of the trajectory in hand, for a moment to and fro.

const TRAIL_SECONDS = 0.35;

const outlined = () => {
  const track = trackInHand();
  return track && {...extentOf(track), column: track.column};
};

function drawMore(project) {
  tellExtent();
  drawGaps(project);
  const track = trackInHand();
  if (track) drawTrail(project, track);
}

function drawTrail(project, track) {
  const reach = Math.round(TRAIL_SECONDS * rate);
  const from = Math.max(track.first, view.frame - reach), to = Math.min(track.last, view.frame + reach);
  if (from > to) return;
  const inside = extentOf(track), step = Math.max(1, Math.round((to - from) / 120));
  for (const within of [false, true]) {
    pen.beginPath();
    for (let t = from; t < to; t += step) {
      const next = Math.min(t + step, to);
      if ((t >= inside.first && next <= inside.last) !== within) continue;
      const [a, b] = [t, next].map(frame => project(slotPlace(frame, track.slot)));
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
    }
    pen.lineWidth = within ? 1.6 : 1;
    pen.strokeStyle = within ? theme.ink : theme.faint;
    pen.stroke();
  }
  if (view.frame >= track.first && view.frame <= track.last) return;
  const [x, y] = project(slotPlace(view.frame < track.first ? track.first : track.last, track.slot));
  pen.beginPath();
  pen.arc(x, y, 7.5, 0, 7);
  pen.setLineDash([2, 3]);
  pen.strokeStyle = theme.ink;
  pen.stroke();
  pen.setLineDash([]);
}

// Moves the camera to the trajectory in hand.
function closeUp() {
  const track = trackInHand();
  if (!track) return toast("Choose a point first");
  if (view.zoom > 2) return lookFrom("start");
  const frame = Math.max(track.first, Math.min(track.last, view.frame)), {width, height} = canvas.getBoundingClientRect();
  Object.assign(view, {zoom: 3.2, shift: [0, 0]});
  const [x, y] = camera()(slotPlace(frame, track.slot));
  view.shift = [width / 2 - x, height / 2 - y];
  refresh();
}
