// Curves of the last minute: actual values as a line, set values dashed.

const SHORTEST = 10e6, LONGEST = 60e6;  // microseconds
const tracks = new Map();

function remember(state) {
  for (const curve of state.curves) {
    const key = `${state.name}/${curve.label}`;
    const track = tracks.get(key) ?? tracks.set(key, []).get(key);
    if (track.length && track.at(-1)[0] > state.moment) track.length = 0;
    track.push([state.moment, curve.actual, curve.wanted]);
    while (track[0][0] < state.moment - LONGEST) track.shift();
  }
}

function draw(state) {
  const room = at("charts"), labels = state.curves.map(curve => curve.label).join();
  if (room.dataset.of !== `${state.name}:${labels}`) {
    room.dataset.of = `${state.name}:${labels}`;
    room.replaceChildren(...state.curves.map(figure));
  }
  state.curves.forEach((curve, place) => {
    const [canvas, caption] = room.children[place].children;
    caption.children[1].textContent = `${said(curve.actual)} ${curve.unit}`;
    caption.children[2].textContent = curve.wanted === null ? "" : `set ${said(curve.wanted)} ${curve.unit}`;
    plot(canvas, tracks.get(`${state.name}/${curve.label}`), state.moment);
  });
}

function figure(curve) {
  return element("figure", {},
    element("canvas", {role: "img", ariaLabel: `${curve.label} of the last minute`}),
    element("figcaption", {}, element("strong", {textContent: curve.label}),
      element("span", {className: "actual"}), element("span", {className: "wanted"})));
}

function said(value) {
  return value === null ? "–" : Number(value.toPrecision(5)).toString();
}

function plot(canvas, track, now) {
  const scale = devicePixelRatio, wide = canvas.clientWidth, high = canvas.clientHeight;
  canvas.width = wide * scale;
  canvas.height = high * scale;
  const pen = canvas.getContext("2d"), [, actual, wanted] = canvas.nextSibling.children;
  const quiet = getComputedStyle(at("link")).color;
  pen.scale(scale, scale);
  const values = track.flatMap(([, actual, wanted]) => [actual, wanted]).filter(each => each !== null);
  const low = Math.min(0, ...values), top = Math.max(...values, low) || 1;
  const span = Math.max(SHORTEST, now - track[0][0]);
  const x = moment => wide * (1 - (now - moment) / span);
  const y = value => 4 + (high - 8) * (1 - (value - low) / (top - low));
  pen.strokeStyle = pen.fillStyle = quiet;
  line(pen, [[0, y(0)], [wide, y(0)]]);
  pen.font = "11px system-ui, sans-serif";
  pen.fillText(said(top), 2, 13);
  pen.lineWidth = 1.8;
  pen.setLineDash([6, 4]);
  pen.strokeStyle = getComputedStyle(wanted).color;
  line(pen, points(track, 2, x, y));
  pen.setLineDash([]);
  pen.strokeStyle = getComputedStyle(actual).color;
  line(pen, points(track, 1, x, y));
}

function points(track, column, x, y) {
  return track.filter(each => each[column] !== null).map(each => [x(each[0]), y(each[column])]);
}

function line(pen, places) {
  pen.beginPath();
  for (const [x, y] of places) pen.lineTo(x, y);
  pen.stroke();
}
