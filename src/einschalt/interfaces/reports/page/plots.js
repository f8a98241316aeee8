// Plots as SVG, drawn anew where their place gets another width; colours come from CSS.

const MOST_BARS = 44;

class Plot {
  constructor(host, { title, said, how, draw, height = 230, wide = false }) {
    this.draw = draw;
    this.height = height;
    this.wide = wide;
    this.place = element("div", { class: "plot-place" });
    this.title = title;
    this.said = element("span", {}, said);
    this.figure = element("figure", { class: wide ? "plot wide" : "plot" }, element("figcaption", {}, element("b", {}, title), " ", this.said,
      how ? element("span", { class: "how" }, ` ${how}`) : ""), this.place);
    host.append(this.figure);
    scheme.listeners.push(() => this.show());
    new ResizeObserver(() => requestAnimationFrame(() => {
      if (Math.abs(Math.max(this.place.clientWidth, 240) - this.width) > 2) this.show();
    })).observe(this.place);
    this.show();
  }

  show() {
    const onPaper = this.wide ? 660 : 320;
    this.width = scheme.printing ? onPaper : Math.max(this.place.clientWidth, 240);
    const sheet = svg("svg", { viewBox: `0 0 ${this.width} ${this.height}`, width: "100%", role: "img", "aria-label": `${this.title}. ${this.said.textContent}` });
    this.draw(new Axes(sheet, this.width, this.height));
    this.place.replaceChildren(sheet);
  }
}

/** Axes of a plot: places of values, ticks, and signs drawn at them. */
class Axes {
  constructor(sheet, width, height) {
    Object.assign(this, { sheet, width, height, left: 46, right: width - 10, top: 24, bottom: height - 36 });
  }

  range(x, y) {
    this.x = (value) => this.left + ((value - x[0]) / (x[1] - x[0] || 1)) * (this.right - this.left);
    this.y = (value) => this.bottom - ((value - y[0]) / (y[1] - y[0] || 1)) * (this.bottom - this.top);
    this.xRange = x;
    this.yRange = y;
    return this;
  }

  add(tag, facts, text) {
    const made = svg(tag, facts);
    if (text !== undefined) made.textContent = text;
    this.sheet.append(made);
    return made;
  }

  line(points, cls) {
    this.add("path", { d: points.map(([x, y], k) => `${k ? "L" : "M"}${this.x(x).toFixed(1)} ${this.y(y).toFixed(1)}`).join(""), class: cls });
  }

  axes(xTitle, yTitle, { xText, yText, noX } = {}) {
    const xs = noX ? [] : ticks(...this.xRange, this.width / 90), ys = ticks(...this.yRange, this.height / 60);
    const step = (places) => (places.length > 1 ? places[1] - places[0] : 1);
    for (const y of ys) {
      this.add("path", { d: `M${this.left} ${this.y(y)}H${this.right}`, class: "grid" });
      this.add("text", { x: this.left - 5, y: this.y(y) + 4, class: "tick end" }, (yText || tickText)(y, step(ys)));
    }
    for (const x of xs) this.add("text", { x: this.x(x), y: this.bottom + 15, class: "tick mid" }, (xText || tickText)(x, step(xs)));
    this.add("path", { d: `M${this.left} ${this.bottom}H${this.right}`, class: "axis" });
    this.add("text", { x: this.right, y: this.height - 4, class: "title end" }, xTitle);
    this.add("text", { x: 2, y: this.top - 13, class: "title" }, yTitle);
    return this;
  }
}

const inUnit = (value, step) => tickText(value / unit.metres, step / unit.metres);

/** Bars that hold as many of the errors that occur, a multiple of a step: no comb appears. */
function barsOf(scale, step) {
  const low = scale.low - step / 2, span = scale.high + step / 2 - low;
  const width = Math.max(Math.round(span / MOST_BARS / step), 1) * step;
  return { low, width, n: Math.max(Math.ceil(span / width - 1e-9), 1) };
}

