// From one label in doubt to the next, and what is in doubt about it.

const inDoubt = ({first, last}) => view.frame >= first && view.frame <= last;

function goToDoubt(step) {
  if (!doubts.length) return;
  let k;
  if (view.doubt >= 0 && inDoubt(doubts[view.doubt])) k = view.doubt + step;
  else k = step > 0 ? doubts.findIndex(span => span.first >= view.frame) : doubts.findLastIndex(span => span.last <= view.frame);
  if (k < 0 && step > 0) k = 0;
  showDoubt((k + doubts.length) % doubts.length);
}

function showDoubt(k) {
  const span = doubts[k];
  play(false);
  view.doubt = k;
  view.chosen = span.column;
  if (span.column >= names.length) element("others").checked = true;
  show(Math.max(0, span.first));
  scrollToRow(span.column);
  drawTimeline();
  tellDoubt();
}

function tellDoubt() {
  const span = doubts[view.doubt], known = span && span.column < names.length;
  const seconds = span && ((span.last - span.first + 1) / rate).toFixed(2);
  element("doubt").textContent = !span ? `${doubts.length} ${doubts.length === 1 ? "label" : "labels"} in doubt`
    : `${view.doubt + 1} of ${doubts.length}: ${known ? `${names[span.column]}, ${Math.floor(100 * span.confidence)} % sure: ` : ""}`
      + `${span.reason}; frames ${span.first}\u2013${span.last}, ${seconds} s`;
}
