// How the page writes numbers, and what stands in every row: as the program's teaching tab does.
// A plain script, as swing_twist.js is.
var Labels = (function () {
  "use strict";

  const MINUS = "\u2212"; // as long as a plus sign
  const inDegrees = (radians) => (180 / Math.PI) * radians;

  function plain(value, digits) {
    const text = value.toFixed(digits);
    const zero = Number(text) === 0;
    return (zero ? text.replace("-", "") : text.replace("-", MINUS));
  }

  function signed(value, digits) {
    const text = plain(value, digits);
    return text[0] !== MINUS && Number(text) !== 0 ? "+" + text : text;
  }

  const degrees = (angle) => signed(inDegrees(angle), 2) + "°";
  const size = (angle) => plain(inDegrees(angle), 2) + "°";
  const numbers = (values) => "(" + values.map((x) => signed(x, 3)).join(", ") + ")";

  // Symbol: its text, from the frame's quantities.
  const ROWS = {
    a: (d) => numbers(d.a),
    q: (d) => numbers(d.q),
    w: (d) => numbers(d.w),
    n: (d) => (d.n.some((x) => x !== 0) ? numbers(d.n) : "undefined"),
    alpha: (d) => size(d.alpha),
    swing: (d) => numbers(d.swing),
    twist: (d) => numbers(d.twist),
    theta_p: (d) => degrees(d.theta_p),
    dtheta_p: (d) => degrees(d.dtheta_p),
    v: (d) => numbers(d.v),
    across: (d) => numbers(d.across),
    dtheta_c: (d) => degrees(d.dtheta_c),
    product: (d) => signed(inDegrees(inDegrees(d.product)), 2) + " (°)²",
    m: (d) => size(d.strength),
  };

  return { plain: plain, signed: signed, degrees: degrees, inDegrees: inDegrees, ROWS: ROWS };
})();
