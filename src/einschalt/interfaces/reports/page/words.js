// Messages and figures in the language of the page: English unless its data say otherwise.

const words = { language: "en", decimal: ".", messages: {} };

function setLanguage(head) {
  Object.assign(words, { language: head.language, messages: head.words });
  words.decimal = (1.5).toLocaleString(head.language)[1];
}

/** A message with its places filled; {n:point|points} is a number with the form that it asks for. */
function translated(message, values = {}) {
  return (words.messages[message] ?? message).replace(/\{(\w+)(?::([^|}]*)\|([^}]*))?\}/g, (_, name, one, many) => {
    const value = values[name];
    return one === undefined ? `${value}` : `${count(value)} ${value === 1 ? one : many}`;
  });
}

/** A figure with the decimal sign of the language. */
const localized = (text) => (words.decimal === "." ? text : text.replace(".", words.decimal));

/** The same with a decimal point, as numbers are read. */
const plainFigure = (text) => text.replaceAll("\u202f", "").replace(words.decimal, ".").replaceAll("−", "-");

/** A figure as users type it: comma and point are decimal signs in every language. */
const typedFigure = (text) => Number(text.replace(",", ".").replace("−", "-"));

/** Roles and flights are data; the page shows them in its language. */
const roleText = (role) => ({ new: translated("new"), control: translated("control"), check: translated("check") })[role] ?? role;

const flightText = (flight) => ({ high: translated("high"), low: translated("low") })[flight] ?? flight;

const flightTitle = (flight) => ({ high: translated("high flight"), low: translated("low flight") })[flight] ?? `${flight} flight`;

/** The stated standard error, as the head of a column. */
const claimText = (claim) => ({
  standard_error_total: translated("total"), standard_error_paper: translated("paper"), standard_error_internal: translated("internal"),
})[claim] ?? claim;
