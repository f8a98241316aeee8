// The map: a canvas with its layers, its key and its tooltip.

/** Layers in their order; their titles are known when the page knows its language. */
const layersOfMap = () => [
  { name: "points", title: translated("Points by precision"), sign: "dots" },
  { name: "known", title: translated("Control and check points"), sign: "triangle" },
  { name: "vectors", title: translated("Differences at known points"), sign: "line check", columns: ["known_east", "known_north"] },
  { name: "apart", title: translated("Coverage differences"), sign: "line apart", columns: ["apart_east", "apart_north"] },
  { name: "ellipses", title: translated("Error ellipses"), sign: "ellipse", columns: ["semi_major"] },
  { name: "footprints", title: translated("Models"), sign: "box" },
  { name: "heat", title: translated("Heat map of precision"), sign: "heat" },
  { name: "numbers", title: translated("Numbers of the worst"), sign: "number" },
];
const ON_AT_FIRST = ["points", "known", "vectors", "numbers"];
const USUAL_SIGN = 26; // pixels of a long vector
const REACH = { vectors: 1.2, apart: 1.2, ellipses: 0.55 }; // of the way to the neighbour
const SMALLEST_MODEL = 20; // pixels
const ON_PAPER = [660, 480]; // width and height, so that its letters are as large as the text

class BlockMap {
  constructor(host, points, models, scale, selection, worst) {
    Object.assign(this, { points, models, scale, selection, worst, hovered: -1, ratio: 1 });
    this.extent = extentOf(points);
    this.view = new View(this.extent);
    this.grid = new PointGrid(points.east, points.north, this.extent);
    this.dots = dotOrder(points, scale);
    this.known = Uint32Array.from(points.places.filter((i) => !points.isNew(i) && isNumber(points.east[i])));
    this.layers = layersOfMap().filter((layer) => this._isThere(layer));
    this.on = new Set(ON_AT_FIRST);
    this.thinned = new Map();
    this._build(host);
    selection.follow((change, by) => this._follow(change, by));
    scheme.listeners.push(() => this._resize());
    new ResizeObserver(() => requestAnimationFrame(() => this._resize())).observe(this.sheet);
    this._resize();
  }

  _isThere(layer) {
    const { points, models } = this;
    if (layer.columns) return layer.columns.every((name) => points[name]);
    return { points: this.scale.is, heat: this.scale.is && points.n > 8, footprints: models.corners,
      known: this.known.length, numbers: this.worst.length }[layer.name];
  }

  isOn(name) {
    return this.on.has(name) && this.layers.some((layer) => layer.name === name);
  }

  _build(host) {
    this.canvas = element("canvas", { tabindex: 0, role: "application", "aria-roledescription": "map",
      "aria-label": translated("Map of {n:point|points}. Arrows move it, plus and minus zoom, 0 shows all, Escape clears.", { n: this.points.n }) });
    this.context = this.canvas.getContext("2d");
    this.tip = element("div", { class: "tip", role: "status", hidden: true });
    this.hint = element("div", { class: "hint", hidden: true }, translated("Click the map, or hold Ctrl, to zoom with the wheel"));
    const button = (text, title, act) => element("button", { type: "button", title, "aria-label": title, onclick: () => { act(); this.draw(); } }, text);
    const zooms = element("div", { class: "zooms" },
      button("+", translated("Zoom in"), () => this.view.zoom(ZOOM)),
      button("−", translated("Zoom out"), () => this.view.zoom(1 / ZOOM)),
      button("⤢", translated("Show the whole block"), () => this.view.whole()));
    this.sheet = element("div", { class: "sheet" }, this.canvas, zooms, this.tip, this.hint);
    this.readout = element("span", { class: "readout" });
    this.said = element("span", { class: "said" });
    this.clear = element("button", { type: "button", class: "quiet", hidden: true, onclick: () => this.selection.clear("map") }, translated("Clear"));
    host.append(element("figure", { class: "map" }, this._key(), this.sheet,
      element("p", { class: "foot" }, this.readout, this.said, this.clear)));
    steer(this.canvas, this.view, {
      hover: (x, y) => this._hover(x, y), leave: () => this._hover(NaN, NaN), hint: () => this._hint(),
      click: (x, y) => this._click(x, y), moved: () => this.draw(), clear: () => this.selection.clear("map"),
      frame: (a, b, isDone) => this._frame(a, b, isDone),
    });
  }