/** Histogram of standard errors: the key of the map's colours, and a brush. */
function precisionPlot(host, points, scale, selection, claim) {
  const errors = Float64Array.from(points.places.filter((i) => points.isNew(i)), (i) => points.error[i]), known = sorted(errors);
  if (!known.length) return;
  const { low, width, n } = barsOf(scale, points.errorStep), counts = new Uint32Array(n);
  const binOf = (error) => Math.min(Math.floor((Math.min(error, scale.high) - low) / width), n - 1);
  for (const error of known) counts[Math.max(binOf(error), 0)]++;
  const [median, most, largest] = [0.5, 0.95, 1].map((part) => quantile(known, part));
  const said = translated("Median {median}, 95th percentile {most}, largest {largest}.", { median: errorWithUnit(median), most: errorWithUnit(most), largest: errorWithUnit(largest) });
  let brushed = null;
  const choose = (first, last) => {
    brushed = [first, last];
    const from = low + first * width, to = last === n - 1 ? Infinity : low + (last + 1) * width;
    selection.highlight(points.n, (i) => points.isNew(i) && points.error[i] >= from - 1e-12 && points.error[i] < to,
      (found) => to === Infinity ? translated("{n:point|points} of {from} or more", { n: found, from: errorWithUnit(from) })
        : translated("{n:point|points} of {from}–{to}", { n: found, from: errorText(from), to: errorWithUnit(to) }), "histogram");
  };
  const plot = new Plot(host, { title: translated("{claim} of the new points", { claim }), said, how: translated("Drag over the bars to highlight their points."), height: 170, wide: true, draw: (axes) => {
    axes.range([low, low + n * width], [0, Math.max(...counts) * 1.05]).axes(`[${unit.name}]`, translated("points"), { xText: inUnit });
    counts.forEach((c, k) => {
      const x = axes.x(low + k * width), wide = axes.x(low + (k + 1) * width) - x;
      const isOut = brushed && (k < brushed[0] || k > brushed[1]);
      axes.add("rect", { x, y: axes.y(c), width: Math.max(wide - 1, 0.5), height: Math.max(axes.bottom - axes.y(c), 0), fill: scale.css(low + (k + 0.5) * width), opacity: isOut ? 0.25 : 1 });
    });
    for (const [value, text] of [[median, translated("median")], [most, "95 %"]]) {
      if (value > scale.high) continue;
      axes.add("path", { d: `M${axes.x(value)} ${axes.top}V${axes.bottom}`, class: "mark" });
      axes.add("text", { x: axes.x(value) + 3, y: axes.top + 9, class: "tick over" }, text);
    }
    brush(axes, n, choose);
  } });
  rangeFields(host, { low, width, n, unit: unit.name, perUnit: unit.metres }, choose);
  selection.follow((change, by) => {
    if (!("mask" in change)) return;
    if (by !== "histogram") brushed = null;
    plot.show();
  });
}

/** Choose bars with the pointer: one by a click, several by dragging. */
function brush(axes, n, choose) {
  const sheet = axes.sheet;
  const bar = (event) => {
    const box = sheet.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * axes.width;
    return Math.min(Math.max(Math.floor(((x - axes.left) / (axes.right - axes.left)) * n), 0), n - 1);
  };
  let from = -1;
  sheet.classList.add("brush");
  sheet.addEventListener("pointerdown", (event) => { from = bar(event); event.preventDefault(); });
  sheet.addEventListener("pointerup", (event) => {
    if (from < 0) return;
    const to = bar(event);
    choose(Math.min(from, to), Math.max(from, to));
    from = -1;
  });
}

