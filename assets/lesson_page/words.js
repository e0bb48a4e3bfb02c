// A sentence or two on what is to be seen in a frame, as inspector/teaching/what_if_words.py says
// them. A plain script, as swing_twist.js is.
var Words = (function () {
  "use strict";

  const { plain, signed, inDegrees, reliable, NEAR_SWING, NEAR_STRAIGHT, LEAST } = Labels;
  const { tr } = Language;
  const { UNDEFINED } = SwingTwist;
  const TIP = 1 / inDegrees(1); // the nudge whose effect is told
  const HALF_TURN = 120 / inDegrees(1); // beyond it wrapping may turn a sign over

  const share = (x) => `${plain(100 * x, 0)} %`;
  const whole = (angle) => `${plain(inDegrees(angle), 0)}°`;
  const tenths = (angle) => `${plain(inDegrees(angle), 1)}°`;
  const state = (sure) => (sure <= UNDEFINED ? tr("undefined") : reliable(sure));

  // Which parts of a what-if are set, of those that the sentence depends on.
  function only(whatIf, ...names) {
    return ["twist", "toward", "swing", "bend", "nudge", "applied"]
      .every((name) => names.includes(name) || whatIf[name] === SwingTwist.AS_CAPTURED[name]);
  }

  function onItsWay(d, stage) {
    if (stage <= 1) {
      return tr("First the swing: {share} of it, α = {alpha}. It takes a to w.", {
        share: share(stage), alpha: whole(d.alpha),
      });
    }
    return tr("Then the twist: {share} of it, θp = {theta}. It rolls the "
      + "bone about itself: w, n and α stay.", {
      share: share(stage - 1), theta: tenths(d.theta_p),
    });
  }

  function singular(d) { // on the angles that are undefined, or nearly so
    const turned = d.swing_reliability < NEAR_SWING;
    const straight = d.azimuth_reliability < NEAR_STRAIGHT;
    const lies = d.bend < Math.PI / 2 ? tr("is straight") : tr("is folded flat");
    if (turned && straight) {
      return tr("Both singularities: θp is {theta}, Δθc {azimuth}. A nudge of 1° turns n and "
        + "v⊥ by 5° or more.", {
        theta: state(d.swing_reliability), azimuth: state(d.azimuth_reliability),
      });
    }
    if (!d.swing_is_one) {
      return tr("Singularity of θp: w points against a, θp is undefined. One pose has many (n, θp), "
        + "none better than another. Nudge, and there is one.");
    }
    if (turned) {
      const tipped = whole(2 * Math.atan2(TIP, Math.PI - d.alpha));
      return tr("Singularity of θp near: w points almost against a ({reliable}). Tipped sideways "
        + "by 1°, θp would change by {angle}.", {
        reliable: reliable(d.swing_reliability), angle: tipped,
      });
    }
    if (d.azimuth_reliability <= UNDEFINED) {
      return tr("Singularity of θc: the limb {lies}, v⊥ has no direction, Δθc is undefined, and so "
        + "is m. Nudge, and there is one.", { lies: lies });
    }
    if (straight) {
      const tipped = whole(Math.atan2(TIP, Math.asin(Math.min(d.azimuth_reliability, 1))));
      return tr("Singularity of θc near: the limb almost {lies} ({reliable}). Tipped sideways by "
        + "1°, v⊥ would turn by {angle}.", {
        lies: lies, reliable: reliable(d.azimuth_reliability), angle: tipped,
      });
    }
    if (!d.dtheta_p_is_defined) {
      return tr("θp was undefined in the frame before, so Δθp, the product and m are undefined "
        + "here.");
    }
    if (!d.dtheta_c_is_defined) {
      return tr("The limb was straight in the frame before, so Δθc, the product and m are "
        + "undefined.");
    }
    return "";
  }

  function applied(of) {
    const c = of.correction;
    return tr("{share} of offset(t) = {whole} is off P’s twist: m was {before}, is {now}. C turns "
      + "back as far (15) and stands as it stood (14).", {
      share: share(c.applied), whole: tenths(c.whole),
      before: tenths(c.before.strength), now: tenths(of.frame.strength),
    });
  }

  function event(of, whatIf) {
    const d = of.frame, c = of.correction, passed = `m = ${tenths(d.strength)} ≥ τ = ${tenths(c.tau)}`;
    if (whatIf.counter && whatIf.twist && only(whatIf, "twist")) {
      return tr("P and C twist against each other, {passed}. Only P has turned; C and G stand as "
        + "captured: a twist error.", { passed: passed });
    }
    return tr("Opposed, {passed}: an event, and err = {err} goes into "
      + "offset(t). An edge of an error, or motion as lively as one.", {
      passed: passed, err: `${signed(inDegrees(c.err), 1)}°`,
    });
  }

  function noEvent(of, whatIf) {
    const d = of.frame, tau = tenths(of.correction.tau);
    const small = `m = ${plain(inDegrees(d.strength), 2)}° < τ = ${tau}`;
    if (whatIf.counter && Math.min(Math.abs(d.dtheta_p), Math.abs(d.dtheta_c)) > HALF_TURN) {
      return tr("C turns back as far, yet Δθp and Δθc have one sign: near ±180° wrapping turns one "
        + "over. The paper’s test is blind to this error.");
    }
    if (!whatIf.counter && whatIf.twist && only(whatIf, "twist")) {
      if (d.strength >= LEAST) {
        return tr("A pure twist: w, n, α and Δθc stay. Δθp·Δθc < 0 by the child’s own small motion "
          + "({small}): that is why there is a τ.", { small: small });
      }
      return tr("A pure twist: θp changes; w, n and α stay. The child goes along, so Δθc stays too: "
        + "a real movement, no error.");
    }
    if (d.strength >= LEAST) {
      return tr("Opposed, but {small}: no event. Natural motion often makes small opposed changes; "
        + "that is why there is a τ.", { small: small });
    }
    if (!SwingTwist.changes(whatIf)) {
      return tr("The frame as captured. Move a slider: what if …? Nothing of it reaches the "
        + "review.");
    }
    if (only(whatIf, "swing", "toward")) {
      return tr("Another swing with the same twist: w and q_swing change; θp, v and Δθc stay.");
    }
    if (only(whatIf, "bend")) {
      return tr("Another bend of the child: v changes, v⊥ keeps its direction; P and Δθc stay.");
    }
    return tr("No event: {small}.", { small: small });
  }

  // of: what SwingTwist.numbersOf tells; the role is that of the theme's colour.
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
