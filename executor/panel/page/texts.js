// The texts of the page, in the languages of the files `text-*.js`.

import de from "./text-de.js";
import en from "./text-en.js";
import pt from "./text-pt.js";

export const LANGUAGES = { en, de, pt };

/** The texts of the browser's language. */
export function texts() {
  const chosen = localStorage.getItem("language") ?? navigator.language.slice(0, 2);
  return LANGUAGES[chosen] ?? en;
}

/** A text with its blanks filled in: {tool} by `values.tool`. @param {string} text @param {object} values */
export const filled = (text, values) => text.replace(/\{(\w+)\}/g, (_, name) => values[name]);
