// What the map draws, layer by layer, on a canvas in pixels of the screen.

const PALETTES = {
  light: {
    paper: "#ffffff", ink: "#1c2b33", soft: "#4e5f69", grid: "#e3e8eb", edge: "#6b7c85", dimmed: "#d3dade",
    control: "#0b4f8a", check: "#b4430b", apart: "#1f7a68", ellipse: "#1c2b33", model: "#8a5a9e",
    failed: "#b4430b", chosen: "#d6006c", halo: "rgba(255,255,255,.85)",
  },
  dark: {
    paper: "#141b1f", ink: "#e6ecef", soft: "#a5b3bb", grid: "#263138", edge: "#7f9099", dimmed: "#36434a",
    control: "#7db8f0", check: "#f59a5f", apart: "#5fd0b5", ellipse: "#dfe7ea", model: "#c79be0",
    failed: "#f59a5f", chosen: "#ff5cab", halo: "rgba(20,27,31,.85)",
  },
};
const palette = () => PALETTES[isDark() ? "dark" : "light"];

const N_CLASSES = 64;
const MOST_ARCS = 6000;
const MOST_SIGNS = 900; // vectors or ellipses that can be told apart

/** Colours of errors: the steps of the map in block.gpkg, and all between them. */
class ColourScale {
  constructor(steps, errors) {
    this.steps = steps;
    const known = sorted(errors);
    this.low = known.length ? known[0] : 0;
    const high = known.length ? known[known.length - 1] : 1;
    this.high = Math.min(high, 2 * quantile(known, 0.95)) || this.low + 1;
    if (this.high - this.low < 1e-9) this.high = this.low + unit.metres;
    this.is = known.length > 0;
  }

  part(error) {
    return Math.min(Math.max((error - this.low) / (this.high - this.low), 0), 1);
  }

  rgb(part) {
    // on dark paper the large errors are the bright ones
    const place = (isDark() ? 1 - part : part) * (this.steps.length - 1);
    const below = Math.min(Math.floor(place), this.steps.length - 2), rest = place - below;
    return this.steps[below].map((c, k) => Math.round(c + rest * (this.steps[below + 1][k] - c)));
  }

  css(error) {
    return `rgb(${this.rgb(this.part(error)).join(",")})`;
  }
}

const strokes = (context, colour, width, draw) => {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  draw();
  context.stroke();
};

/** Points that are drawn as dots, in the order of their errors: the worst on top. */
function dotOrder(points, scale) {
  const classes = new Uint8Array(points.n), counts = new Uint32Array(N_CLASSES + 2);
  for (let i = 0; i < points.n; i++) {
    const isDot = points.isNew(i) && isNumber(points.east[i]) && isNumber(points.north[i]);
    const error = points.error[i];
    classes[i] = !isDot ? 255 : isNumber(error) ? 1 + Math.round(scale.part(error) * (N_CLASSES - 1)) : 0;
    if (isDot) counts[classes[i] + 1]++;
  }
  for (let c = 0; c <= N_CLASSES; c++) counts[c + 1] += counts[c];
  const order = new Uint32Array(counts[N_CLASSES + 1]);
  for (let i = 0; i < points.n; i++) if (classes[i] !== 255) order[counts[classes[i]]++] = i;
  return { order, classes };
}

function drawDots(context, map, radius) {
  const { view, dots, points, selection } = map, mask = selection.mask;
  const colours = Array.from({ length: N_CLASSES + 1 }, (_, c) =>
    c === 0 || !map.isOn("points") ? hexRgb(palette().edge) : map.scale.rgb((c - 1) / (N_CLASSES - 1)));
  const dim = hexRgb(palette().dimmed);
  if (dots.order.length > MOST_ARCS) return stampDots(context, map, radius, colours, dim);
  const margin = radius + 1;
  for (const wanted of mask ? [0, 1] : [1]) {
    for (const i of dots.order) {
      if (mask && mask[i] !== wanted) continue;
      const x = view.x(points.east[i]), y = view.y(points.north[i]);
      if (x < -margin || y < -margin || x > view.width + margin || y > view.height + margin) continue;
      const rgb = mask && !wanted ? dim : colours[dots.classes[i]];
      context.fillStyle = `rgb(${rgb.join(",")})`;
      context.beginPath();
      context.arc(x, y, radius, 0, 7);
      context.fill();
    }
  }
}

const hexRgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** Many dots: written into an image pixel by pixel, much faster than arcs. */
function stampDots(context, map, radius, colours, dim) {
  const { view, dots, points, ratio } = map, mask = map.selection.mask;
  const width = Math.round(view.width * ratio), height = Math.round(view.height * ratio);
  if (!map.dotSheet || map.dotSheet.width !== width || map.dotSheet.height !== height) {
    map.dotSheet = new OffscreenCanvas(width, height);
    map.dotImage = new ImageData(width, height);
  }
  const pixels = new Uint32Array(map.dotImage.data.buffer);
  pixels.fill(0);
  const whole = ([r, g, b]) => (0xff000000 | (b << 16) | (g << 8) | r) >>> 0;
  const codes = Uint32Array.from(colours, whole), dimmed = whole(dim);
  const r = Math.max(Math.round(radius * ratio), 1), stamp = r === 1 ? [1, width, width + 1] : [];
  for (let dy = 1 - r; dy < r; dy++) for (let dx = 1 - r; dx < r; dx++) if (dx * dx + dy * dy <= (r - 0.4) ** 2) stamp.push(dy * width + dx);
  const k = view.scale * ratio, x0 = (view.width / 2) * ratio - view.centre[0] * k, y0 = (view.height / 2) * ratio + view.centre[1] * k;
  for (const wanted of mask ? [0, 1] : [1]) {
    for (let j = 0; j < dots.order.length; j++) {
      const i = dots.order[j];
      if (mask && mask[i] !== wanted) continue;
      const x = (points.east[i] * k + x0) | 0, y = (y0 - points.north[i] * k) | 0;
      if (x < r || y < r || x >= width - r || y >= height - r) continue;
      const code = mask && !wanted ? dimmed : codes[dots.classes[i]], place = y * width + x;
      for (let s = 0; s < stamp.length; s++) pixels[place + stamp[s]] = code;
    }
  }
  map.dotSheet.getContext("2d").putImageData(map.dotImage, 0, 0);
  context.drawImage(map.dotSheet, 0, 0, view.width, view.height);
}

/** Mean error of cells, as a small image that is drawn large: made once for a scheme. */
function heatImage(map) {
  const { points, extent, scale } = map;
  const wide = extent[2] - extent[0], high = extent[3] - extent[1];
  const cell = Math.max(Math.sqrt((wide * high * 4) / Math.max(map.dots.order.length, 1)), wide / 400, high / 400, 1e-6);
  const nx = Math.floor(wide / cell) + 1, ny = Math.floor(high / cell) + 1;
  const sum = new Float64Array(nx * ny), n = new Float64Array(nx * ny);
  for (const i of map.dots.order) {
    if (!isNumber(points.error[i])) continue;
    const c = Math.floor((points.north[i] - extent[1]) / cell) * nx + Math.floor((points.east[i] - extent[0]) / cell);
    sum[c] += points.error[i];
    n[c]++;
  }
  const image = new ImageData(nx, ny);
  for (let row = 0; row < ny; row++) for (let column = 0; column < nx; column++) {
    let total = 0, weight = 0;
    for (let dy = -2; dy <= 2; dy++) for (let dx = -2; dx <= 2; dx++) {
      const [x, y] = [column + dx, row + dy], near = Math.exp(-(dx * dx + dy * dy) / 1.5);
      if (x < 0 || y < 0 || x >= nx || y >= ny) continue;
      total += near * sum[y * nx + x];
      weight += near * n[y * nx + x];
    }
    if (weight < 0.25) continue;
    const place = 4 * ((ny - 1 - row) * nx + column);
    image.data.set([...scale.rgb(scale.part(total / weight)), 165], place);
  }
  const sheet = new OffscreenCanvas(nx, ny);
  sheet.getContext("2d").putImageData(image, 0, 0);
  return { sheet, wide: nx * cell, high: ny * cell };
}

