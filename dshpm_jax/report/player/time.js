// Frames: one is shown, or they play by the clock.

let last = 0, owed = 0, waiting = false;

function show(frame) {
  view.frame = ((Math.round(frame) % frames) + frames) % frames;
  slider.value = view.frame;
  element("time").textContent = `frame ${view.frame} of ${frames} \u00b7 ${(view.frame / rate).toFixed(2)} s`;
  movePlayhead();
  refresh();
}

function refresh() {
  if (!waiting) requestAnimationFrame(now => { waiting = false; advance(now); draw(); });
  waiting = true;
}

function advance(now) {
  if (!view.playing) return;
  owed += Math.min(now - last, 250) / 1000 * rate * element("speed").value;
  last = now;
  const whole = Math.floor(owed);
  owed -= whole;
  if (whole) show(view.frame + whole);
  refresh();
}

function play(on) {
  [view.playing, last, owed] = [on, performance.now(), 0];
  element("pause").textContent = on ? "Pause" : "Play";
  refresh();
}
