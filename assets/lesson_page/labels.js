// Numbers and rows of equations as text, the same as in the program's teaching tab.
// A plain script like swing_twist.js.
var Labels = (function () {
  "use strict";

  const { tr } = Language;
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
  const numbers = (values) => "(" + values.map((x) => signed(x, 3).padStart(6, "\u00a0")).join(", ") + ")";

  // -- rows of the equations ----------------------------------------------------------------------
  // of: the result of SwingTwist.numbersOf.

  const NEAR_SWING = 0.1; // reliability of θp below which a warning is shown
  const NEAR_STRAIGHT = 0.17; // of the azimuth
  const LEAST = 0.005 / inDegrees(1); // a larger m is more than rounding in the file
  const NOT_YET = "–";
  const STAGED = ["a", "q", "w", "n", "alpha", "swing", "twist", "theta_p"];
  const nothing = () => tr("undefined");
  const reliable = (share) => tr("{percent} % reliable", {
    percent: share < 0.01 ? tr("under 1") : (100 * share).toFixed(0),
  });
  const unsure = (share, near) => (share < near ? ` (${reliable(share)})` : "");
  const ofOneSwing = (tell) => (of) => (of.frame.swing_is_one ? tell(of.frame) : nothing());

  function opposed(of) { // the answer to "below zero?", with the number
    if (!of.frame.strength_is_defined) return nothing();
    const product = inDegrees(inDegrees(of.frame.product)), wide = Math.abs(product);
    const number = wide.toFixed(wide >= 0.01 ? 2 : 4);
    const sign = product < 0 ? MINUS : product > 0 ? "+" : "";
    const no = sign === MINUS ? tr("no, only rounding error") : tr("no");
    const answer = of.frame.strength >= LEAST ? tr("yes") : no;
    return `${answer}: ${sign}${number} (°)²`;
  }

  function strength(of) { // m compared with τ
    if (!of.frame.strength_is_defined) return nothing();
    const m = of.frame.strength, tau = of.correction.tau;
    return `${size(m)} ${m >= tau ? "≥" : "<"} τ ${plain(inDegrees(tau), 1)}°`;
  }

  function offset(of) {
    const c = of.correction;
    return `${degrees(c.offset_before)} ${c.err < 0 ? MINUS : "+"} ${size(Math.abs(c.err))}`;
  }

  function taken(of) {
    const c = of.correction;
    return tr("{share} % of {whole}: {taken}", {
      share: plain(100 * c.applied, 0), whole: degrees(c.whole), taken: degrees(c.taken),
    });
  }

  const ROWS = {
    a: (of) => numbers(of.frame.a),
    q: (of) => numbers(of.frame.q),
    w: (of) => numbers(of.frame.w),
    n: (of) => (of.frame.n_is_defined ? numbers(of.frame.n) : nothing()),
    alpha: (of) => size(of.frame.alpha),
    swing: ofOneSwing((d) => numbers(d.swing)),
    twist: ofOneSwing((d) => numbers(d.twist)),
    theta_p: ofOneSwing((d) => degrees(d.theta_p) + unsure(d.swing_reliability, NEAR_SWING)),
    dtheta_p: (of) => (of.frame.dtheta_p_is_defined
      ? degrees(of.frame.dtheta_p) + unsure(of.frame.swing_reliability, NEAR_SWING) : nothing()),
    v: (of) => numbers(of.frame.v),
    across: (of) => numbers(of.frame.across)
      + (of.frame.azimuth_reliability <= SwingTwist.UNDEFINED ? tr(", no\u00a0direction") : ""),
    dtheta_c: (of) => (of.frame.dtheta_c_is_defined
      ? degrees(of.frame.dtheta_c) + unsure(of.frame.azimuth_reliability, NEAR_STRAIGHT)
      : nothing()),
    product: opposed,
    m: strength,
    err: (of) => (of.correction.before.strength_is_defined ? degrees(of.correction.err) : nothing()),
    offset: offset,
    taken: taken,
    parent_after: (of) => numbers(of.correction.parent_after),
    child_after: (of) => numbers(of.correction.child_after),
    check: (of) => tr("{angle}° apart", {
      angle: plain(inDegrees(of.correction.difference), 3),
    }),
  };

  const row = (symbol, of) =>
    (of.staged && !STAGED.includes(symbol) ? NOT_YET : ROWS[symbol](of));

  return {
    plain: plain, signed: signed, degrees: degrees, inDegrees: inDegrees, reliable: reliable,
    row: row, NAMES: Object.keys(ROWS), NEAR_SWING: NEAR_SWING, NEAR_STRAIGHT: NEAR_STRAIGHT,
    LEAST: LEAST,
  };
})();
