// Tables that sort, search, turn their pages and go out as CSV.

const PAGE_ROWS = 10;
const MOST_ON_PAPER = 200; // rows
const KNOWN = "K"; // before the number of a known point
const KNOWN_NUMBER = new RegExp(`^${KNOWN}(\\d)`);

// as in the CSV files beside the page: names that a spreadsheet would compute
const SIGNS = "=+\\-@＝＋－＠";
const FORMULA = new RegExp(`^[\\t\\r]*[${SIGNS}]`);
const NO_FORMULA = new RegExp(`^([+-]\\d\\w*|[+-](\\d+\\.?\\d*|\\.\\d+)([eE][+-]?\\d+)?|[${SIGNS}]+)$`);
const MARKED = new RegExp(`^'('*[\\t\\r${SIGNS}])`);
const INNER_FORMULA = new RegExp(`(; *)('*[\\t\\r]*[${SIGNS}])`, "g");

/** A text as no spreadsheet takes it for a formula: an apostrophe before it. */
function tamed(text) {
  const inner = text.replace(INNER_FORMULA, "$1'$2");
  return MARKED.test(inner) || (FORMULA.test(inner) && !NO_FORMULA.test(inner)) ? `'${inner}` : inner;
}

/** A table of columns {title, text(i), value(i), isNumber}; `rowOf` makes or finds a row. */
class Table {
  constructor(host, { title, columns, n, file, noun, onPick, isChosen, old }) {
    Object.assign(this, { title, columns, n, file, noun, onPick, isChosen, old });
    this.order = Uint32Array.from({ length: n }, (_, i) => i);
    this.sortedBy = -1;
    this.rows = PAGE_ROWS;
    this.first = 0;
    this.mask = null;
    // on paper there is no next page
    if (n <= MOST_ON_PAPER) scheme.listeners.push(() => { this.rows = scheme.printing ? n : PAGE_ROWS; this._title(); this.show(); });
    this._build(host);
    this.show();
  }

  _build(host) {
    this.search = element("input", { type: "search", placeholder: translated("Search"), "aria-label": translated("Search {table}", { table: this.title }), oninput: () => this._later() });
    this.count = element("span", { class: "count", "aria-live": "polite" });
    const button = (text, title, act) => element("button", { type: "button", class: "quiet", "aria-label": title, title, onclick: act }, text);
    this.pager = element("span", { class: "pager" },
      button("«", translated("First page"), () => this._turn(0)), button("‹", translated("Page before"), () => this._turn(this.first - this.rows)),
      button("›", translated("Next page"), () => this._turn(this.first + this.rows)),
      button("»", translated("Last page"), () => this._turn(this._lastPage())));
    const csv = button("CSV", translated("Save {table} as CSV", { table: this.title }), () => this.save());
    const bar = element("div", { class: "table-bar" }, this.search, this.count, this.pager, csv);
    if (this.old) this._adopt(host, bar);
    else this._make(host, bar);
    this._title();
  }

  /** Heads that sort; as text on paper, where a button is not repeated on the next page. */
  _title() {
    this.heads.forEach((head, c) => {
      const text = head.textContent;
      head.replaceChildren(scheme.printing ? text : element("button", { type: "button", class: "sort", onclick: () => this.sort(c) }, text));
    });
  }

  _make(host, bar) {
    this.heads = this.columns.map((column) => element("th", { scope: "col", class: column.isNumber ? "n" : undefined }, column.title));
    this.body = element("tbody");
    const table = this.table = element("table", {}, element("caption", {}, this.title), element("thead", {}, element("tr", {}, ...this.heads)), this.body);
    const isPrinted = this.n <= MOST_ON_PAPER;
    const place = element("div", { class: `scroll${isPrinted ? "" : " unprinted"}`, role: "region", tabindex: 0, "aria-label": this.title }, table);
    host.replaceChildren(bar, place);
    if (!isPrinted) host.append(element("p", { class: "remark on-paper" }, translated("{number}: see {file}.", { number: this.noun(this.n), file: `${this.file}.csv` })));
    watchTable(table);
  }

  /** Take over a table that stands in the page already. */
  _adopt(table, bar) {
    this.table = table;
    this.heads = [...table.tHead.rows[0].cells];
    this.body = table.tBodies[0];
    if (this.n > PAGE_ROWS) table.parentElement.before(bar);
  }

