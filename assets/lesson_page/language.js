// Texts in the page's language: English as the scripts have it, else what the program put in.
// A plain script, as swing_twist.js is.
var Language = (function () {
  "use strict";

  let known = {}; // text → the same in the page's language

  function use(words) {
    known = words;
  }

  function tr(text, values) { // values go in by name
    const found = known[text] || text;
    return values ? found.replace(/\{(\w+)\}/g, (_, name) => values[name]) : found;
  }

  const tr_as = (meaning, text) => tr(text); // in a page no text has two

  return { use: use, tr: tr, tr_as: tr_as };
})();