function drawHeat(context, map) {
  const key = isDark();
  if (!map.heat || map.heat.key !== key) map.heat = { key, ...heatImage(map) };
  const { view, extent, heat } = map;
  context.imageSmoothingEnabled = true;
  context.imageSmoothingQuality = "high";
  context.drawImage(heat.sheet, view.x(extent[0]), view.y(extent[1] + heat.high), heat.wide * view.scale, heat.high * view.scale);
}

function drawFootprints(context, map) {
  const { models } = map, colours = palette(), seen = map.modelsInView();
  for (const usable of [1, 0]) {
    const own = seen.filter((m) => models.usable[m] === usable);
    // a few at a time: one path of thousands of sides takes seconds
    for (let k = 0; k < own.length; k += 100) {
      strokes(context, usable ? colours.model : colours.failed, usable ? 0.8 : 1.6, () => {
        for (const m of own.slice(k, k + 100)) outline(context, map, m);
      });
    }
  }
  context.globalAlpha = 0.05;
  context.fillStyle = colours.model;
  if (seen.length <= 400) for (const m of seen) { context.beginPath(); outline(context, map, m); context.fill(); }
  context.globalAlpha = 1;
}

/** Corners of a model, as a path. */
function outline(context, map, m) {
  const { models, points, view } = map;
  if (!models.corners) return;
  for (let k = 0; k < 8; k++) {
    const i = models.corners[8 * m + k];
    if (!isNumber(i)) return;
    const x = view.x(points.east[i]), y = view.y(points.north[i]);
    if (k) context.lineTo(x, y); else context.moveTo(x, y);
  }
  context.closePath();
}

function drawVectors(context, map, layer, colour, width) {
  const { points, view, pixelsPerError: k } = map;
  const [east, north] = layer.columns.map((name) => points[name]);
  strokes(context, colour, width, () => {
    for (const i of map.thinnedOf(layer)) {
      const x = view.x(points.east[i]), y = view.y(points.north[i]);
      if (x < -60 || y < -60 || x > view.width + 60 || y > view.height + 60) continue;
      context.moveTo(x, y);
      context.lineTo(x + east[i] * k, y - north[i] * k);
    }
  });
}

function drawEllipses(context, map, layer) {
  const { points, view, pixelsPerError: k } = map;
  strokes(context, palette().ellipse, 0.7, () => {
    for (const i of map.thinnedOf(layer)) {
      const x = view.x(points.east[i]), y = view.y(points.north[i]);
      if (x < -60 || y < -60 || x > view.width + 60 || y > view.height + 60) continue;
      const major = points.semi_major[i] * k, minor = major * (points.flattened[i] || 0);
      // azimuth from north in gon; the canvas turns from east, with y down
      const turned = (points.azimuth[i] * Math.PI) / 200 - Math.PI / 2;
      context.moveTo(x + major * Math.cos(turned), y + major * Math.sin(turned));
      context.ellipse(x, y, major, minor, turned, 0, 2 * Math.PI);
    }
  });
}

function drawKnown(context, map) {
  const { points, view } = map, colours = palette();
  const size = Math.max(Math.min(5, 110 / Math.sqrt(map.known.length + 1)), 2) * (view.isWhole ? 1 : 1.15);
  context.lineWidth = size < 3 ? 0.9 : 1.3;
  context.fillStyle = colours.paper;
  for (const i of map.knownShown()) {
    const x = view.x(points.east[i]), y = view.y(points.north[i]);
    if (x < -9 || y < -9 || x > view.width + 9 || y > view.height + 9) continue;
    const isDim = map.selection.mask && !map.selection.mask[i];
    context.strokeStyle = isDim ? colours.dimmed : colours[points.role(i)] || colours.control;
    context.beginPath();
    if (points.role(i) === "check") context.rect(x - size * 0.8, y - size * 0.8, 1.6 * size, 1.6 * size);
    else {
      context.moveTo(x, y - size * 1.15);
      context.lineTo(x + size, y + size * 0.7);
      context.lineTo(x - size, y + size * 0.7);
      context.closePath();
    }
    context.fill();
    context.stroke();
  }
}