  _later() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.find(this.search.value), 120);
  }

  find(text) {
    this.wanted = text.trim().toLowerCase();
    this._arrange();
  }

  /** Show highlighted points alone; all where there is no mask. */
  only(mask) {
    this.mask = mask;
    this._arrange();
  }

  sort(c) {
    this.isDown = this.sortedBy === c ? !this.isDown : this.columns[c].isNumber && !this.old;
    this.sortedBy = c;
    this.heads.forEach((head, k) => {
      if (k === c) head.setAttribute("aria-sort", this.isDown ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    });
    this._arrange();
  }

  _arrange() {
    const searched = this.columns.filter((column) => !column.isNumber);
    const found = [];
    for (let i = 0; i < this.n; i++) {
      if (this.mask && !this.mask[i]) continue;
      if (this.wanted && !searched.some((column) => column.text(i).toLowerCase().includes(this.wanted))) continue;
      found.push(i);
    }
    this.order = Uint32Array.from(found);
    if (this.sortedBy >= 0) this.order.sort(this._comparison(this.columns[this.sortedBy], this.isDown ? -1 : 1));
    this.first = 0;
    this.show();
  }

  _comparison(column, sign) {
    if (!column.isNumber) {
      const collator = new Intl.Collator(words.language, { numeric: true });
      return (a, b) => sign * collator.compare(column.text(a), column.text(b)) || a - b;
    }
    return (a, b) => {
      const one = column.value(a), other = column.value(b);
      // what is not known comes last, whichever way
      if (!isNumber(one) || !isNumber(other)) return isNumber(other) - isNumber(one) || a - b;
      return sign * (one - other) || a - b;
    };
  }

  _lastPage() {
    return Math.max(Math.floor((this.order.length - 1) / this.rows) * this.rows, 0);
  }

  _turn(first) {
    this.first = Math.min(Math.max(first, 0), this._lastPage());
    this.show();
  }

  /** Turn to the page of a row, where it is among those that are shown. */
  turnTo(i) {
    const place = this.order.indexOf(i);
    if (place >= 0) this.first = Math.floor(place / this.rows) * this.rows;
    this.show();
  }

  show() {
    const first = Math.min(this.first, this._lastPage()); // on paper all is one page
    const shown = this.order.subarray(first, first + this.rows);
    const held = this.shown && this.shown[[...this.body.rows].indexOf(document.activeElement)];
    this.shown = shown;
    this.body.replaceChildren(...Array.from(shown, (i) => this._row(i)));
    // whoever goes by keys stays on the row
    if (held !== undefined && shown.includes(held)) this.body.rows[shown.indexOf(held)].focus({ preventScroll: true });
    const all = this.order.length, last = first + shown.length;
    const number = this.noun(all);
    this.count.textContent = all > shown.length
      ? translated("{from}–{to} of {number}", { from: count(first + 1), to: count(last), number }) : number;
    this.pager.hidden = all <= this.rows;
    // told, and not taken away: the key that turned the page stays where it is
    [...this.pager.children].forEach((one, k) => one.setAttribute("aria-disabled", k < 2 ? first === 0 : last === all));
    fitRows(this.table);
  }

  _row(i) {
    const row = this.old ? this.old[i] : element("tr", {}, ...this.columns.map((column, c) =>
      element(c ? "td" : "th", { class: column.isNumber ? "n" : undefined, scope: c ? undefined : "row" }, column.text(i))));
    if (this.onPick) pickable(row, () => this.onPick(i), this.isChosen && this.isChosen(i));
    return row;
  }

  csv() {
    const cell = (text) => (/[",\n\r;]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const plain = (column, i) => {
      const text = column.text(i);
      if (!column.isNumber) return cell(tamed(text));
      return text === MISSING ? "" : localized(plainFigure(text));
    };
    // where figures have a comma, spreadsheets part cells by a semicolon
    const between = words.decimal === "," ? ";" : ",";
    const lines = [this.columns.map((column) => cell(column.title)).join(between)];
    for (const i of this.order) lines.push(this.columns.map((column) => plain(column, i)).join(between));
    return `\ufeff${lines.join("\r\n")}\r\n`;
  }

  save() {
    const place = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv;charset=utf-8" }));
    const link = element("a", { href: place, download: `${this.file}.csv` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(place), 10000);
  }
}

/** A row that leads somewhere, for the pointer and for keys. */
function pickable(row, act, isChosen) {
  row.classList.toggle("chosen", Boolean(isChosen));
  if (row.dataset.pick) return;
  row.dataset.pick = "1";
  row.tabIndex = 0;
  row.classList.add("pick");
  row.addEventListener("click", act);
  row.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") { event.preventDefault(); act(); }
  });
}

