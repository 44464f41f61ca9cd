"use strict";
const data = JSON.parse(document.getElementById("case").textContent);
const times = data.columns.t_s, end = times[times.length - 1];
const POINT = "Write numbers with a decimal point.";
const SAME_INSTANT = 1e-9 * end; // s: rounding to ten digits
let given = null; // rows of the table, with the row of the case that each belongs to

const byId = id => document.getElementById(id);
const number = v => v === 0 || (v >= 1e-3 && v < 1e5) ? String(+v.toPrecision(3)) : v.toExponential(2).replace("e-", "e−").replace("e+", "e");
const instant = t => `${+t.toPrecision(6)} s`;
const value = cell => cell === undefined || cell === "" ? NaN : Number(cell);
const shown = cell => cell ? `“${cell}”` : "empty";

// A table as {names, rows} of texts: columns separated by comma, semicolon or tab.
function readTable(text) {
  const lines = text.replace(/^\uFEFF/, "").split(/\r?\n/).filter(line => line.trim() && !line.startsWith("#"));
  if (!lines.length) throw new Error("The file is empty.");
  const mark = [",", ";", "\t"].sort((a, b) => lines[0].split(b).length - lines[0].split(a).length)[0];
  const cells = line => line.split(mark).map(cell => cell.trim().replace(/^"(.*)"$/, "$1"));
  const names = cells(lines[0]);
  if (!names.includes("t_s")) throw new Error("The first row names no column t_s, the instants in seconds.");
  const rows = lines.slice(1).map(cells);
  const wide = rows.findIndex(row => row.slice(names.length).some(cell => cell));
  if (wide >= 0) throw new Error(`Row ${wide + 1} has ${rows[wide].length} cells for ${names.length} names.${mark === "," ? ` ${POINT}` : ""}`);
  return {names, rows};
}

// Notes of the cells that are no finite numbers, one for all columns of which the same is to be said.
function gaps(known, names, rows) {
  const said = new Map();
  for (const name of known) {
    const column = names.indexOf(name), found = rows.filter(({row}) => !isFinite(value(row[column])));
    if (!found.length) continue;
    const words = `no number in ${found.length} row${found.length > 1 ? "s" : ""}, the first at ${instant(times[found[0].k])}: ${shown(found[0].row[column])}`;
    said.set(words, [...said.get(words) || [], name]);
  }
  return [...said].map(([words, columns]) => `${columns.join(", ")}: ${words}.`);
}

// Rows of a table at instants of the case, in the order of time, and what is to be said of the rest.
function matched(table) {
  const at = table.names.indexOf("t_s"), rows = [], notes = [];
  const known = table.names.filter(name => name in data.columns && name !== "t_s");
  if (!known.length) throw new Error("No column is named as those of the case are; the list below has their names.");
  const untimed = table.rows.findIndex(row => !isFinite(value(row[at])));
  for (const row of table.rows) {
    const t = value(row[at]); // not-a-number is at no instant
    let low = 0, high = times.length - 1;
    while (low < high) { const mid = (low + high) >> 1; if (times[mid] < t - SAME_INSTANT) low = mid + 1; else high = mid; }
    if (Math.abs(times[low] - t) <= SAME_INSTANT) rows.push({k: low, row});
  }
  if (!rows.length && untimed >= 0) throw new Error(`Row ${untimed + 1}: t_s is no number, but ${shown(table.rows[untimed][at])}. ${POINT}`);
  if (!rows.length) throw new Error("No row is at an instant of the case: samples.csv beside this page has them.");
  notes.push(`${rows.length} rows are at instants of the case, which has ${times.length}; the table has ${table.rows.length}.`);
  if (untimed >= 0) notes.push(`Row ${untimed + 1} is left out, as any whose t_s is no number.`);
  rows.sort((a, b) => a.k - b.k);
  notes.push(...gaps(known, table.names, rows));
  const other = table.names.filter(name => !(name in data.columns));
  if (other.length) notes.push(`Not compared: ${other.join(", ")}.`);
  return {names: table.names, rows, notes};
}

