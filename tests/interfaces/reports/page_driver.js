// What a reader does with the report, and what comes of it: test_page_in_browser.py.
const found = { errors: [] };
addEventListener("error", (event) => found.errors.push(String(event.message)));
addEventListener("securitypolicyviolation", (event) => found.errors.push(event.violatedDirective));
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const inked = (map) => {
  const pixels = new Uint32Array(map.context.getImageData(0, 0, map.canvas.width, map.canvas.height).data.buffer);
  return { paper: pixels[5 * map.canvas.width + 200], colours: new Set(pixels).size };
};
const drive = async () => {
  while (!document.documentElement.dataset.ready) await wait(20);
  const { map, tables, selection, points } = globalThis.einschaltReport;
  const rows = (id) => [...document.querySelectorAll(`${id} tbody tr`)];
  found.width = [innerWidth, document.documentElement.scrollWidth];
  found.light = inked(map);
  found.requests = performance.getEntriesByType("resource").length;
  found.isFolded = !document.getElementById("all-models").open;
  const box = map.canvas.getBoundingClientRect(), i = map.known[3];
  const at = { clientX: box.left + map.view.x(points.east[i]) + 2, clientY: box.top + map.view.y(points.north[i]), pointerId: 1 };
  map.canvas.dispatchEvent(new PointerEvent("pointermove", at));
  found.hovered = [map.tip.hidden, map.tip.firstChild.textContent, points.name(i), map.readout.textContent];
  const scale = map.view.scale;
  map.canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "+" }));
  found.zoomed = map.view.scale / scale;
  map.canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "0" }));
  found.whole = map.view.scale / scale;
  const row = rows("table[data-table=known]")[1];
  row.click();
  const chosen = selection.point;
  found.chosen = { name: points.name(chosen), row: row.cells[1].textContent, isMarked: row.classList.contains("chosen"),
    off: Math.hypot(map.view.x(points.east[chosen]) - map.view.width / 2, map.view.y(points.north[chosen]) - map.view.height / 2),
    inTable: rows("#all-points").filter((one) => one.classList.contains("chosen")).map((one) => one.cells[0].textContent) };
  selection.clear();
  document.querySelector(".range button").click();
  found.highlighted = [map.said.textContent, tables.points.order.length];
  selection.clear();
  const [from] = document.querySelectorAll("#plot-residuals .range input");
  from.value = "2";
  document.querySelector("#plot-residuals .range button").click();
  const mask = selection.mask;
  found.brushed = [map.said.textContent, tables.points.order.length, [...points.places.filter((k) => mask[k])]];
  found.faded = [...document.querySelectorAll("#plot-residuals rect.bar")].filter((bar) => getComputedStyle(bar).opacity === "0.2").length;
  const bars = document.querySelector("#plot-residuals svg"), ends = bars.getBoundingClientRect();
  for (const kind of ["pointerdown", "pointerup"]) bars.dispatchEvent(new PointerEvent(kind, { clientX: ends.left + 0.6 * ends.width, clientY: ends.top + 60 }));
  found.clicked = map.said.textContent;
  selection.clear();
  tables.points.find(points.name(7));
  found.searched = rows("#all-points").map((one) => one.cells[0].textContent);
  tables.points.find("");
  const column = tables.points.columns.findIndex((one) => one.title.startsWith("total"));
  document.querySelectorAll("#all-points .sort")[column].click();
  found.worst = [tables.points.columns[column].value(tables.points.order[0]), Math.max(...points.error)];
  found.tamed = ["=1+1", "-7/8", "-5", "-5A", "7/8", "--", "'=x"].map(tamed);
  found.csv = tables.points.csv().split("\r\n").length;
  for (const box of document.querySelectorAll("[data-layer]:not(:checked)")) box.click();
  map.drawNow();
  found.layers = map.layers.filter(({ name }) => map.isOn(name)).map(({ name }) => name);
  document.querySelector("#scheme button").click();
  found.dark = inked(map);
  found.images = document.images.length;
  found.title = document.title;
};
drive().catch((fault) => found.errors.push(String(fault))).finally(() => {
  document.body.append(element("pre", { id: "found" }, JSON.stringify(found)));
  if (parent !== globalThis) parent.postMessage(JSON.stringify(found), "*");
});