/** The same by the keyboard: from and to. */
function rangeFields(host, { low, width, n, unit, perUnit }, choose) {
  const field = (title) => element("input", { type: "text", inputmode: "decimal", pattern: "[\\-−]?[0-9]*[.,]?[0-9]+", "aria-label": title, placeholder: title });
  const from = field(translated("from [{unit}]", { unit })), to = field(translated("to [{unit}]", { unit }));
  const bin = (text, otherwise) => text === "" ? otherwise : Math.min(Math.max(Math.floor((typedFigure(text) * perUnit - low) / width), 0), n - 1);
  const act = () => { if (from.reportValidity() && to.reportValidity()) choose(bin(from.value, 0), bin(to.value, n - 1)); };
  host.append(element("p", { class: "range" }, translated("Highlight points"), " ", from, " ", to, " ",
    element("button", { type: "button", class: "quiet", onclick: act }, translated("Highlight"))));
}

/** Histogram and Q–Q plot; with `linked` its bars highlight the points that have such a residual. */
function distributionPlots(host, given, title, said, linked = null) {
  const most = Math.max(...given.counts) * 1.08, width = given.edges[1] - given.edges[0], n = given.counts.length;
  const bell = (x) => (given.n * width * Math.exp((-x * x) / 2)) / Math.sqrt(2 * Math.PI);
  const far = given.n_far ? ` ${translated("{n:value|values} beyond ±5, drawn at the ends.", { n: given.n_far })}` : "";
  let brushed = null;
  const choose = (low, high) => {
    brushed = [low, high];
    const { points, selection } = linked, half = n / 2, masks = [0, 0];
    for (let k = low; k <= high; k++) masks[k < half ? 0 : 1] |= 1 << k % half;
    const from = fixed(given.edges[low], 2), to = fixed(given.edges[high + 1], 2);
    // what is farther out stands in the outer bars
    const said = (found) => !low && high === n - 1 ? translated("{n:point|points} with a residual", { n: found })
      : !low ? translated("{n:point|points} with a residual of up to {to} standard deviations", { n: found, to })
      : high === n - 1 ? translated("{n:point|points} with a residual of {from} standard deviations or more", { n: found, from })
      : translated("{n:point|points} with a residual of {from} to {to} standard deviations", { n: found, from, to });
    selection.highlight(points.n, (i) => (points.bins_low[i] & masks[0]) | (points.bins_high[i] & masks[1]),
      said, "residuals");
  };
  const how = linked ? translated("Drag over the bars to highlight their points.") : "";
  const plot = new Plot(host, { title, said: `${said}${far}`, how, draw: (axes) => {
    axes.range([-5, 5], [0, Math.max(most, bell(0) * 1.05)]).axes(translated("standard deviations"), translated("values"));
    given.counts.forEach((c, k) => axes.add("rect", { x: axes.x(given.edges[k]) + 0.5, y: axes.y(c), width: axes.x(given.edges[k + 1]) - axes.x(given.edges[k]) - 1, height: axes.bottom - axes.y(c), 
      class: brushed && (k < brushed[0] || k > brushed[1]) ? "bar faded" : "bar" }));
    axes.line(Array.from({ length: 81 }, (_, k) => [-5 + k / 8, bell(-5 + k / 8)]), "curve");
    if (linked) brush(axes, n, choose);
  } });
  if (linked) {
    rangeFields(plot.figure, { low: given.edges[0], width, n, unit: "σ", perUnit: 1 }, choose);
    linked.selection.follow((change, by) => {
      if (!("mask" in change)) return;
      if (by !== "residuals") brushed = null;
      plot.show();
    });
  }
  const end = Math.max(...given.expected) * 1.05, reach = Math.max(end, Math.min(Math.max(...given.observed.map(Math.abs)) * 1.05, 8));
  new Plot(host, { title: translated("Normal Q–Q"), said: translated("Points lie on the line if errors are normal; tails that bend away contain gross errors."), draw: (axes) => {
    axes.range([-end, end], [-reach, reach]).axes(translated("normal"), translated("observed"));
    axes.line([[-end, -end], [end, end]], "expected");
    given.expected.forEach((x, k) => axes.add("circle", { cx: axes.x(x), cy: axes.y(Math.min(Math.max(given.observed[k], -reach), reach)), r: 2, class: "dot" }));
  } });
}

