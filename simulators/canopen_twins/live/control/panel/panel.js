// The page: which nodes there are, the one that is chosen, its state, the scenario.

let known = [], chosen = "", refreshing = Promise.resolve();

function path(...parts) {
  return ["/nodes", chosen, ...parts].map((part, place) => place ? encodeURIComponent(part) : part).join("/");
}

async function takeNodes() {
  known = await call("GET", "/nodes");
  if (!changed("nodes", [chosen, known])) return;
  const buttons = known.map(node => {
    const button = element("button", {type: "button", className: node.powered ? node.state : "OFF"},
      node.name, element("small", {textContent:
        `${node.node_id}, ${node.powered ? node.state.toLowerCase() : "off"}`}));
    if (node.name === chosen) button.setAttribute("aria-current", "true");
    button.addEventListener("click", () => choose(node.name));
    return button;
  });
  const focused = [...at("nodes").children].indexOf(document.activeElement);
  at("nodes").replaceChildren(...buttons);
  if (focused >= 0) at("nodes").children[focused]?.focus();
  if (!chosen && known.length) await choose(known[0].name);
}

async function choose(name) {
  chosen = name;
  await Promise.all([refresh(), takeNode(), takeNodes()]);
}

// One after the other: what is under way may be of before the click.
function refresh() {
  return refreshing = refreshing.catch(() => {}).then(takeState);
}

async function takeState() {
  if (!chosen) return;
  const state = await call("GET", path());
  if (state.name !== chosen) return;
  remember(state);
  draw(state);
  at("state-title").textContent = `${state.name}, node ${state.node_id}`;
  at("band").textContent = state.powered ? state.band?.label ?? state.state.toLowerCase() : "power off";
  at("band").className = `band ${state.powered ? state.band?.mood ?? "" : ""}`;
  at("silence").textContent = state.silence || state.state.toLowerCase();
  at("power").textContent = state.powered ? "Power off" : "Power on";
  at("power").dataset.on = state.powered ? "" : "1";
  at("report").tBodies[0].replaceChildren(...Object.entries(state.report).map(([name, value]) =>
    element("tr", {}, element("td", {textContent: name}), element("td", {textContent:
      Array.isArray(value) ? value.join(", ") || "none" : value}))));
  showActive(state.faults);
  list("errors-now", state.errors.length ? state.errors.map(error) : ["none"]);
  list("history", state.history.length ? state.history.map(error) : ["empty"]);
}

function error(each) {
  return `${each.code.toString(16).toUpperCase().padStart(4, "0")}h ${each.label}`;
}

at("power").addEventListener("click", event =>
  act("PUT", path("power"), {on: event.target.dataset.on === "1"}));

async function takeStory() {
  const story = await call("GET", "/scenario");
  at("stop").disabled = !story?.running;
  at("verdict").textContent = story ? story.running ? "runs" : story.verdict : "";
  at("verdict").className = `verdict ${story && !story.running ? story.verdict : ""}`;
  at("story-name").textContent = story ? `${story.name}, ${story.duration.toFixed(1)} s` : "none has been started";
  list("outcomes", (story?.outcomes ?? []).slice(-20).map(each =>
    `${each.verdict} ${each.time.toFixed(3)} s ${each.node}: ${each.what}: ${each.seen}`));
}

async function takeStories() {
  const names = await call("GET", "/scenarios");
  at("stories").replaceChildren(...names.map(name => element("option", {textContent: name})));
}

at("play").addEventListener("submit", async event => {
  event.preventDefault();
  await act("POST", "/scenario", {name: at("stories").value});
  takeStory();
});
at("stop").addEventListener("click", () => act("DELETE", "/scenario", {}));

function every(milliseconds, action) {
  const again = async () => {
    try {
      if (!document.hidden) await action();
      link(true);
    } catch (failure) {
      if (failure instanceof TypeError) link(false);
      else tell(failure.message);
    }
    setTimeout(again, milliseconds);
  };
  again();
}

function link(there) {
  at("link").textContent = there ? "connected" : "the twins are gone";
  at("link").classList.toggle("lost", !there);
}

// A page that is left may be kept for the way back, and its stream with it: of six connections one less.
function listen() {
  const source = new EventSource(`/events?kind=emcy${token ? `&token=${encodeURIComponent(token)}` : ""}`);
  source.addEventListener("emcy", event => showEmcy(JSON.parse(event.data)));
  addEventListener("pagehide", () => source.close(), {once: true});
}

addEventListener("pageshow", event => event.persisted && listen());

every(1000, takeNodes);
every(200, refresh);
every(500, takeFrames);
every(500, takeStory);
every(2000, takeSettings);
takeStories().catch(failure => tell(failure.message));
listen();
