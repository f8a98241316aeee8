// The page: data decoded, then map, tables and plots, each linked by the selection.

function pointsOf(data) {
  const given = data.head.points, numbers = (name, Kind = Float32Array) => data.numbers(given[name], Kind);
  const role = data.codes(given.role), newCode = role.texts.indexOf("new");
  const points = { n: given.n, name: data.names(given.names), role, isNew: (i) => role.code(i) === newCode };
  for (const name of ["east", "north", "height"]) points[name] = numbers(name, Float64Array);
  for (const name of ["error", "paper", "internal", "spread", "models", "coverages", "suspect", "known_east", "known_north",
    "apart_east", "apart_north", "semi_major", "flattened", "azimuth", "w", "bins_low", "bins_high"]) points[name] = numbers(name);
  points.share = given.share;
  points.errorStep = given.error.quantum; // between two errors that the page can tell apart
  points.places = Uint32Array.from({ length: given.n }, (_, i) => i);
  return points;
}

function modelsOf(data) {
  const given = data.head.models, models = { n: given.n, name: data.names(given.names) };
  for (const name of ["flight", "coverage", "fit", "reason"]) models[name] = data.codes(given[name]);
  for (const name of ["points", "redundancy", "usable", "m_0", "s_0", "sigma_0", "corners"]) models[name] = data.numbers(given[name]);
  models.places = Array.from({ length: given.n }, (_, i) => i);
  return models;
}

/** Points with a number in the tables of points to look at. */
function numberedPoints() {
  const found = [], seen = new Set();
  for (const [name, mark] of [["known", KNOWN], ["spread", ""]]) {
    const rows = document.querySelectorAll(`table[data-table=${name}] tbody tr`);
    rows.forEach((row, k) => {
      const label = `${mark}${k + 1}`, i = Number(row.dataset.point);
      row.cells[0].textContent = label;
      if (!seen.has(i) && k < 10) { seen.add(i); found.push({ i, label }); }
    });
  }
  return found;
}

async function start() {
  const began = performance.now();
  const place = (id) => document.getElementById(id);
  const data = await decoded(place("data")), { head } = data;
  setLanguage(head);
  schemeSwitch(place("scheme"));
  const points = pointsOf(data), models = modelsOf(data), selection = new Selection();
  setUnit(head.unit, quantile(sorted(points.error), 0.5));
  const errors = Float64Array.from(points.places.filter((i) => points.isNew(i)), (i) => points.error[i]);
  const scale = new ColourScale(head.colours, errors);
  const worst = numberedPoints();
  const map = extentOf(points) ? new BlockMap(place("map-place"), points, models, scale, selection, worst) : null;
  if (!map) place("map-place").append(element("p", {}, translated("No point has coordinates.")));
  document.querySelectorAll("table").forEach(watchTable);
  await new Promise((done) => { requestAnimationFrame(() => setTimeout(done, 0)); setTimeout(done, 200); });
  const tables = fill(place, head, points, models, scale, selection);
  selection.follow((change, by) => {
    if (by === "map" || by === "histogram" || (change.point ?? change.model ?? -1) < 0 || !map) return;
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    place("map-place").scrollIntoView({ behavior: still ? "auto" : "smooth", block: "nearest" });
  });
  globalThis.einschaltReport = { map, tables, selection, points, models, milliseconds: performance.now() - began };
  document.documentElement.dataset.ready = "1";
}

/** What stands below the map: it is drawn first. */
function fill(place, head, points, models, scale, selection) {
  const { claim, plots } = head;
  const tables = {};
  precisionPlot(place("plot-precision"), points, scale, selection, claim);
  if (points.n) tables.points = pointTable(place("all-points"), points, selection, claim);
  if (models.n) tables.models = modelTable(place("all-models"), models, selection);
  for (const table of document.querySelectorAll("table[data-table]")) tables[table.dataset.table] = adopted(table, selection);
  selection.follow(() => { for (const name of ["known", "spread"]) if (tables[name]) tables[name].show(); });
  if (plots.residuals) {
    distributionPlots(place("plot-residuals"), plots.residuals, translated("Residuals of the models"),
      translated("{n:coordinate|coordinates} in standard deviations of their flight; curve: normal.", { n: plots.residuals.n }),
      points.bins_low ? { points, selection } : null);
  }
  paperPlot(place("plot-residuals"), points, claim);
  modelPlot(place("plot-models"), models, selection);
  if (plots.parallaxes && place("plot-parallaxes")) {
    distributionPlots(place("plot-parallaxes"), plots.parallaxes, translated("Residual parallaxes"),
      translated("{n:value|values}, standard deviation {size} µm; curve: normal.", { n: plots.parallaxes.n, size: fixed(plots.parallaxes.scale * 1e6, 1) }));
  }
  if (plots.correlogram && place("plot-correlogram")) correlogramPlot(place("plot-correlogram"), plots.correlogram);
  if (plots.sources && place("plot-sources")) sourcesPlot(place("plot-sources"), plots.sources);
  return tables;
}

start().catch((fault) => {
  document.documentElement.dataset.ready = "failed";
  document.getElementById("map-place").append(element("p", { class: "caution" },
    translated("Map, plots and full tables could not be drawn ({fault}). A newer browser may do it; the tables beside this page contain everything.", { fault: fault.message })));
  throw fault;
});
