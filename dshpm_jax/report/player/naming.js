// Turns a still of the player into a table in which to name and group its points; see `view_frame`.

const panel = scroll.parentElement, table = document.createElement("div"), answer = document.createElement("textarea");
const fields = [];  // of each point: its name, and its segments

function field(row, hint, value, about) {
  const input = document.createElement("input");
  [input.placeholder, input.value] = [hint, value];
  input.setAttribute("aria-label", about);
  input.oninput = () => { tell(); refresh(); };
  row.append(input);
  return input;
}

// What was typed, as Python.
function tell() {
  const named = [], grouped = new Map();
  for (const [column, {name, segments}] of fields.entries()) {
    const given = name.value.trim();
    names[column] = given || String(DATA.numbers[column]);
    if (!given) continue;
    named.push(`${DATA.numbers[column]}: ${JSON.stringify(given)}`);
    for (const segment of segments.value.split(",").map(text => text.trim()).filter(Boolean)) {
      grouped.set(segment, [...(grouped.get(segment) ?? []), JSON.stringify(given)]);
    }
  }
  const groups = [...grouped].map(([segment, markers]) => `    ${JSON.stringify(segment)}: [${markers.join(", ")}],\n`);
  answer.value = `names = {${named.join(", ")}}\nsegments = {\n${groups.join("")}}`;
}

for (const [column, number] of DATA.numbers.entries()) {
  const row = table.appendChild(document.createElement("label"));
  row.append(Object.assign(document.createElement("span"), {textContent: number}));
  const own = parts.filter(part => part.columns.includes(column)).map(part => part.name).join(", ");
  const name = field(row, "name", DATA.named[number] ?? "", `Name of point ${number}`);
  const segments = field(row, "segments, with commas between", own, `Segments of point ${number}`);
  fields.push({name, segments});
  for (const input of [name, segments]) input.onfocus = () => { view.chosen = column; refresh(); };
}

for (const node of [element("legend"), element("keys"), element("doubting"), scroll, slider, element("pause"), element("speed"), element("time")]) node.hidden = true;
element("others").parentElement.hidden = element("follow").parentElement.hidden = true;
element("named").checked = true;
table.id = "naming";
answer.id = "answer";
answer.readOnly = true;
answer.onfocus = () => answer.select();
answer.setAttribute("aria-label", "Python for SubjectModel.from_frame");
panel.append(table, answer);
element("about").textContent = `${DATA.numbers.length} points: click one and name it, then copy the answer`;
canvas.addEventListener("pointerup", () => fields[view.chosen]?.name.focus());
tell();
refresh();
