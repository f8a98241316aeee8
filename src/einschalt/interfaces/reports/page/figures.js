// Figures as text: one unit for all errors of the page, metres for coordinates.

const MISSING = "–";
const unit = { name: "cm", metres: 0.01, decimals: 1 };

function setUnit(given, usual) {
  Object.assign(unit, given);
  // usual errors keep two digits, and one more to compare
  const size = usual > 0 ? usual / unit.metres : 1;
  unit.decimals = Math.min(Math.max(2 - Math.floor(Math.log10(size)) - 1, 0), 3);
}

const isNumber = Number.isFinite;

function fixed(value, decimals) {
  if (!isNumber(value)) return MISSING;
  const text = value.toFixed(decimals);
  return localized(Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−"));
}

/** An error without its unit, which stands in the head of the column. */
const errorText = (metres) => fixed(metres / unit.metres, unit.decimals);

const errorWithUnit = (metres) =>
  isNumber(metres) ? `${errorText(metres)} ${unit.name}` : MISSING;

const coordinateText = (metres) => fixed(metres, 3);

const rounded = (value) => localized(`${Number(value.toPrecision(6))}`);

function groundText(metres) {
  if (metres >= 1000) return `${rounded(metres / 1000)} km`;
  if (metres >= 1) return `${rounded(metres)} m`;
  if (metres >= 0.01) return `${rounded(metres * 100)} cm`;
  if (metres >= 0.0001) return `${rounded(metres * 1000)} mm`;
  return `${rounded(metres * 1e6)} µm`;
}

/** Size of a bar: in the unit of errors as far as that is readable. */
function barText(metres) {
  const value = metres / unit.metres;
  return value >= 0.01 && value < 1000 ? `${rounded(value)} ${unit.name}` : groundText(metres);
}

/** A count as the text of the page has it: German groups five digits and more. */
const count = (n) => words.decimal === "." || n < 10000 ? `${n}` : n.toLocaleString("en").replaceAll(",", "\u202f");

/** By how much errors are drawn larger than the ground, to two digits. */
function factorText(factor) {
  const round = Number(factor.toPrecision(2));
  return round < 10000 ? localized(`${round}`) : count(round);
}

function roundDown(value, steps = [1, 2, 3, 5]) {
  const power = 10 ** Math.floor(Math.log10(value));
  const most = (value / power) * (1 + 1e-12);
  return Number((Math.max(...steps.filter((s) => s <= most), 1) * power).toPrecision(1));
}

/** Round places of an axis, about so many. */
function ticks(low, high, about) {
  const raw = (high - low) / Math.max(about, 1);
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((s) => s * power >= raw * 0.7) * power;
  const places = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) places.push(k * step);
  return places;
}

function tickText(value, step) {
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return fixed(value, Math.min(decimals, 6));
}

/** Known values, ascending. */
function sorted(values) {
  return Float64Array.from(values).filter(isNumber).sort();
}

function quantile(ascending, part) {
  if (!ascending.length) return NaN;
  const place = part * (ascending.length - 1), below = Math.floor(place);
  const above = Math.min(below + 1, ascending.length - 1);
  return ascending[below] + (place - below) * (ascending[above] - ascending[below]);
}

/** An element; its content is text, never markup: names are what users wrote. */
function element(tag, facts = {}, ...content) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(facts)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...content);
  return made;
}
