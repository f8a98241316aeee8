// Tables wider than their place become cards, as in the report (cards.js).
for (const table of document.querySelectorAll(".scroll > table")) watchTable(table);