// Differences of one quantity: largest over its parts at each instant, Infinity where a cell is no finite number; null if
// the table has no column of it.
function differences(name, table) {
  const parts = data.quantities[name].parts
    .map(part => part.map(column => [column, table.names.indexOf(column)]).filter(([, at]) => at >= 0))
    .filter(part => part.length);
  if (!parts.length) return null;
  const found = [];
  for (const {k, row} of table.rows) {
    let most = -1, where = "";
    for (const part of parts) {
      const off = part.map(([column, at]) => value(row[at]) - data.columns[column][k]);
      const size = off.every(isFinite) ? Math.hypot(...off) : Infinity;
      if (size > most) { most = size; where = part.map(([column]) => column).join(", "); }
    }
    found.push({k, t: times[k], size: most, where});
  }
  return found;
}

// Comparison of a table with the tube of a request, quantity by quantity.
function compared(table, tube) {
  const found = [];
  for (const name in data.quantities) {
    const all = differences(name, table), width = tube.width[name], error = data.quantities[name].error;
    if (!all) continue;
    const inside = all.filter(d => width[d.k] !== null);
    const ratio = (d, bound) => d.size === 0 ? 0 : d.size / bound[d.k];
    const worst = inside.reduce((a, d) => !a || d.size > a.size ? d : a, null);
    found.push({
      name, all, worst,
      ofTube: Math.max(0, ...inside.map(d => ratio(d, width))),
      ofError: Math.max(0, ...inside.map(d => ratio(d, error))),
      left: inside.find(d => d.size > width[d.k]) || null,
    });
  }
  return found;
}

function element(tag, text = "", attributes = {}) {
  const made = document.createElement(tag);
  made.textContent = text;
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  return made;
}

const departure = left => `${instant(left.t)}${isFinite(left.size) ? "" : " (no number)"}`;

function shownTable(found) {
  const table = element("table"), body = element("tbody"), head = element("tr");
  for (const words of ["Channel", "First departure", "Largest difference", "Most, of the tube", "Most, of the error bar"]) head.append(element("th", words, {scope: "col"}));
  for (const each of found) {
    const {unit, label} = data.quantities[each.name], row = element("tr");
    row.append(element("th", label, {scope: "row"}));
    const {worst, left} = each;
    const cell = element("td", "", {class: `w ${left ? "fail" : worst ? "pass" : ""}`});
    cell.append(element("span", left ? `✗ ${departure(left)}, ${left.where}` : worst ? "✓ none" : "not compared", {class: "tag"}));
    const largest = !worst ? "no row where there is a tube" : isFinite(worst.size) ? `${number(worst.size)} ${unit} at ${instant(worst.t)}` : `no number at ${instant(worst.t)}`;
    row.append(cell, element("td", largest, {class: "w"}));
    for (const ratio of [each.ofTube, each.ofError]) row.append(element("td", !worst ? "" : isFinite(ratio) ? `${number(ratio)} times` : "no number", {class: "w"}));
    body.append(row);
  }
  const first = element("thead");
  first.append(head);
  table.append(first, body);
  const box = element("div", "", {class: "scroll", tabindex: "0", role: "group", "aria-label": "Differences by channel"});
  box.append(table);
  return box;
}

