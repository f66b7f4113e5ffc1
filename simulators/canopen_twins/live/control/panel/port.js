// What the panel asks of the control port, and how elements come on the page.

const token = new URLSearchParams(location.search).get("token");
const at = id => document.getElementById(id);

async function call(method, path, body) {
  const headers = {"Content-Type": "application/json"};
  if (token) headers.Authorization = `Bearer ${token}`;
  const answer = await fetch(path, {method, headers, body: body && JSON.stringify(body)});
  const told = await answer.json();
  if (!answer.ok) throw new Error(told.detail);
  return told;
}

async function act(method, path, body) {
  try {
    await call(method, path, body);
    at("told").textContent = "";
  } catch (refusal) {
    tell(refusal.message);
  }
  await refresh();
}

function tell(words) {
  at("told").textContent = words;
  clearTimeout(tell.timer);
  tell.timer = setTimeout(() => at("told").textContent = "", 8000);
}

function element(tag, fields = {}, ...inner) {
  const made = Object.assign(document.createElement(tag), fields);
  made.append(...inner);
  return made;
}

// What has not changed stays, and with it the focus.
function changed(id, told) {
  const now = JSON.stringify(told), before = at(id).dataset.told;
  at(id).dataset.told = now;
  return now !== before;
}

function list(id, lines) {
  if (changed(id, lines)) at(id).replaceChildren(...lines.map(line => element("li", {textContent: line})));
}

function seconds(moment) {
  return (moment / 1e6).toFixed(6);
}
