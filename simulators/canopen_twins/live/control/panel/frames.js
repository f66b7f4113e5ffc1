// Frames in words, emergencies as they come, and why: a click asks.

const MOST = 300, KEPT = 2000;
let frames = [], newest = -1, paused = false;

async function takeFrames() {
  if (paused) return;
  const fresh = await call("GET", `/frames?last=500&after=${newest}`);
  if (!fresh.length) return;
  newest = fresh.at(-1).moment;
  frames = fresh.reverse().concat(frames).slice(0, KEPT);
  const rows = at("frames").tBodies[0];
  rows.prepend(...sought(fresh));
  while (rows.rows.length > MOST) rows.deleteRow(-1);
}

function sought(told) {
  const wanted = at("filter").value.toLowerCase(), mine = at("mine").checked;
  return told.filter(each => (!mine || each.node === chosen)
    && `${each.frame} ${each.node} ${each.words}`.toLowerCase().includes(wanted)).slice(0, MOST).map(row);
}

function showFrames() {
  at("frames").tBodies[0].replaceChildren(...sought(frames));
}

function row(told) {
  const button = element("button", {type: "button", textContent: told.frame, title: "Why?"});
  const made = element("tr", {className: told.why.length ? "refused" : ""},
    element("td", {textContent: seconds(told.moment)}), element("td", {textContent: told.node || "master"}),
    element("td", {}, button), element("td", {textContent: told.words}));
  made.addEventListener("click", () => ask(told));
  return made;
}

async function ask(told) {
  const node = told.node && known.some(each => each.name === told.node) ? told.node : chosen;
  const reasons = await call("GET", `/nodes/${encodeURIComponent(node)}/why?frame=${encodeURIComponent(told.frame)}`);
  explain(`${told.frame} ${told.words}`, reasons);
}

function explain(what, reasons) {
  at("reasons-of").textContent = what;
  list("reasons-list", reasons.length ? reasons : ["Nothing out of the ordinary."]);
  at("reasons").showModal();
}

at("why").addEventListener("click", async () => explain(chosen, await call("GET", path("why"))));
at("filter").addEventListener("input", showFrames);
at("mine").addEventListener("change", showFrames);
at("pause").addEventListener("click", event => {
  paused = !paused;
  event.target.setAttribute("aria-pressed", paused);
  event.target.textContent = paused ? "Go on" : "Pause";
});

const emergencies = [];

function showEmcy(event) {
  emergencies.unshift(event);
  emergencies.length = Math.min(emergencies.length, 50);
  list("emcy", emergencies.map(each => `${seconds(each.moment)} ${each.node}: ${each.words}`));
}
