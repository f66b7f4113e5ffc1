// Faults and settings: forms made of what the port declares of them.

let catalogue = {};

async function takeNode() {
  const of = chosen;
  const [faults, settings] = await Promise.all([
    call("GET", path("faults")), call("GET", path("settings"))]);
  if (of !== chosen) return;
  catalogue = faults.known;
  const groups = new Map();
  for (const [name, fault] of Object.entries(catalogue)) {
    const group = groups.get(fault.level) ?? groups.set(fault.level, []).get(fault.level);
    group.push(element("option", {value: name, textContent: name}));
  }
  at("fault").replaceChildren(...[...groups].map(([level, options]) =>
    element("optgroup", {label: level}, ...options)));
  chooseFault();
  showSettings(settings);
}

async function takeSettings() {
  const of = chosen;
  if (!of) return;
  const settings = await call("GET", path("settings"));
  if (of === chosen) showSettings(settings);
}

function chooseFault() {
  const fault = catalogue[at("fault").value];
  if (!fault) return;
  at("fault-text").textContent = fault.text + (fault.sees ? ` The master sees: ${fault.sees}` : "");
  at("parameters").replaceChildren(...Object.entries(fault.parameters).map(([name, told]) =>
    field(name, told, told.default, told.default === null)));
}

function field(name, told, value, required = false) {
  const input = told.choices?.length
    ? element("select", {name}, ...told.choices.map(each => element("option", {textContent: each})))
    : element("input", {name, required, type: told.type === "boolean" ? "checkbox" : "text",
        inputMode: ["number", "integer"].includes(told.type) ? "decimal" : "text"});
  if (told.type === "boolean") input.checked = value;
  else input.value = value ?? "";
  const range = [told.low, told.high].some(each => each != null)
    ? ` (${told.low ?? ""}..${told.high ?? ""})` : "";
  const unit = told.unit ? ` [${told.unit}]` : "";
  return element("label", {}, name, input, element("small", {textContent: told.text + unit + range}));
}

function given(input, told) {
  if (told.type === "boolean") return input.checked;
  const text = input.value.trim();
  if (text === "" && told.optional) return null;
  return ["number", "integer"].includes(told.type) && text !== "" && !isNaN(text) ? Number(text) : text;
}

at("fault").addEventListener("change", chooseFault);
at("inject").addEventListener("submit", event => {
  event.preventDefault();
  const name = at("fault").value, parameters = {};
  for (const [key, told] of Object.entries(catalogue[name].parameters)) {
    const input = event.target.elements[key];
    if (input.value.trim() !== String(told.default ?? "")) parameters[key] = given(input, told);
  }
  act("POST", path("faults", name), parameters);
});
at("clear-all").addEventListener("click", () => act("DELETE", path("faults"), {}));

function showActive(faults) {
  if (!changed("active", [chosen, faults])) return;
  at("active").replaceChildren(...faults.map(fault => {
    const clear = element("button", {type: "button", textContent: "Clear", ariaLabel: `Clear ${fault.name}`});
    clear.addEventListener("click", () => act("DELETE", path("faults", fault.name), {}));
    return element("li", {}, element("span", {textContent: fault.words.replace("()", "")}), clear);
  }));
}

function showSettings(settings) {
  if (at("live-settings").contains(document.activeElement)) return;
  if (!changed("live-settings", [chosen, settings])) return;
  at("live-settings").replaceChildren(...settings.filter(each => each.live).map(each => {
    const label = field(each.name, each, each.value);
    label.children[0].addEventListener("change", event =>
      act("PATCH", path("settings"), {[each.name]: given(event.target, each)}));
    return label;
  }));
  at("fixed").tBodies[0].replaceChildren(...settings.filter(each => !each.live).map(each =>
    element("tr", {title: each.text}, element("td", {textContent: each.name}),
      element("td", {textContent: `${each.value ?? "–"} ${each.unit}`}), element("td", {textContent: each.assumed}))));
}
at("live-settings").addEventListener("submit", event => event.preventDefault());