// Chart of a quantity's difference over time on a logarithmic scale, with its tube and its error bar.
function chart(each, tube) {
  const {unit, label, error} = data.quantities[each.name], width = tube.width[each.name];
  const curves = [
    ["difference", "var(--accent)", "", each.all.map(d => [d.t, d.size])],
    ["tube", "var(--s3)", "6 2", times.map((t, k) => [t, width[k]])],
    ["error bar", "var(--muted)", "2 1.6", times.map((t, k) => [t, error[k]])],
  ];
  const seen = curves.flatMap(c => c[3]).map(p => p[1]).filter(v => v > 0 && isFinite(v)).map(Math.log10);
  if (!seen.length) seen.push(0);
  const low = Math.floor(Math.min(...seen)), high = Math.max(low + 1, Math.ceil(Math.max(...seen)));
  const x = t => 46 + 344 * t / end, y = v => 12 + 190 * (high - Math.log10(v)) / (high - low);
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const draw = (tag, attributes, text = "") => {
    const made = document.createElementNS(svg.namespaceURI, tag);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    made.textContent = text;
    svg.append(made);
  };
  svg.setAttribute("viewBox", "0 0 400 236");
  svg.setAttribute("role", "img");
  const said = each.left ? `leaves the tube at ${instant(each.left.t)}` : each.worst ? "stays inside the tube" : "has no tube at these rows";
  svg.setAttribute("aria-label", `${label}: difference over time, which ${said}`);
  const step = Math.ceil((high - low) / 6);
  for (let decade = low; decade <= high; decade += step) {
    const at = y(10 ** decade);
    draw("path", {d: `M46 ${at}H390`, style: "stroke:var(--grid);fill:none"});
    draw("text", {x: 41, y: at + 4, "text-anchor": "end", fill: "var(--muted)"}, `1e${decade}`.replace("-", "−"));
  }
  for (const share of [0, 0.5, 1]) draw("text", {x: x(share * end), y: 218, "text-anchor": share ? share < 1 ? "middle" : "end" : "start", fill: "var(--muted)"}, String(+(share * end).toPrecision(4)));
  draw("text", {x: 218, y: 233, "text-anchor": "middle", fill: "var(--muted)"}, "t, s");
  for (const [, colour, dash, points] of curves) {
    let path = "", pen = "M";
    for (const [t, v] of points) {
      if (v > 0 && isFinite(v)) { path += `${pen}${x(t).toFixed(1)} ${y(v).toFixed(1)}`; pen = "L"; } else pen = "M";
    }
    draw("path", {d: path, style: `stroke:${colour};fill:none;stroke-width:1.5;stroke-dasharray:${dash || "none"}`});
  }
  if (each.left) draw("path", {d: `M${x(each.left.t)} 12V202`, style: "stroke:var(--bad);fill:none"});
  const figure = element("figure"), keys = element("p");
  figure.append(element("figcaption", `${label}, ${unit}`), svg, keys);
  keys.textContent = `line: difference; dashes: tube; dots: error bar${each.left ? "; upright: first departure" : ""}`;
  return figure;
}

function show() {
  if (!given) return;
  const tube = data.tubes[byId("rtol").value], found = compared(given, tube);
  const left = found.filter(each => each.left).sort((a, b) => a.left.t - b.left.t);
  const held = found.filter(each => each.worst), labels = held.map(each => data.quantities[each.name].label);
  const instants = [...new Set(given.rows.map(({k}) => times[k]))], last = instants[instants.length - 1];
  // what part of the case the table has: a short one is no pass of the whole
  const span = `${instants[0] > times[0] ? ` from ${instant(instants[0])}` : ""}${last < end ? ` up to ${instant(last)}` : ""}`;
  const missing = instants.length < times.length ? `; the table has ${instants.length} of ${times.length} instants` : "";
  const known = tube.until_s < end ? `; all but the centre of mass is compared up to the predictability limit: ${instant(tube.until_s)} of ${instant(end)}` : "";
  byId("verdict").textContent = (left.length
    ? `Outside the tube of ${tube.name}: ${left.map(each => `${data.quantities[each.name].label} from ${departure(each.left)}`).join(", ")}`
    : held.length ? `Inside the tube of ${tube.name}${span} in ${labels.join(", ")}`
    : `Nothing is compared: no row is where ${tube.name} has a tube`) + `${missing}${known}.`;
  byId("notes").replaceChildren(...given.notes.map(words => element("li", words)));
  const grid = element("div", "", {class: "grid"});
  grid.append(...found.map(each => chart(each, tube)));
  byId("result").replaceChildren(shownTable(found), grid);
}

function take(text) {
  try {
    given = matched(readTable(text));
    show();
  } catch (error) {
    given = null;
    byId("verdict").textContent = error.message;
    byId("notes").replaceChildren();
    byId("result").replaceChildren();
  }
}

const taken = file => file && file.text().then(take);
byId("file").addEventListener("change", event => taken(event.target.files[0]));
byId("rtol").addEventListener("change", show);
const drop = byId("drop");
for (const [kind, over] of [["dragover", true], ["dragleave", false], ["drop", false]]) {
  document.addEventListener(kind, event => { event.preventDefault(); drop.classList.toggle("over", over); });
}
document.addEventListener("drop", event => taken(event.dataTransfer.files[0]));