/** m_0 of each model in the order of the models, a colour for each flight. */
function modelPlot(host, models, selection) {
  const rows = models.places.filter((m) => isNumber(models.m_0[m]));
  if (rows.length < 2) return;
  const all = sorted(rows.map((m) => models.m_0[m])), top = Math.min(all[all.length - 1], 4 * quantile(all, 0.9)) * 1.06;
  const flights = models.flight.texts, every = Math.ceil(rows.length / 1500);
  const shown = rows.filter((m, k) => k % every === 0 || models.m_0[m] >= quantile(all, 0.98));
  const cut = all[all.length - 1] > top ? ` ${translated("Largest {length}, drawn at the upper edge.", { length: errorWithUnit(all[all.length - 1]) })}` : "";
  const thin = shown.length < rows.length ? ` ${translated("{n} of {all} are drawn, including the largest.", { n: count(shown.length), all: count(rows.length) })}` : "";
  const said = `${translated("Median {length}.", { length: errorWithUnit(quantile(all, 0.5)) })}${cut}${thin}`;
  const plot = new Plot(host, { title: translated("m_0 of the models"), said, how: translated("Click a model to see it on the map."), wide: true, draw: (axes) => {
    axes.range([0, rows.length], [0, top]).axes(translated("models in their order"), `m_0 [${unit.name}]`, { yText: inUnit, noX: true });
    const place = new Map(rows.map((m, k) => [m, k]));
    for (const m of shown) {
      const dot = axes.add("circle", { cx: axes.x(place.get(m) + 0.5), cy: axes.y(Math.min(models.m_0[m], top)), r: m === selection.model ? 5 : 2.6,
        class: `model f${models.flight.code(m)}${models.usable[m] ? "" : " failed"}${m === selection.model ? " chosen" : ""}` });
      dot.append(svg("title", {}, `${flightText(models.flight(m))} ${models.coverage(m)} ${models.name(m)}: ${errorWithUnit(models.m_0[m])}`));
      dot.addEventListener("click", () => selection.choose({ model: m, point: -1 }, "plot"));
    }
    flights.forEach((name, k) => {
      axes.add("circle", { cx: axes.right - 90 * (flights.length - k) + 10, cy: 9, r: 3.5, class: `model f${k}` });
      axes.add("text", { x: axes.right - 90 * (flights.length - k) + 18, y: 13, class: "tick" }, flightTitle(name));
    });
  } });
  selection.follow((change) => { if ("model" in change) plot.show(); });
}

function correlogramPlot(host, given) {
  const low = Math.min(...given.low, ...given.measured, -0.05), high = Math.max(...given.high, ...given.measured, 0.05);
  new Plot(host, { title: translated("Correlation of residuals by distance"), said: translated("Band: expected if the stated precision is correct (±2 standard deviations); line: measured."), wide: true, draw: (axes) => {
    axes.range([0, Math.max(...given.distance) * 1.05], [low * 1.1, high * 1.1]).axes(translated("distance [m]"), translated("correlation"));
    const band = [...given.claimed_distance.map((d, k) => [d, given.high[k]]), ...given.claimed_distance.map((d, k) => [d, given.low[k]]).reverse()];
    axes.line(band, "band");
    axes.line([[0, 0], [axes.xRange[1], 0]], "zero");
    axes.line(given.distance.map((d, k) => [d, given.measured[k]]), "curve");
    given.distance.forEach((d, k) => axes.add("circle", { cx: axes.x(d), cy: axes.y(given.measured[k]), r: 3, class: "dot strong" }));
  } });
}

