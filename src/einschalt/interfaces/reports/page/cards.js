// Tables wider than their place: each row becomes a card, each cell with its heading.

const LONG = { figure: 9, text: 14 }; // signs of a cell that takes a line of its own

/** Whether a table is shown as cards is decided anew where its place gets another width. */
function fitTable(table) {
  const place = table.parentElement;
  if (!place.clientWidth) return; // folded
  table.classList.remove("cards");
  if (table.offsetWidth <= place.clientWidth) return;
  table.classList.add("cards");
  nameCells(table);
}

/** Headings before the cells, since those of the columns are not above them any more. */
function nameCells(table) {
  const titles = [...table.tHead.rows[0].cells].map((head) => head.textContent);
  for (const row of table.tBodies[0].rows) {
    [...row.cells].forEach((cell, c) => {
      if (titles[c]) cell.dataset.title = titles[c];
      cell.classList.toggle("long", cell.textContent.length > LONG[cell.classList.contains("n") ? "figure" : "text"]);
    });
  }
}

/** The same for new rows: cards stay cards, so that turning the page changes no layout. */
function fitRows(table) {
  if (table.classList.contains("cards")) nameCells(table);
  else fitTable(table);
}

function watchTable(table) {
  let width = -1;
  new ResizeObserver(([{ contentRect }]) => requestAnimationFrame(() => {
    if (contentRect.width === width) return;
    width = contentRect.width;
    fitTable(table);
  })).observe(table.parentElement);
}