/** Numbers of the worst points, as their tables have them; none over another. */
function drawNumbers(context, map) {
  const { points, view } = map, colours = palette(), taken = [];
  context.font = "600 11px system-ui, sans-serif";
  context.textBaseline = "middle";
  for (const { i, label } of map.worst) {
    const x = view.x(points.east[i]) + 7, y = view.y(points.north[i]) - 8;
    const width = context.measureText(label).width + 4;
    if (x < 0 || y < 0 || x > view.width || y > view.height) continue;
    if (taken.some(([a, b, w]) => x < a + w && a < x + width && Math.abs(b - y) < 12)) continue;
    taken.push([x, y, width]);
    haloed(context, label, x, y, colours.ink);
  }
}

function haloed(context, text, x, y, colour) {
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = palette().halo;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

function drawChosen(context, map) {
  const { points, view, selection, models } = map, colours = palette();
  if (selection.model >= 0 && models.corners) {
    strokes(context, colours.chosen, 2, () => outline(context, map, selection.model));
  }
  for (const [i, width] of [[map.hovered, 1.2], [selection.point, 2.2]]) {
    if (i < 0 || !isNumber(points.east[i])) continue;
    strokes(context, colours.chosen, width, () => context.arc(view.x(points.east[i]), view.y(points.north[i]), 9, 0, 7));
  }
}

/** Grid of coordinates with its labels, north, and the two scale bars. */
function drawFrame(context, map) {
  const { view } = map, colours = palette(), [west, south, right, top] = view.box();
  context.font = "11px system-ui, sans-serif";
  const step = (places) => (places.length > 1 ? places[1] - places[0] : 1);
  const easts = ticks(west, right, view.width / 130), norths = ticks(south, top, view.height / 110);
  strokes(context, colours.grid, 1, () => {
    for (const e of easts) { const x = Math.round(view.x(e)) + 0.5; context.moveTo(x, 0); context.lineTo(x, view.height); }
    for (const n of norths) { const y = Math.round(view.y(n)) + 0.5; context.moveTo(0, y); context.lineTo(view.width, y); }
  });
  map.labels = () => {
    context.textBaseline = "alphabetic";
    context.textAlign = "center";
    for (const e of easts) if (view.x(e) > 70 && view.x(e) < view.width - 40) haloed(context, tickText(e, step(easts)), view.x(e), view.height - 6, colours.soft);
    context.textAlign = "left";
    for (const n of norths) if (view.y(n) > 26 && view.y(n) < view.height - 70) haloed(context, tickText(n, step(norths)), 6, view.y(n) - 4, colours.soft);
    drawNorth(context, view.width - 20, 12, colours);
    drawBars(context, map, colours);
  };
}

function drawNorth(context, x, y, colours) {
  context.fillStyle = colours.ink;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + 5, y + 17);
  context.lineTo(x, y + 13);
  context.lineTo(x - 5, y + 17);
  context.fill();
  context.textAlign = "center";
  context.font = "600 11px system-ui, sans-serif";
  haloed(context, "N", x, y + 29, colours.ink);
}

function drawBars(context, map, colours) {
  const { view } = map, long = Math.min(130, view.width / 4);
  const ground = roundDown(long / view.scale);
  const bars = [[ground * view.scale, groundText(ground), colours.ink]];
  if (map.pixelsPerError && map.signs.length) {
    const error = roundDown(long / map.pixelsPerError);
    bars.push([error * map.pixelsPerError, translated("{length} of errors, × {factor}", { length: barText(error), factor: factorText(map.pixelsPerError / view.scale) }), colours.check]);
  }
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "left";
  bars.forEach(([wide, text, colour], row) => {
    const y = view.height - 28 - 17 * (bars.length - 1 - row), x = 8;
    strokes(context, colours.halo, 5, () => { context.moveTo(x - 1, y); context.lineTo(x + wide + 1, y); });
    strokes(context, colour, 1.6, () => {
      context.moveTo(x, y - 4); context.lineTo(x, y + 4);
      context.moveTo(x, y); context.lineTo(x + wide, y);
      context.moveTo(x + wide, y - 4); context.lineTo(x + wide, y + 4);
    });
    haloed(context, text, x + wide + 6, y + 4, colour);
  });
}
