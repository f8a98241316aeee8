// What is chosen: map, tables and histogram look at it, and each may change it.

class Selection extends EventTarget {
  point = -1;
  model = -1;
  mask = null; // Uint8Array, 1 for each point that is highlighted
  said = () => ""; // what so many highlighted points have in common

  choose(change, by) {
    Object.assign(this, change);
    this.dispatchEvent(new CustomEvent("change", { detail: { change, by } }));
  }

  highlight(n, isIn, said, by) {
    const mask = new Uint8Array(n);
    let found = 0;
    for (let i = 0; i < n; i++) if (isIn(i)) { mask[i] = 1; found++; }
    this.choose({ mask, found, said }, by);
  }

  clear(by) {
    this.choose({ point: -1, model: -1, mask: null, said: () => "" }, by);
  }

  follow(listener) {
    this.addEventListener("change", (event) => listener(event.detail.change, event.detail.by));
  }
}

// Light or dark: as the system has it, until the switch says otherwise; paper is light.
const darkSystem = matchMedia("(prefers-color-scheme: dark)");
const scheme = { chosen: "auto", printing: false, listeners: [] };

function isDark() {
  if (scheme.printing) return false;
  return scheme.chosen === "auto" ? darkSystem.matches : scheme.chosen === "dark";
}

function schemeChanged() {
  if (scheme.chosen === "auto") delete document.documentElement.dataset.scheme;
  else document.documentElement.dataset.scheme = scheme.chosen;
  for (const listener of scheme.listeners) listener();
}

function schemeSwitch(host) {
  const button = element("button", { type: "button", class: "quiet" });
  const name = () => {
    button.textContent = isDark() ? translated("Light") : translated("Dark");
    button.setAttribute("aria-label", isDark() ? translated("Show the page light") : translated("Show the page dark"));
  };
  button.addEventListener("click", () => {
    scheme.chosen = isDark() ? "light" : "dark";
    schemeChanged();
  });
  scheme.listeners.push(name);
  darkSystem.addEventListener("change", schemeChanged);
  const print = (on) => () => {
    scheme.printing = on;
    // settings belong to what is filed; the table of all models does not
    for (const part of document.querySelectorAll("#input details")) part.open ||= on;
    schemeChanged();
  };
  addEventListener("beforeprint", print(true));
  addEventListener("afterprint", print(false));
  name();
  host.append(button);
}
