// Subjects, markers, and how many trials came out how.

const subjectsSection = document.getElementById("subjects"), markersSection = document.getElementById("markers");
const firstOf = (shown, everything) => shown < everything ? `the first ${count(shown)} of ${count(everything)}; ` : "";

// Trials of a subject by outcome, the worst first.
function outcomesOf(cell, subject) {
  const known = Object.keys(subject.outcomes).sort((a, b) => severity(a) - severity(b));
  for (const outcome of known) make("span", cell, `${count(subject.outcomes[outcome])} ${outcome}`, `part ${tone(outcome)}`);
}

const subjectStake = numeric("In doubt", "stake", x => x ? seconds(x) : "");
const troubles = subject => Object.entries(subject.outcomes).reduce((n, [outcome, k]) => n + (tone(outcome) === "good" ? 0 : k), 0);
table(subjectsSection, [
  {
    title: "Folder", key: subject => subject.name,
    show: (cell, subject) => {
      const node = breakable(make("button", cell, null, "link"), subject.name || "no folder");
      node.dataset.subject = subject.name;
      node.title = "Show its trials only";
      node.onclick = () => { choose("subject", subject.name); trialsSection.scrollIntoView(); };
    },
  },
  numeric("Trials", "trials", count),
  {title: "Outcomes", key: troubles, falling: true, show: outcomesOf},
  subjectStake,
  measured("Completeness", "completeness", "second"),
  numeric("Confidence", "confidence", x => x == null ? "" : x.toFixed(3), {kind: "third", falling: false}),
], DATA.subjects, {sorted: subjectStake, text: subject => subject.name});
say(subjectsSection, firstOf(DATA.subjects.length, DATA.all_subjects) + "by seconds in doubt; means over their trials");
subjectsSection.hidden = DATA.all_subjects < 2;

const found = measured("Found", "found");
table(markersSection, [
  {title: "Label", key: row => row.label, show: (cell, row) => cell.append(row.label)},
  found,
  numeric("In doubt", "stake", x => x ? seconds(x) : ""),
  numeric("Confidence", "confidence", x => x == null ? "" : x.toFixed(3), {kind: "third", falling: false}),
  numeric("Gaps", "gaps", count, {kind: "second"}),
  numeric("Longest gap", "longest", x => x ? seconds(x) : "", {kind: "third"}),
  numeric("Trials", "files", count, {kind: "third"}),
  numeric("Never found in", "absent", x => x ? count(x) : "", {kind: "second"}),
], DATA.markers, {sorted: found, text: row => row.label});
say(markersSection, firstOf(DATA.markers.length, DATA.all_markers)
  + "over all trials whose model has them; the one found in the smallest share of frames first");
markersSection.hidden = !DATA.markers.length;

// Bars of how many trials lie where between `low` and 1.
function histogram(title, about, counts, low, format) {
  if (!counts.some(n => n)) return;
  const box = make("div", document.getElementById("charts")), edge = k => low + (1 - low) * k / counts.length;
  make("span", make("h3", box, title), ` ${about}`, "soft");
  const bars = make("div", box, null, "bars"), scale = make("div", box, null, "scale");
  const top = Math.max(...counts);
  for (const [k, n] of counts.entries()) {
    const bar = make("div", bars);
    bar.style.height = n ? `max(3px, ${100 * n / top}%)` : 0;
    bar.title = `${format(edge(k))} to ${format(edge(k + 1))}: ${several(n, "trial")}`;
  }
  for (const k of [0, counts.length >> 1, counts.length]) make("span", scale, format(edge(k)));
}
histogram("Completeness", "trials by share of their markers' points that have a label", DATA.histograms.completeness, 0, x => Math.round(100 * x) + " %");
const low = DATA.least_confidence;
histogram("Confidence", "trials by mean over their labels", DATA.histograms.confidence, low, x => (x === low ? "up to " : "") + x.toFixed(2));
document.getElementById("charts").parentNode.hidden = !document.getElementById("charts").childElementCount;