  _key() {
    const set = element("fieldset", { class: "key" }, element("legend", {}, translated("Layers")));
    for (const layer of this.layers) {
      const box = element("input", { type: "checkbox", "data-layer": layer.name });
      box.checked = this.on.has(layer.name);
      box.addEventListener("change", () => {
        if (box.checked) this.on.add(layer.name); else this.on.delete(layer.name);
        this.draw();
      });
      layer.label = element("span", {}, layer.title);
      set.append(element("label", {}, box, sign(layer.sign), layer.label));
    }
    return set;
  }

  _resize() {
    const [width, height] = scheme.printing ? ON_PAPER : [this.sheet.clientWidth, this.sheet.clientHeight];
    if (!width || !height) return;
    this.ratio = scheme.printing ? 3 : Math.min(devicePixelRatio || 1, 3);
    this.canvas.width = Math.round(width * this.ratio);
    this.canvas.height = Math.round(height * this.ratio);
    this.view.resize(width, height);
    this.drawNow();
  }

  /** Draw with the next frame of the screen, once for however many calls. */
  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => { this.isDue = false; this.drawNow(); });
  }

  drawNow() {
    const { context, view } = this;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = palette().paper;
    context.fillRect(0, 0, view.width, view.height);
    context.textAlign = "left";
    this.signs = this.layers.filter((layer) => layer.columns && this.on.has(layer.name));
    this._exaggerate();
    drawFrame(context, this);
    if (this.isOn("heat")) drawHeat(context, this);
    if (this.isOn("footprints")) drawFootprints(context, this);
    drawDots(context, this, this._radius());
    for (const layer of this.signs) {
      if (layer.name === "ellipses") drawEllipses(context, this, layer);
      else drawVectors(context, this, layer, palette()[layer.name === "apart" ? "apart" : "check"], layer.name === "apart" ? 1 : 1.5);
    }
    if (this.isOn("known")) drawKnown(context, this);
    if (this.isOn("numbers")) drawNumbers(context, this);
    drawChosen(context, this);
    this.labels();
    this._sayThinning();
  }

  _radius() {
    const spacing = Math.sqrt((this.extent[2] - this.extent[0]) * (this.extent[3] - this.extent[1]) / Math.max(this.dots.order.length, 1));
    return Math.min(Math.max(0.28 * spacing * this.view.scale, 1), 4.5);
  }

  /**
   * Vectors and ellipses share one factor, so that they can be compared. It is chosen for
   * the whole block: on the screen an error is as long at every scale of the map.
   */
  _exaggerate() {
    const wide = this.extent[2] - this.extent[0], high = this.extent[3] - this.extent[1], scale = this.view.wholeScale();
    let most = Infinity;
    for (const layer of this.signs) {
      layer.long ??= quantile(sorted(Float64Array.from(this.points.places, (i) => Math.hypot(...layer.columns.map((name) => this.points[name][i])))), 0.95);
      layer.all ??= this._having(layer).length;
      const drawn = Math.max(Math.min(layer.all, MOST_SIGNS), 1);
      const spacing = Math.max(Math.sqrt(wide * high / drawn), Math.max(wide, high) / drawn); // the latter of points in a line
      const reach = Math.min(USUAL_SIGN, REACH[layer.name] * spacing * scale);
      if (layer.long > 0 && reach > 0) most = Math.min(most, reach / (layer.long * scale));
    }
    this.pixelsPerError = most < Infinity ? roundDown(most) * scale : 0;
  }

  /** Points of a layer that are drawn at this scale: the same wherever the map is moved. */
  thinnedOf(layer) {
    const { inView, share } = this._share();
    const wanted = layer.all * share <= MOST_SIGNS ? 0 : Math.sqrt(inView / MOST_SIGNS);
    const level = wanted ? Math.ceil(Math.log2(wanted) * 2) : -Infinity;
    const key = `${layer.name} ${level}`;
    if (!this.thinned.has(key)) {
      const all = this._having(layer);
      this.thinned.set(key, wanted ? this.grid.thinned(2 ** (level / 2), all) : all);
    }
    layer.drawn = this.thinned.get(key);
    return layer.drawn;
  }

  /** Points that have what a layer draws. */
  _having(layer) {
    if (!layer.having) {
      const columns = ["east", "north", ...layer.columns].map((name) => this.points[name]);
      layer.having = this.points.places.filter((i) => columns.every((column) => isNumber(column[i])));
    }
    return layer.having;
  }

  /** How much of the block is in view [m²], and which share of it. */
  _share() {
    const [west, south, right, top] = this.view.box(), [a, b, c, d] = this.extent;
    const inView = Math.max(0, Math.min(right, c) - Math.max(west, a)) * Math.max(0, Math.min(top, d) - Math.max(south, b));
    return { inView, share: Math.min(inView / Math.max((c - a) * (d - b), 1e-9), 1) };
  }

  /** Models that can be seen: not too small, and not out of sight. */
  modelsInView() {
    this.boxes ??= this.models.places.map((m) => this._modelBox(m));
    const [west, south, right, top] = this.view.box(), least = SMALLEST_MODEL / this.view.scale;
    const found = this.models.places.filter((m) => {
      const box = this.boxes[m];
      return box && box[2] > west && box[0] < right && box[3] > south && box[1] < top && Math.max(box[2] - box[0], box[3] - box[1]) > least;
    });
    const layer = this.layers.find(({ name }) => name === "footprints");
    const text = found.length ? layer.title : translated("{layer} (zoom in to see them)", { layer: layer.title });
    if (layer.label.textContent !== text) layer.label.textContent = text;
    return found;
  }

  _modelBox(m) {
    const corners = this.models.corners.subarray(8 * m, 8 * m + 8);
    if (!isNumber(corners[0])) return null;
    const easts = Array.from(corners, (i) => this.points.east[i]), norths = Array.from(corners, (i) => this.points.north[i]);
    return [Math.min(...easts), Math.min(...norths), Math.max(...easts), Math.max(...norths)];
  }

  /** Known points that are drawn, evenly thinned where there are thousands. */
  knownShown() {
    const layer = this.layers.find(({ name }) => name === "known");
    layer.having = this.known;
    layer.all = this.known.length;
    return this.thinnedOf(layer);
  }

  _sayThinning() {
    for (const layer of [...this.signs, ...this.layers.filter(({ name }) => name === "known" && this.on.has(name))]) {
      // of many points the page holds the signs of some: they count as well
      const held = layer.name === "apart" || layer.name === "ellipses" ? this.points.share : 1;
      const part = layer.drawn && layer.drawn.length ? layer.all / held / layer.drawn.length : 1;
      const text = part >= 1.5 ? translated("{layer}, 1 in {n}", { layer: layer.title, n: count(Math.round(part)) }) : layer.title;
      if (layer.label.textContent !== text) layer.label.textContent = text;
    }
  }

  _near(x, y) {
    const { view, points } = this;
    const isShown = (i) => (points.isNew(i) || this.isOn("known"));
    return this.grid.nearest(view.east(x), view.north(y), 14 / view.scale, isShown);
  }

  _hover(x, y) {
    const found = isNumber(x) ? this._near(x, y) : -1;
    if (isNumber(x)) this.readout.textContent = translated("E {east}  N {north}", { east: coordinateText(this.view.east(x)), north: coordinateText(this.view.north(y)) });
    if (found === this.hovered) return;
    this.hovered = found;
    this._tip(found >= 0 ? found : this.selection.point);
    this.draw();
  }

  _click(x, y) {
    this.canvas.focus({ preventScroll: true });
    const i = this._near(x, y);
    this.selection.choose({ point: i }, "map");
  }

  _hint() {
    this.hint.hidden = false;
    clearTimeout(this.hintTimer);
    this.hintTimer = setTimeout(() => { this.hint.hidden = true; }, 1400);
  }

  /** Shift and drag: choose the points of a rectangle. */
  _frame(a, b, isDone) {
    const { view, points } = this;
    if (!isDone) return requestAnimationFrame(() => strokes(this.context, palette().chosen, 1, () =>
      this.context.rect(a[0], a[1], b[0] - a[0], b[1] - a[1])));
    const [west, right] = [a[0], b[0]].sort((p, q) => p - q).map((x) => view.east(x));
    const [top, south] = [a[1], b[1]].sort((p, q) => p - q).map((y) => view.north(y));
    this.selection.highlight(points.n, (i) => points.east[i] >= west && points.east[i] <= right && points.north[i] >= south && points.north[i] <= top,
      (n) => translated("{n:point|points} in the rectangle", { n }), "map");
    return undefined;
  }

  _tip(i) {
    this.tip.hidden = i < 0;
    if (i < 0) return;
    const lines = factsOf(this.points, i).map(([title, text]) => element("div", {}, element("span", {}, title), ` ${text}`));
    this.tip.replaceChildren(element("b", {}, this.points.name(i)), ...lines);
    const x = this.view.x(this.points.east[i]), y = this.view.y(this.points.north[i]);
    const wide = this.tip.offsetWidth, high = this.tip.offsetHeight;
    const left = x + 14 + wide > this.view.width ? x - 14 - wide : x + 14;
    this.tip.style.left = `${Math.max(4, Math.min(left, this.view.width - wide - 4))}px`;
    this.tip.style.top = `${Math.max(4, Math.min(y - high / 2, this.view.height - high - 4))}px`;
  }

  _follow(change, by) {
    const { points, view, selection } = this, i = selection.point;
    if ("point" in change && i >= 0 && by !== "map" && isNumber(points.east[i])) {
      const spacing = Math.sqrt((this.extent[2] - this.extent[0]) * (this.extent[3] - this.extent[1]) / points.n);
      view.show(points.east[i], points.north[i], 14 * spacing);
    }
    if ("model" in change && selection.model >= 0 && by !== "map") this._showModel(selection.model);
    this.said.textContent = selection.mask ? selection.said(selection.found) : "";
    this.clear.hidden = !selection.mask && i < 0 && selection.model < 0;
    this.drawNow();
    this._tip(i);
  }

  _showModel(m) {
    const box = this.models.corners && this._modelBox(m);
    if (!box) return;
    this.view.show((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, 2.2 * Math.max(box[2] - box[0], box[3] - box[1]));
  }
}

