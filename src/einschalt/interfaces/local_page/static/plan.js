// Sliders: figures at once, and the map when they rest.
const form = document.getElementById("plan");
const figures = document.getElementById("figures");
const said = document.getElementById("said");
const map = document.getElementById("map");
const mapSaid = document.getElementById("map-said");
const REST = 500; // ms
const LANGUAGE = document.documentElement.lang;
let asked = null, drawn = null, timer = 0;

const query = () => new URLSearchParams(new FormData(form)).toString();
const shown = (value) => Number(value).toLocaleString(LANGUAGE, { useGrouping: false, maximumFractionDigits: 6 });
const element = (name, text) => Object.assign(document.createElement(name), { textContent: text });

const answer = async () => {
  asked?.abort();
  asked = new AbortController();
  const { signal } = asked;
  const got = await (await fetch(`/plan/figures?${query()}`, { signal })).json();
  said.textContent = got.said;
  figures.replaceChildren(...got.figures.map(([figure, what]) => {
    const row = document.createElement("div");
    row.append(element("dt", what), element("dd", figure));
    return row;
  }));
};
const draw = async () => {
  drawn?.abort();
  drawn = new AbortController();
  mapSaid.textContent = form.dataset.drawing;
  map.classList.add("old");
  const got = await fetch(`/plan/map?${query()}`, { signal: drawn.signal });
  if (!got.ok) {
    map.replaceChildren();
    mapSaid.textContent = got.status === 422 ? (await got.json()).said : got.statusText;
    return;
  }
  const drawing = await got.json();
  const svg = new DOMParser().parseFromString(drawing.svg, "image/svg+xml").documentElement;
  map.replaceChildren(document.importNode(svg, true));
  map.classList.remove("old");
  mapSaid.textContent = drawing.said;
};
const unlessAborted = (fault) => {
  if (fault.name !== "AbortError") said.textContent = form.dataset.silent;
};
const changed = () => {
  for (const slider of form.querySelectorAll("input[type=range]")) {
    const text = `${shown(slider.value)} ${slider.dataset.unit}`.trim();
    slider.nextElementSibling.value = text;
    slider.setAttribute("aria-valuetext", text);
  }
  history.replaceState(null, "", `/plan?${query()}`);
  answer().catch(unlessAborted);
  clearTimeout(timer);
  timer = setTimeout(() => draw().catch(unlessAborted), REST);
};
form.addEventListener("input", ({ target }) => {
  if (target.name === "camera") location.assign(`/plan?camera=${target.value}`);
  else changed();
});
form.addEventListener("submit", (event) => event.preventDefault());
draw().catch(unlessAborted);
