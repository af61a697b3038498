// Names beside their points, none over another or over a point; a name without room is left out until there is some.

const HIGH = 12, NEAR = 7, FAR = 20;  // pixels: a line of text, and how far from its point it stands
const PLACES = [NEAR, FAR].flatMap(r => [[1, -0.6], [1, 0.6], [-1, -0.6], [-1, 0.6], [0, -1.3], [0, 1.3], [1, 0], [-1, 0]]
  .map(([x, y]) => [x * r, y * r, r]));
const lastPlace = [];  // of each name, so that it does not jump about
const widths = new Map();

function widthOf(name) {
  if (!widths.has(name)) widths.set(name, pen.measureText(name).width);
  return widths.get(name);
}

function boxAt([x, y], [dx, dy], width) {
  const left = dx > 0 ? x + dx : dx < 0 ? x + dx - width : x - width / 2;
  return {left, top: y + dy - HIGH / 2, right: left + width, bottom: y + dy + HIGH / 2};
}

const apart = (a, b) => a.right < b.left || b.right < a.left || a.bottom < b.top || b.bottom < a.top;

// The most wanted first: the chosen one, those in doubt, then the nearest.
function drawNames(at, columns) {
  const wanted = column => (column === view.chosen ? 2 : spanAt(column, view.frame)?.doubtful ? 1 : 0);
  const order = [...columns].sort((a, b) => wanted(b) - wanted(a) || at[a][2] - at[b][2]);
  const taken = dots.filter(dot => dot.column < names.length)
    .map(({x, y, column}) => ({left: x - 4, right: x + 4, top: y - 4, bottom: y + 4, column}));
  const {offsetLeft, offsetTop, offsetWidth, offsetHeight} = element("views");
  taken.push({left: offsetLeft, right: offsetLeft + offsetWidth, top: offsetTop, bottom: offsetTop + offsetHeight});
  const {width: right, height: bottom} = canvas.getBoundingClientRect();
  const inside = box => box.left >= 0 && box.top >= 0 && box.right <= right && box.bottom <= bottom;
  for (const column of order) {
    const width = widthOf(names[column]), first = lastPlace[column] ?? 0;
    for (let k = 0; k < PLACES.length; k++) {
      const choice = k === 0 ? first : k <= first ? k - 1 : k, box = boxAt(at[column], PLACES[choice], width);
      if (!inside(box) || !taken.every(other => other.column === column || apart(box, other))) continue;
      lastPlace[column] = choice;
      taken.push(box);
      drawName(names[column], box, at[column], PLACES[choice][2] === FAR);
      break;
    }
  }
}

function drawName(name, box, [x, y], leader) {
  if (leader) {
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(Math.max(box.left, Math.min(x, box.right)), Math.max(box.top, Math.min(y, box.bottom)));
    pen.lineWidth = 0.8;
    pen.strokeStyle = theme.faint;
    pen.stroke();
  }
  pen.lineWidth = 3;
  pen.strokeStyle = theme.panel;
  pen.strokeText(name, box.left, box.bottom - 2.5);
  pen.fillStyle = theme.ink;
  pen.fillText(name, box.left, box.bottom - 2.5);
}
