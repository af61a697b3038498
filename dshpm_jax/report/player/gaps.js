// Where a marker may be while it is not seen: between where it was and where it will be, carried along with the body.

const LONG_GAP = 2;  // seconds; over longer gaps nothing is drawn

function bridged(column, frame) {
  const list = stretches(column), after = list.findIndex(stretch => stretch.first > frame);
  if (after < 1) return null;
  const from = list[after - 1].last, to = list[after].first;
  if (to - from > LONG_GAP * rate) return null;
  const share = (frame - from) / (to - from);
  const [before, next, bodyBefore, bodyNext] = [place(from, column), place(to, column), place(from, CAMERA), place(to, CAMERA)];
  return place(frame, CAMERA).map((x, k) => x + (1 - share) * (before[k] - bodyBefore[k]) + share * (next[k] - bodyNext[k]));
}
