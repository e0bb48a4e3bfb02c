// One or two sentences that describe a frame, the same as inspector/teaching/what_if_words.py.
// A plain script like swing_twist.js.
var Words = (function () {
  "use strict";

  const { plain, signed, inDegrees, reliable, NEAR_SWING, NEAR_STRAIGHT, LEAST } = Labels;
  const { tr } = Language;
  const { UNDEFINED } = SwingTwist;
  const TIP = 1 / inDegrees(1); // the nudge whose effect is described
  const HALF_TURN = 120 / inDegrees(1); // beyond it, wrapping may flip a sign

  const share = (x) => `${plain(100 * x, 0)} %`;
  const whole = (angle) => `${plain(inDegrees(angle), 0)}°`;
  const tenths = (angle) => `${plain(inDegrees(angle), 1)}°`;
  const state = (sure) => (sure <= UNDEFINED ? tr("undefined") : reliable(sure));

  // True if a what-if sets only the named parts.
  function only(whatIf, ...names) {
    return ["twist", "toward", "swing", "bend", "nudge", "applied"]
      .every((name) => names.includes(name) || whatIf[name] === SwingTwist.AS_CAPTURED[name]);
  }

  function onItsWay(d, stage) {
    if (stage <= 1) {
      return tr("{share} of the swing, α = {alpha}. The swing takes a to w.", {
        share: share(stage), alpha: whole(d.alpha),
      });
    }
    return tr("The swing and {share} of the twist, θp = {theta}. The twist rolls the bone about "
      + "its own axis: w, n and α do not change.", {
      share: share(stage - 1), theta: tenths(d.theta_p),
    });
  }

  function singular(d) { // a warning about undefined or unreliable angles
    const turned = d.swing_reliability < NEAR_SWING;
    const straight = d.azimuth_reliability < NEAR_STRAIGHT;
    const shape = d.bend < Math.PI / 2 ? tr("straight") : tr("folded flat");
    if (turned && straight) {
      return tr("Both angles are singular: θp is {theta}, Δθc is {azimuth}. A nudge of 1° turns n "
        + "and v⊥ by 5° or more.", {
        theta: state(d.swing_reliability), azimuth: state(d.azimuth_reliability),
      });
    }
    if (!d.swing_is_one) {
      return tr("θp is undefined because w points opposite to a. Many pairs (n, θp) give this pose. "
        + "A nudge makes θp unique.");
    }
    if (turned) {
      const tipped = whole(2 * Math.atan2(TIP, Math.PI - d.alpha));
      return tr("θp is nearly singular: w points almost opposite to a ({reliable}). Tipping w "
        + "sideways by 1° would change θp by {angle}.", {
        reliable: reliable(d.swing_reliability), angle: tipped,
      });
    }
    if (d.azimuth_reliability <= UNDEFINED) {
      return tr("Δθc and m are undefined: the limb is {shape}, so v⊥ has no direction. A nudge gives it "
        + "one.", { shape: shape });
    }
    if (straight) {
      const tipped = whole(Math.atan2(TIP, Math.asin(Math.min(d.azimuth_reliability, 1))));
      return tr("Δθc is nearly singular: the limb is nearly {shape} ({reliable}). Tipping v sideways by "
        + "1° would turn v⊥ by {angle}.", {
        shape: shape, reliable: reliable(d.azimuth_reliability), angle: tipped,
      });
    }
    if (!d.dtheta_p_is_defined) {
      return tr("θp was undefined in the previous frame, so Δθp, the product and m are undefined "
        + "here.");
    }
    if (!d.dtheta_c_is_defined) {
      return tr("The limb was straight in the previous frame, so Δθc, the product and m are "
        + "undefined here.");
    }
    return "";
  }

  function applied(of) {
    const c = of.correction;
    return tr("{share} of offset(t) = {whole} is removed: m was {before}, now {now}. C "
      + "counter-rotates by the same angle (Eq. 15) and keeps its orientation (Eq. 14).", {
      share: share(c.applied), whole: tenths(c.whole),
      before: tenths(c.before.strength), now: tenths(of.frame.strength),
    });
  }

  function event(of, whatIf) {
    const d = of.frame, c = of.correction, passed = `m = ${tenths(d.strength)} ≥ τ = ${tenths(c.tau)}`;
    if (whatIf.counter && whatIf.twist && only(whatIf, "twist")) {
      return tr("P and C twist against each other, {passed}: a twist error. Only P has turned; C "
        + "and G are as captured.", { passed: passed });
    }
    return tr("Opposite signs and {passed}: an event. err = {err} is added to offset(t). Such "
      + "an event is the edge of an error or a very fast movement.", {
      passed: passed, err: `${signed(inDegrees(c.err), 1)}°`,
    });
  }

  function noEvent(of, whatIf) {
    const d = of.frame, tau = tenths(of.correction.tau);
    const small = `m = ${plain(inDegrees(d.strength), 2)}° < τ = ${tau}`;
    if (whatIf.counter && Math.min(Math.abs(d.dtheta_p), Math.abs(d.dtheta_c)) > HALF_TURN) {
      return tr("C counter-rotates by the same angle, but wrapping at ±180° gives Δθp and Δθc the same "
        + "sign. The paper’s test misses this error.");
    }
    if (!whatIf.counter && whatIf.twist && only(whatIf, "twist")) {
      if (d.strength >= LEAST) {
        return tr("A pure twist: w, n, α and Δθc do not change. Δθp·Δθc < 0 comes from a small "
          + "motion of the child itself ({small}), so a threshold τ is needed.", { small: small });
      }
      return tr("A pure twist: θp changes; w, n and α do not. The child turns with the parent, so "
        + "Δθc does not change either. This is a real movement, not an error.");
    }
    if (d.strength >= LEAST) {
      return tr("Opposite signs, but {small}: no event. Natural motion often has small opposite "
        + "changes. This is why there is a threshold τ.", { small: small });
    }
    if (!SwingTwist.changes(whatIf)) {
      return tr("The frame as captured. Move a slider to alter it. The review does not change.");
    }
    if (only(whatIf, "swing", "toward")) {
      return tr("A different swing with the same twist: w and q_swing change; θp, v and Δθc do "
        + "not.");
    }
    if (only(whatIf, "bend")) {
      return tr("The child is bent differently: v changes; the direction of v⊥, P and Δθc do "
        + "not.");
    }
    return tr("This change is not an event: {small}.", { small: small });
  }

  // of: the result of SwingTwist.numbersOf; role: of the theme's colour.
  function say(of, whatIf, stage) {
    const d = of.frame, tau = of.correction.tau;
    if (stage !== null) return { text: onItsWay(d, stage), role: "soft" };
    const text = singular(d);
    if (text) return { text: text, role: "warning" };
    if (whatIf.applied) return { text: applied(of), role: "soft" };
    if (d.strength_is_defined && d.strength >= tau && tau > 0) {
      return { text: event(of, whatIf), role: "tau" };
    }
    return { text: noEvent(of, whatIf), role: "soft" };
  }

  return { say: say };
})();
