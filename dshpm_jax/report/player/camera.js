// From places in the room to pixels: which way the camera looks, and so that all of the figure is in view.

const ASIDE = 0.44, LIFT = 0.21;  // of the first view, from the front and from the ground (radians)
const AWAY = 6 * DATA.radius;
const ASIDE_ROOM = 28, TOP_ROOM = 56, BOTTOM_ROOM = 18, SAMPLES = 40, STRAYS = 0.003;  // pixels that stay empty; frames; share of points that may lie out of view
const STRIDE_SECONDS = 1.1, STRIDE_STEPS = 6;
const fitted = {scale: 1, centre: [0, 0]};  // pixels for a mm, and what is in the middle

const follows = () => element("follow").checked;

// Turns a place into mm on the picture, right and up, and how far away it is, as seen in a frame.
function looking(frame) {
  const [targetX, targetY] = place(follows() ? frame : 0, CAMERA);
  const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
  return ([x, y, z]) => {
    [x, y, z] = [x - targetX, y - targetY, z - DATA.height];  // it follows along the ground, never up and down
    const right = x * cy - y * sy, forward = x * sy + y * cy;
    const top = forward * sp + z * cp, depth = forward * cp - z * sp;
    const near = AWAY / Math.max(AWAY + depth, 0.05 * AWAY);
    return [right * near, top * near, depth];
  };
}

// Turns a place into pixels, right and down, and how far away it is.
function camera() {
  const {width, height} = canvas.getBoundingClientRect(), look = looking(view.frame), scale = fitted.scale * view.zoom;
  const [x0, y0] = [width / 2 + view.shift[0], (height + TOP_ROOM - BOTTOM_ROOM) / 2 + view.shift[1]];
  return at => {
    const [right, top, depth] = look(at);
    return [x0 + (right - fitted.centre[0]) * scale, y0 - (top - fitted.centre[1]) * scale, depth];
  };
}

// Places of columns before `stop` on the picture of some frames, as numbers to the right and upwards.
function spread(stop) {
  const across = [], up = [];
  for (let k = 0; k < SAMPLES; k++) {
    const frame = Math.round(k * (frames - 1) / (SAMPLES - 1)), look = looking(frame);
    for (let column = 0; column < stop; column++) {
      if (!seen(frame, column)) continue;
      const [right, top] = look(place(frame, column));
      across.push(right);
      up.push(top);
    }
  }
  return across.length || stop === CAMERA ? [across, up] : spread(CAMERA);
}

// Scale and middle with which the figure of all frames is in view, but for a few strays; all points where none has a name.
function fit() {
  const [across, up] = spread(names.length);
  if (!across.length) return;
  const ends = [across, up].map(list => {
    list.sort((a, b) => a - b);
    const aside = Math.floor(STRAYS * list.length);
    return [list[aside], list[list.length - 1 - aside]];
  });
  const {width, height} = canvas.getBoundingClientRect(), room = [width - 2 * ASIDE_ROOM, height - TOP_ROOM - BOTTOM_ROOM];
  fitted.centre = ends.map(([low, high]) => (low + high) / 2);
  fitted.scale = Math.min(...ends.map(([low, high], k) => Math.max(room[k], 20) / Math.max(high - low, 50)));
}

// The turn that shows a body from the front: by its left and right markers, else its broad side.
function front(frame) {
  let [x, y] = [0, 0];
  for (let k = -STRIDE_STEPS; k <= STRIDE_STEPS; k++) {  // about a stride, over which arms and legs swing to and fro
    const t = Math.max(0, Math.min(frames - 1, Math.round(frame + k * STRIDE_SECONDS / 2 / STRIDE_STEPS * rate)));
    for (const [left, right] of DATA.sides) {
      if (!seen(t, left) || !seen(t, right)) continue;
      const [from, to] = [place(t, left), place(t, right)];
      [x, y] = [x + to[0] - from[0], y + to[1] - from[1]];
    }
  }
  return x || y ? Math.atan2(y, -x) : DATA.yaw - ASIDE;
}

const VIEWS = {
  front: turn => [turn, 0],
  side: turn => [turn + Math.PI / 2, 0],
  top: turn => [turn + Math.PI, Math.PI / 2],
  start: turn => [turn + ASIDE, LIFT],
};

function lookFrom(where) {
  [view.yaw, view.pitch] = VIEWS[where](front(view.frame));
  Object.assign(view, {zoom: 1, shift: [0, 0]});
  fit();
  refresh();
}
