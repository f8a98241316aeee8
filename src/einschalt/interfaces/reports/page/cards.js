// Tables wider than their place: each row becomes a card, each cell with its heading.

const FITTING = 19; // letters of a cell beside those of its heading's longest word, in half a card

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
  const longest = titles.map((title) => Math.max(...title.split(" ").map((word) => word.length)));
  for (const row of table.tBodies[0].rows) {
    if (row.cells.length < titles.length) continue; // a message over all columns
    [...row.cells].forEach((cell, c) => {
      if (titles[c]) cell.dataset.title = titles[c];
      cell.classList.toggle("long", cell.textContent.length + longest[c] > FITTING);
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