/** Make a table of the page sort, search and lead to its points. */
function adopted(table, selection) {
  const rows = [...table.tBodies[0].rows];
  const point = (i) => (rows[i].dataset.point === undefined ? -1 : Number(rows[i].dataset.point));
  const columns = [...table.tHead.rows[0].cells].map((head, c) => {
    const text = (i) => rows[i].cells[c].textContent;
    return { title: head.textContent, isNumber: head.classList.contains("n"), text, value: (i) => parseFloat(plainFigure(text(i).replace(KNOWN_NUMBER, "$1"))) };
  });
  const leads = rows.length > 0 && point(0) >= 0;
  return new Table(table, {
    title: table.caption ? table.caption.textContent : table.dataset.table, columns, n: rows.length, file: table.dataset.table,
    noun: (n) => translated("{n:row|rows}", { n }), old: rows, isChosen: leads ? (i) => point(i) === selection.point : undefined,
    onPick: leads ? (i) => selection.choose({ point: point(i), model: -1 }, "table") : undefined,
  });
}

function pointTable(host, points, selection, claim) {
  const known = (values) => values && { text: (i) => errorText(values[i]), value: (i) => values[i], isNumber: true };
  const whole = (values) => values && { text: (i) => fixed(values[i], 0), value: (i) => values[i], isNumber: true };
  const place = (values) => values && { text: (i) => coordinateText(values[i]), value: (i) => values[i], isNumber: true };
  const columns = [
    [translated("point"), { text: points.name }], [translated("role"), { text: (i) => roleText(points.role(i)) }],
    [translated("easting [m]"), place(points.east)], [translated("northing [m]"), place(points.north)], [translated("height [m]"), place(points.height)],
    [`${claimText(claim)} [${unit.name}]`, known(points.error)],
    [`${translated("paper")} [${unit.name}]`, known(points.paper)], [`${translated("internal")} [${unit.name}]`, known(points.internal)],
    [`${translated("spread")} [${unit.name}]`, known(points.spread)],
    [translated("models"), whole(points.models)], [translated("coverages"), whole(points.coverages)],
    [translated("largest |w|"), points.w && { text: (i) => fixed(points.w[i], 1), value: (i) => points.w[i], isNumber: true }],
    [translated("suspect"), points.suspect && { text: (i) => (points.suspect[i] ? translated("suspect") : "") }],
  ].filter(([, column]) => column).map(([title, column]) => ({ title, ...column }));
  const table = new Table(host, { title: translated("All points"), columns, n: points.n, file: "points", noun: (n) => translated("{n:point|points}", { n }),
    isChosen: (i) => i === selection.point, onPick: (i) => selection.choose({ point: i, model: -1 }, "points") });
  selection.follow((change, by) => {
    if ("mask" in change) table.only(selection.mask);
    else if (by !== "points") table.turnTo(selection.point);
    else table.show();
  });
  return table;
}

function modelTable(details, models, selection) {
  const error = (values) => values && { text: (i) => errorText(values[i]), value: (i) => values[i], isNumber: true };
  const whole = (values) => ({ text: (i) => fixed(values[i], 0), value: (i) => values[i], isNumber: true });
  const state = (i) => (models.usable[i] ? translated("usable") : translated("failed: {reason}", { reason: models.reason(i) }));
  const columns = [
    [translated("model"), { text: models.name }], [translated("flight"), { text: (i) => flightText(models.flight(i)) }],
    [translated("coverage"), { text: models.coverage }], [translated("fit"), { text: models.fit }],
    [translated("points"), whole(models.points)], [translated("redundancy"), whole(models.redundancy)],
    [`m_0 [${unit.name}]`, error(models.m_0)], [`s_0 [${unit.name}]`, error(models.s_0)],
    ["σ₀ [µm]", models.sigma_0 && { text: (i) => fixed(models.sigma_0[i] * 1e6, 1), value: (i) => models.sigma_0[i], isNumber: true }],
    [translated("state"), { text: state }],
  ].filter(([, column]) => column).map(([title, column]) => ({ title, ...column }));
  const host = element("div");
  const summary = details.querySelector("summary");
  const failed = models.usable.reduce((n, usable) => n + (usable ? 0 : 1), 0);
  summary.textContent = failed ? translated("Models: {n:row|rows}, {failed} failed", { n: models.n, failed: count(failed) })
    : translated("Models: {n:row|rows}", { n: models.n });
  details.replaceChildren(summary, host);
  const table = new Table(host, { title: translated("Models"), columns, n: models.n, file: "models", noun: (n) => translated("{n:model|models}", { n }),
    isChosen: (i) => i === selection.model, onPick: (i) => selection.choose({ model: i, point: -1 }, "models") });
  selection.follow((change, by) => {
    if (!("model" in change)) return;
    if (by !== "models" && selection.model >= 0) table.turnTo(selection.model);
    else table.show();
  });
  return table;
}
