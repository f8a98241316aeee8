// Follows a run until it ends, then loads the page that says how.
const section = document.getElementById("run");
const stage = document.getElementById("stage");
const bar = document.getElementById("progress");
const table = document.querySelector("#blocks tbody");
const NUMBERS = new Set([2, 3, 5, 6]); // columns of a batch

const element = (name, text, kind = "") => Object.assign(document.createElement(name), { textContent: text, className: kind });
const head = ({ cells: [name], link }) => {
  const cell = element("th", link ? "" : name);
  cell.scope = "row";
  if (link) cell.append(Object.assign(element("a", name), { href: link }));
  return cell;
};
const rowsOf = (row) => {
  const line = document.createElement("tr");
  line.append(head(row), ...row.cells.slice(1).map((text, k) => element("td", text, NUMBERS.has(k + 1) ? "n" : "")));
  if (!row.said) return [line];
  const message = element("tr", "", "message"), cell = document.createElement("td");
  cell.colSpan = 7;
  cell.append(element("span", row.said));
  message.append(cell);
  return [line, message];
};
const follow = async () => {
  const answer = await fetch(`/run/${section.dataset.run}/state`);
  if (!answer.ok) throw new Error(answer.statusText);
  const run = await answer.json();
  if (stage.textContent !== run.stage) stage.textContent = run.stage;
  bar.value = run.fraction;
  if (table) {
    table.replaceChildren(...run.rows.flatMap(rowsOf));
    fitRows(table.parentElement);
  }
  if (run.state === "running") setTimeout(followed, 300);
  else location.replace(location.pathname);
};
const followed = () => follow().catch(() => {
  stage.textContent = section.dataset.silent;
});
followed();