/** The paper's figure beside the claimed one, a dot for each point. */
function paperPlot(host, points, claim) {
  if (!points.paper || claim === "standard_error_paper") return;
  const rows = points.places.filter((i) => points.isNew(i) && isNumber(points.paper[i]) && isNumber(points.error[i]));
  if (rows.length < 3) return;
  const every = Math.ceil(rows.length / 1500), shown = rows.filter((_, k) => k % every === 0);
  const below = rows.reduce((n, i) => n + (points.paper[i] < points.error[i] ? 1 : 0), 0);
  const rangeOf = (values) => {
    const known = sorted(Float64Array.from(rows, (i) => values[i]));
    return [known[0] * 0.9, Math.min(known[known.length - 1], 2 * quantile(known, 0.95)) * 1.05];
  };
  const x = rangeOf(points.error), y = rangeOf(points.paper), low = Math.max(x[0], y[0]), high = Math.min(x[1], y[1]);
  new Plot(host, { title: translated("Paper and propagated standard error"), said: translated("The paper’s figure is the smaller one at {share} of the new points.", { share: `${Math.round((100 * below) / rows.length)} %` }), draw: (axes) => {
    axes.range(x, y).axes(`${claim} [${unit.name}]`, `standard_error_paper [${unit.name}]`, { xText: inUnit, yText: inUnit });
    if (low < high) axes.line([[low, low], [high, high]], "expected"); // as large as each other
    for (const i of shown) if (points.error[i] <= x[1] && points.paper[i] <= y[1]) axes.add("circle", { cx: axes.x(points.error[i]), cy: axes.y(points.paper[i]), r: 1.8, class: "dot" });
  } });
}

/** Shares of the block in one bar, and variances from good points to bad. */
function sourcesPlot(host, given) {
  const percent = (share) => `${Math.round(100 * share)} %`;
  const said = given.names.map((name, k) => `${name} ${percent(given.shares[k])}`).join(", ");
  new Plot(host, { title: translated("Sources of the error of the new points"), said: `${said}.`, wide: true, height: 270, draw: (axes) => {
    let left = 46;
    const wide = axes.width - 56;
    given.shares.forEach((share, k) => {
      axes.add("rect", { x: left, y: 4, width: Math.max(share * wide - 1, 0), height: 24, class: `source ${given.codes[k]}` });
      if (share * wide > 40) axes.add("text", { x: left + (share * wide) / 2, y: 21, class: "on mid" }, percent(share));
      left += share * wide;
    });
    let x = 46, y = 46;
    given.names.forEach((name, k) => {
      const long = 26 + 6.4 * name.length;
      if (x + long > axes.width) { x = 46; y += 17; }
      axes.add("rect", { x, y: y - 9, width: 11, height: 11, class: `source ${given.codes[k]}` });
      axes.add("text", { x: x + 16, y, class: "tick" }, name);
      x += long;
    });
    const sums = given.classes.map((row) => row.reduce((a, b) => a + b, 0)), n = sums.length;
    axes.top = y + 34;
    axes.range([0, n], [0, Math.max(...sums) * 1.05]).axes(n > 1 ? translated("tenths of the new points, from good to bad [{unit}]", { unit: unit.name }) : `[${unit.name}]`, translated("variance [{unit}²]", { unit: unit.name }),
      { noX: true, yText: (v, s) => tickText(v / unit.metres ** 2, s / unit.metres ** 2) });
    given.classes.forEach((row, c) => {
      let base = 0;
      row.forEach((v, k) => {
        axes.add("rect", { x: axes.x(c + 0.08), y: axes.y(base + v), width: axes.x(c + 0.92) - axes.x(c + 0.08), height: Math.max(axes.y(base) - axes.y(base + v), 0), class: `source ${given.codes[k]}` });
        base += v;
      });
      axes.add("text", { x: axes.x(c + 0.5), y: axes.bottom + 15, class: "tick mid" }, errorText(Math.sqrt(base)));
    });
  } });
}