/** Two errors; where the decimal sign is a comma, another sign parts them. */
const pairText = (east, north) => `${errorText(east)}${words.decimal === "," ? ";" : ","} ${errorText(north)} ${unit.name}`;

function factsOf(points, i) {
  const facts = [["", roleText(points.role(i))], ["E", coordinateText(points.east[i])], ["N", coordinateText(points.north[i])]];
  if (points.height) facts.push(["H", coordinateText(points.height[i])]);
  facts.push([translated("standard error"), errorWithUnit(points.error[i])]);
  if (points.known_east && isNumber(points.known_east[i])) {
    facts.push([translated("densified − given"), pairText(points.known_east[i], points.known_north[i])]);
  }
  if (points.apart_east && isNumber(points.apart_east[i])) {
    facts.push([translated("coverages differ"), pairText(points.apart_east[i], points.apart_north[i])]);
  }
  facts.push([translated("models"), `${points.models[i]}`]);
  if (points.suspect && points.suspect[i]) facts.push(["", translated("suspect")]);
  return facts;
}

function extentOf(points) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.n; i++) {
    const e = points.east[i], n = points.north[i];
    if (!isNumber(e) || !isNumber(n)) continue;
    if (e < box[0]) box[0] = e;
    if (n < box[1]) box[1] = n;
    if (e > box[2]) box[2] = e;
    if (n > box[3]) box[3] = n;
  }
  return isNumber(box[0]) ? box : null;
}

