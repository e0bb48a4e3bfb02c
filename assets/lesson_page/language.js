// Texts in the page's language: translations from the program, or the English of the scripts.
// A plain script like swing_twist.js.
var Language = (function () {
  "use strict";

  let known = {}; // text → its translation

  function use(words) {
    known = words;
  }

  function tr(text, values) { // values are inserted by name
    const found = known[text] || text;
    return values ? found.replace(/\{(\w+)\}/g, (_, name) => values[name]) : found;
  }

  const tr_as = (meaning, text) => tr(text); // no text of the page has two translations

  return { use: use, tr: tr, tr_as: tr_as };
})();
