// The mathematics of a lesson page: the same as twistcore's rotation.py, decomposition/ and motion.py,
// for one frame. Quaternions are Hamilton, scalar first [w, x, y, z]; angles are radians.
// A plain script, so that a test can evaluate it without a browser and compare the numbers.
var SwingTwist = (function () {
  "use strict";

  const NO_TURN = 1e-9; // a shorter vector has no direction
  const UNDEFINED = 1e-6; // at a lower reliability, an angle is only rounding
  const NONE = [0, 0, 0];

  // -- vectors ----------------------------------------------------------------------------------

  const dot = (u, v) => u.reduce((sum, x, k) => sum + x * v[k], 0);
  const length = (v) => Math.sqrt(dot(v, v));
  const scaled = (v, by) => v.map((x) => by * x);
  const plus = (u, v) => u.map((x, k) => x + v[k]);
  const minus = (u, v) => u.map((x, k) => x - v[k]);
  const cross = (u, v) => [
    u[1] * v[2] - u[2] * v[1],
    u[2] * v[0] - u[0] * v[2],
    u[0] * v[1] - u[1] * v[0],
  ];
  const unit = (v) => scaled(v, 1 / length(v));
  const hasDirection = (v) => length(v) > NO_TURN;
  const direction = (v) => (hasDirection(v) ? unit(v) : NONE.slice());
  const angleBetween = (u, v) => Math.atan2(length(cross(u, v)), dot(u, v));

  function perpendicular(axis) {
    // Returns a unit vector perpendicular to another, always the same one.
    const sizes = axis.map(Math.abs);
    const least = sizes.indexOf(Math.min(sizes[0], sizes[1], sizes[2]));
    return unit(cross(axis, [0, 1, 2].map((k) => (k === least ? 1 : 0))));
  }

  // -- quaternions ------------------------------------------------------------------------------

  const wrap = (angle) => angle - 2 * Math.PI * Math.ceil((angle - Math.PI) / (2 * Math.PI));
  const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];
  const vectorOf = (q) => [q[1], q[2], q[3]];

  function multiply(p, q) {
    return [
      p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
      p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
      p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
      p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ];
  }

  function rotate(q, v) {
    const u = vectorOf(q), t = scaled(cross(u, v), 2);
    return plus(plus(v, scaled(t, q[0])), cross(u, t));
  }

  function turnAbout(axis, angle) {
    const s = Math.sin(angle / 2);
    return [Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
  }

  // θ = wrap(2·atan2(v·a, w)), Eq. 8
  const twistAngle = (q, axis) => wrap(2 * Math.atan2(dot(vectorOf(q), axis), q[0]));
  const reliability = (q, axis) => Math.hypot(q[0], dot(vectorOf(q), axis));

  function swingTwist(q, axis) {
    const twist = turnAbout(axis, twistAngle(q, axis));
    return { swing: multiply(q, conjugate(twist)), twist: twist };
  }

  // -- an edited frame ----------------------------------------------------------------------------
  // what if: { twist, counter, toward, swing, bend, nudge, applied }; null: as captured.

  const AS_CAPTURED = {
    twist: 0, counter: false, toward: null, swing: null, bend: null, nudge: 0, applied: 0,
  };

  function changes(whatIf) {
    return ["twist", "toward", "swing", "bend", "nudge", "applied"]
      .some((name) => whatIf[name] !== AS_CAPTURED[name]);
  }

  function swingTurn(swing) {
    // The unit normal of a swing (zeros if undefined) and its angle in [0, π].
    const v = scaled(vectorOf(swing), swing[0] >= 0 ? 1 : -1);
    return { normal: direction(v), angle: 2 * Math.atan2(length(v), Math.abs(swing[0])) };
  }

  const tip = (from, normal, angle) => turnAbout(cross(from, normal), angle);

  function swung(q, axis, whatIf) {
    const parts = swingTwist(q, axis), turn = swingTurn(parts.swing);
    let normal = turn.normal, angle = turn.angle;
    if (whatIf.toward !== null) {
      const w = unit(whatIf.toward), across = cross(axis, w);
      angle = angleBetween(axis, w);
      if (hasDirection(across)) normal = direction(across);
    }
    if (!hasDirection(normal)) normal = perpendicular(axis);
    if (whatIf.swing !== null) angle = whatIf.swing;
    if (whatIf.swing !== null || whatIf.toward !== null) {
      q = multiply(turnAbout(normal, angle), parts.twist);
    }
    return unit(multiply(tip(rotate(q, axis), normal, whatIf.nudge), q));
  }

  function bent(q, axis, arm, whatIf) {
    const v = rotate(q, arm);
    let normal = direction(cross(axis, v));
    if (!hasDirection(normal)) normal = perpendicular(axis);
    if (whatIf.bend !== null) {
      q = multiply(turnAbout(normal, whatIf.bend - angleBetween(axis, v)), q);
    }
    return unit(multiply(tip(rotate(q, arm), normal, whatIf.nudge), q));
  }

  function staged(q, axis, stage) {
    // A stage of the rotation: share of the swing (0…1), then of the twist (1…2).
    const within = (x) => Math.min(Math.max(x, 0), 1);
    const parts = swingTwist(q, axis), turn = swingTurn(parts.swing);
    const part = turnAbout(turn.normal, within(stage) * turn.angle);
    const rolled = within(stage - 1) * twistAngle(parts.twist, axis);
    return unit(multiply(part, turnAbout(axis, rolled)));
  }

  // rotations: local, one per joint; chain: { parent, child, children, axis, arm, free } at the
  // frame; offset: the angle to remove in part; stage: null, or a stage of P's rotation.
  function altered(rotations, chain, whatIf, offset, stage) {
    const out = rotations.slice(), p = chain.parent, c = chain.child;
    out[p] = swung(out[p], chain.axis, whatIf);
    out[c] = bent(out[c], chain.axis, chain.arm, whatIf);
    if (!whatIf.counter) out[p] = unit(multiply(out[p], turnAbout(chain.axis, whatIf.twist)));
    const back = whatIf.applied * offset - (whatIf.counter ? whatIf.twist : 0);
    if (back !== 0 && chain.free) {
      out[p] = unit(multiply(out[p], turnAbout(chain.axis, -back))); // Eq. 14
      const ahead = turnAbout(chain.axis, back);
      chain.children.forEach((x) => { out[x] = unit(multiply(ahead, out[x])); }); // Eq. 15
    }
    if (stage !== null) out[p] = staged(out[p], chain.axis, stage);
    return out;
  }

  // -- quantities of a frame --------------------------------------------------------------------

  // Eq. 1-13; q, qChild: P's and C's rotation, at the frame and at the one before it.
  function decompose(now, before) {
    const a = now.axis, parts = swingTwist(now.q, a);
    const sign = parts.swing[0] < 0 ? -1 : 1; // q and −q are one rotation; cos(α/2) ≥ 0 in Eq. 6
    const q = scaled(now.q, sign), swing = scaled(parts.swing, sign), w = rotate(q, a);
    const v = rotate(now.qChild, now.arm), vBefore = rotate(before.qChild, before.arm);
    const across = minus(v, scaled(a, dot(v, a)));
    const acrossBefore = minus(vBefore, scaled(before.axis, dot(vBefore, before.axis)));
    const thetaP = twistAngle(q, a), thetaBefore = twistAngle(before.q, before.axis);
    const dThetaP = wrap(thetaP - thetaBefore);
    const dThetaC = Math.atan2(dot(cross(acrossBefore, across), a), dot(acrossBefore, across));
    const opposed = dThetaP * dThetaC < 0;
    const sure = reliability(q, a), sureBefore = reliability(before.q, before.axis);
    const swingIsOne = sure > UNDEFINED, twisted = swingIsOne && sureBefore > UNDEFINED;
    const turned = Math.min(length(across), length(acrossBefore)) > UNDEFINED;
    return {
      a: a, q: q, w: w, n: direction(vectorOf(swing)), alpha: angleBetween(a, w),
      swing: swing, twist: parts.twist, theta_p: thetaP, theta_p_before: thetaBefore,
      dtheta_p: dThetaP, swing_reliability: sure, swing_reliability_before: sureBefore,
      v: v, v_before: vBefore, v_ideal: rotate(turnAbout(a, -dThetaC), v),
      across: across, across_before: acrossBefore, bend: angleBetween(a, v),
      dtheta_c: dThetaC, azimuth_reliability: length(across),
      product: dThetaP * dThetaC,
      swing_is_one: swingIsOne, n_is_defined: swingIsOne && hasDirection(vectorOf(swing)),
      dtheta_p_is_defined: twisted, dtheta_c_is_defined: turned,
      strength_is_defined: twisted && turned,
      strength: opposed ? Math.min(Math.abs(dThetaP), Math.abs(dThetaC)) : 0,
    };
  }

  // err(t) = sign(Δθp)·m where m ≥ τ, else 0 (§3.3.1)
  const errorOf = (dThetaP, strength, tau) => (strength >= tau ? Math.sign(dThetaP) * strength : 0);

  // A frame of a clip: now, before: { rotations, chain } of it and of the one before, as captured.
  function quantities(now, before, rotations) {
    const seen = (all, chain) => (
      { q: all[chain.parent], qChild: all[chain.child], axis: chain.axis, arm: chain.arm });
    return decompose(seen(rotations, now.chain), seen(before.rotations, before.chain));
  }

  // The detected values before the correction, and the correction: Eq. 14-15.
  function correctFrame(now, before, whatIf, tau, offsetBefore) {
    const joints = [now.chain.parent, now.chain.child];
    const untouched = Object.assign({}, whatIf, { applied: 0 });
    const first = altered(now.rotations, now.chain, untouched, 0, null);
    const d = quantities(now, before, first);
    const err = errorOf(d.dtheta_p, d.strength_is_defined ? d.strength : 0, tau);
    const whole = wrap(offsetBefore + err);
    const last = whatIf.applied ? altered(now.rotations, now.chain, whatIf, whole, null) : first;
    const sign = dot(d.q, first[joints[0]]) >= 0 ? 1 : -1; // cos(α/2) ≥ 0 in Eq. 6
    const was = multiply(first[joints[0]], first[joints[1]]);
    const is = multiply(last[joints[0]], last[joints[1]]), turn = multiply(conjugate(was), is);
    return {
      before: d, tau: tau, err: err, offset_before: offsetBefore, whole: whole,
      offset: offsetBefore + err, applied: whatIf.applied, taken: whatIf.applied * whole,
      parent_after: scaled(last[joints[0]], sign), child_after: last[joints[1]],
      difference: 2 * Math.atan2(length(vectorOf(turn)), Math.abs(turn[0])),
    };
  }

  // The displayed pose and its correction.
  function numbersOf(now, before, whatIf, stage, tau, offsetBefore) {
    const correction = correctFrame(now, before, whatIf, tau, offsetBefore);
    const rotations = altered(now.rotations, now.chain, whatIf, correction.whole, stage);
    const frame = quantities(now, before, rotations);
    return { frame: frame, correction: correction, staged: stage !== null, rotations: rotations };
  }

  // Global rotations and places of all joints; parents come before their children.
  function forwardKinematics(parents, rotations, translations) {
    const turned = [], places = [];
    parents.forEach((parent, j) => {
      const above = parent >= 0;
      turned[j] = above ? multiply(turned[parent], rotations[j]) : rotations[j];
      places[j] = above
        ? plus(places[parent], rotate(turned[parent], translations[j])) : translations[j];
    });
    return { rotations: turned, positions: places };
  }

  return {
    AS_CAPTURED: AS_CAPTURED, dot: dot, cross: cross, length: length, unit: unit, plus: plus,
    minus: minus, scaled: scaled, perpendicular: perpendicular, direction: direction, wrap: wrap,
    multiply: multiply, conjugate: conjugate, rotate: rotate, turnAbout: turnAbout,
    twistAngle: twistAngle, swingTwist: swingTwist, changes: changes, altered: altered,
    decompose: decompose, numbersOf: numbersOf, UNDEFINED: UNDEFINED, forwardKinematics: forwardKinematics,
  };
})();
