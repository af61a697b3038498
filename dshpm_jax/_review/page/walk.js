// From doubt to doubt, and on to the next trial.

let trialsKnown = null, lastDoubt = -1, offered = false;

function showTrack(index, frame) {
  const track = shownTracks[index];
  play(false);
  select(index, frame ?? Math.round((track.first + track.last) / 2));
  show(frame ?? Math.round((track.first + track.last) / 2));
  scrollToRow(track.column);
  showTab("label");
  markDoubt();
}

function nextDoubt(by) {
  if (state.proposal) return toast("Accept or refuse first");
  const now = doubts.findIndex(track => track.index === view.track);
  let k = now >= 0 ? now + by : by > 0 ? lastDoubt : lastDoubt - 1;
  if (now < 0 && k < 0) k = by > 0 ? 0 : doubts.length - 1;
  if (k < 0 || k >= doubts.length) return leave(by);
  lastDoubt = k;
  offered = false;
  showTrack(doubts[k].index);
}

// Behind the last doubt: the next trial that has any, once it is asked for again.
function leave(by) {
  const open = (trialsKnown?.trials ?? []).filter(row => row.opens), here = open.findIndex(row => row.id === DATA.id);
  const next = by > 0 ? open.find((row, k) => row.id !== DATA.id && row.count && k > here) ?? open.find(row => row.id !== DATA.id && row.count) : open[here - 1];
  if (!next) return toast(doubts.length ? "That was the last doubt" : "Nothing is in doubt here");
  if (offered) return openTrial(next.id);
  offered = true;
  toast(`No more doubts here. Press ${by > 0 ? "N" : "P"} again for ${next.name}`);
}

function neighbourTrial(by) {
  const open = (trialsKnown?.trials ?? []).filter(row => row.opens), here = open.findIndex(row => row.id === DATA.id);
  const next = open[here + by];
  if (next) openTrial(next.id);
}

// The queue as it is now: this trial's row by the labels that the page has.
function tellQueue() {
  if (!trialsKnown) return;
  const own = doubts.map(track => ({
    label: nameOf(track) ?? names.find(name => track.reason.includes(name)) ?? null, given: track.label >= 0,
    first: track.first, last: track.last, stake: track.stake, index: track.index,
  }));
  const stake = doubts.reduce((sum, track) => sum + track.stake, 0);
  const trials = trialsKnown.trials.map(row => row.id === DATA.id ? {...row, doubts: own.slice(0, 60), count: own.length, stake, confirmed: state.confirmed} : row);
  listQueue({...trialsKnown, trials}, DATA.id, doubt => showTrack(doubt.index));
  markDoubt();
}

function markDoubt() {
  for (const node of document.querySelectorAll(".doubt")) {
    const own = +node.dataset.track === view.track;
    node.ariaCurrent = String(own);
    if (own) node.scrollIntoView({block: "nearest"});
  }
}

async function refreshQueue() {
  trialsKnown = await call("queue").catch(() => trialsKnown);
  tellQueue();
}
