// Where a marker may be while it is not seen: between where it was and where it will be, carried along with the markers
// that it is linked to, or with the body.

const LONG_GAP = 2;  // seconds; over longer gaps nothing is drawn

const linkedTo = names.map((_, c) => links.filter(([a, b]) => a === c || b === c).map(([a, b]) => a === c ? b : a));

function bridged(column, frame) {
  const list = stretches(column), after = list.findIndex(stretch => stretch.first > frame);
  if (after < 1) return null;
  const from = list[after - 1].last, to = list[after].first;
  if (to - from > LONG_GAP * rate) return null;
  const near = linkedTo[column].filter(other => [from, frame, to].every(t => seen(t, other)));
  const guesses = (near.length ? near : [CAMERA]).map(other => carried(column, other, from, frame, to));
  return guesses[0].map((_, k) => guesses.reduce((sum, guess) => sum + guess[k], 0) / guesses.length);
}

// The place seen from another marker: direction and distance go over from those before the gap to those behind it.
function carried(column, other, from, frame, to) {
  const share = (frame - from) / (to - from);
  const [before, behind] = [from, to].map(t => place(t, column).map((x, k) => x - place(t, other)[k]));
  const between = before.map((x, k) => (1 - share) * x + share * behind[k]);
  const length = (1 - share) * Math.hypot(...before) + share * Math.hypot(...behind);
  const stretch = length / Math.max(Math.hypot(...between), length / 4, 1e-6);
  return place(frame, other).map((x, k) => x + stretch * between[k]);
}
