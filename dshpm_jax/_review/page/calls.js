// The program behind the page: what it is asked, and what begins the page.

const TOKEN = location.pathname.split("/")[1];
const BASE = `/${TOKEN}/api/`;

async function call(path, body) {
  const headers = {"X-Review-Token": TOKEN};
  let answer;
  try {
    answer = await fetch(BASE + path, body ? {method: "POST", headers, body: JSON.stringify(body)} : {headers});
  } catch {
    throw new Error("The program has ended. What was kept is kept; start dshpm-jax review again.");
  }
  if (answer.headers.get("content-type") === "application/octet-stream") return answer.arrayBuffer();
  const found = await answer.json().catch(() => ({error: "The program does not know this page any more."}));
  if (answer.ok) return found;
  throw Object.assign(new Error(found.error), {status: answer.status});
}

// The trial that the address names, else the first of the queue.
async function start() {
  const queue = await call("queue").catch(error => { document.body.replaceChildren(make("p", null, error.message, "lost")); });
  if (!queue) return;
  const wanted = new URLSearchParams(location.hash.slice(1)).get("trial");
  const trial = queue.trials.find(row => row.id === wanted) ?? queue.trials.find(row => row.opens) ?? queue.trials[0];
  let data = null, wrong = trial ? "" : "There is no trial in this folder.";
  try {
    if (trial) data = await call(`trial/${trial.id}`);
    if (data) data.points = new Int16Array(await call(`points/${trial.id}`));
  } catch (error) {
    [data, wrong] = [null, error.message];
  }
  if (data) await run(data, queue);
  else showQueueAlone(queue, trial, wrong);
}

function showQueueAlone(queue, trial, wrong) {
  listQueue(queue, trial?.id, () => {});
  for (const id of ["panel", "stage", "controls", "scroll"]) element(id).hidden = true;
  document.querySelector("h1").textContent = trial?.name ?? "";
  element("troubles").hidden = false;
  make("p", element("troubles"), wrong);
}

function openTrial(id, more = {}) {
  location.hash = new URLSearchParams({trial: id, ...more});
  location.reload();
}