/** The sign of a layer, as its key shows it. */
function sign(kind) {
  const shapes = {
    dots: [["circle", { cx: 4, cy: 10, r: 2.6, class: "s1" }], ["circle", { cx: 11, cy: 5, r: 2.6, class: "s2" }], ["circle", { cx: 18, cy: 10, r: 2.6, class: "s3" }]],
    triangle: [["path", { d: "M6 2l5 9h-10z", class: "control" }], ["rect", { x: 14, y: 3.5, width: 7, height: 7, class: "check" }]],
    "line check": [["path", { d: "M2 11L20 3", class: "check" }]],
    "line apart": [["path", { d: "M2 3L20 11", class: "apart" }]],
    ellipse: [["ellipse", { cx: 11, cy: 7, rx: 9, ry: 4.5, class: "ellipse" }]],
    box: [["path", { d: "M3 2h16l1 9h-18z", class: "model" }]],
    heat: [["rect", { x: 1, y: 2, width: 7, height: 10, class: "s1" }], ["rect", { x: 8, y: 2, width: 7, height: 10, class: "s2" }], ["rect", { x: 15, y: 2, width: 6, height: 10, class: "s3" }]],
    number: [["text", { x: 7, y: 11, class: "number" }]],
  }[kind];
  const made = svg("svg", { viewBox: "0 0 22 14", width: 22, height: 14, "aria-hidden": "true", class: "sign" });
  for (const [tag, facts] of shapes) made.append(svg(tag, facts));
  if (kind === "number") made.lastChild.textContent = "1";
  return made;
}

function svg(tag, facts = {}, ...content) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(facts)) {
    if (typeof value === "function") made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...content);
  return made;
}
