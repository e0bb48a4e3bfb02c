// The page: its state, and the reactions to a student's input.
(function () {
  "use strict";

  const S = SwingTwist;
  const { tr, tr_as } = Language;
  const lesson = ClipData.read(JSON.parse(document.getElementById("lesson-data").textContent));
  Language.use(lesson.words);
  const one = (selector) => document.querySelector(selector);
  const all = (selector) => Array.from(document.querySelectorAll(selector));
  const radians = (degrees) => (Math.PI / 180) * degrees;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const LOOKS = ["before", "after", "both"];
  const SLIDERS = { twist: Labels.signed, swing: Labels.plain, bend: Labels.plain, nudge: Labels.signed };

  const formulas = {};
  Object.keys(lesson.marks).forEach((symbol) => {
    const { d, box } = lesson.marks[symbol];
    formulas[symbol] = { path: new Path2D(d), box };
  });

  const view = new FigureView.View(one("#scene"), lesson);
  const plot = new Curves.Plot(one("#curves canvas"), goTo);
  const state = { at: -1, frame: 0, whatIf: null, stage: null, lit: "", look: "both", met: new Set() };
  let page = null, camera = null, shown = null, waiting = false;
  const playback = Playback.onButton(one("#play"), [tr("Play"), tr_as("button", "Stop")],
    () => ({ first: page.first, last: page.last, frame: state.frame, fps: page.span.fps }),
    () => 0.25, goTo);

  document.documentElement.classList.add("live");
  one("#no-3d").hidden = view.renderer !== null;

  // -- what is shown ----------------------------------------------------------------------------

  const theme = () => (dark.matches ? "dark" : "light");

  function look() {
    const colours = lesson.themes[theme()], fontSize = parseFloat(getComputedStyle(document.body).fontSize);
    return {
      roles: colours.roles,
      paper: colours.roles.surface,
      colourOf: (symbol) => colours.families[(lesson.marks[symbol] || {}).family] || colours.roles.text,
      lit: new Set(state.lit ? lesson.together[state.lit] : []),
      formulas, fontSize, smallFont: `12px ${getComputedStyle(document.body).fontFamily}`,
    };
  }

  function compute() { // the frame, as captured and as shown
    const { span, chain } = page, frame = state.frame, before = Math.max(frame - 1, span.first);
    const captured = span.rotations(frame, null);
    const ghost = span.pose(frame, captured);
    if (!chain || !page.taught) {
      const after = page.after && state.look !== "before";
      const solid = after ? span.pose(frame, span.rotations(frame, page.after)) : ghost;
      return { of: null, d: null, solid, ghost };
    }
    const now = { rotations: captured, chain: chain.at(frame) };
    const was = { rotations: span.rotations(before, null), chain: chain.at(before) };
    const offset = frame > 0 ? chain.running[before - span.first] : 0;
    const of = S.numbersOf(now, was, state.whatIf, state.stage, chain.tau, offset);
    return { of, d: of.frame, solid: span.pose(frame, of.rotations), ghost };
  }

  const altered = () => S.changes(state.whatIf) || state.stage !== null;

  function draw() {
    waiting = false;
    shown = compute();
    const { d, solid, ghost } = shown, figure = page.span.figure, style = look();
    const differs = FigureView.differing(figure, solid, ghost);
    const shape = d ? gizmoOf(d, solid) : circleOf(solid, ghost);
    if (camera === null) camera = firstCamera(solid, shape);
    const strong = figure.bones.map((_, k) => page.strong.includes(k));
    // In a what-if, only bones that keep their position show a ghost of the captured pose; with a
    // ghost of every moved bone the figure would appear twice.
    const stays = (bone) => S.length(S.minus(
      solid.positions[bone.parent], ghost.positions[bone.parent])) < 1e-4 * figure.room.height;
    const left = figure.bones.map(
      (bone, k) => differs[k] && (d ? stays(bone) : state.look === "both"));
    view.draw(camera, { solid, ghost, strong, differs, left }, (context, project) => {
      if (shape) Gizmo.draw(context, shape, project, style);
    });
    const what = d && altered() ? d : null;
    plot.draw({
      frame: state.frame,
      theta_p: what && what.theta_p,
      theta_c: what && page.chain.theta_c[Math.max(state.frame - 1, page.span.first) - page.span.first]
        + what.dtheta_c,
      m: what && what.strength,
    }, style.lit, style);
    showNumbers(d);
    showSliders(d);
    check(d);
  }

  function redraw() { // once per screen refresh
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(draw);
  }

  function gizmoOf(d, solid) {
    const { parent, child, grandchild } = page.chain;
    const far = grandchild >= 0
      ? S.length(S.minus(solid.positions[grandchild], solid.positions[child])) : 0;
    const out = Gizmo.sketch(d, solid.rotations[parent], solid.positions[parent],
      solid.positions[child], far, 0.06 * page.span.figure.room.height, state.stage !== null);
    Gizmo.nameJoints(out, page.chain, solid.positions);
    Gizmo.drawTriads(out, page.chain, solid);
    return out;
  }

  function circleOf(solid, ghost) { // of a limb; a chain in a review has no line
    return page.limb && page.limb.end >= 0
      ? Gizmo.limbSketch(solid, ghost, page.limb, page.span.figure.room.height) : null;
  }

  function firstCamera(solid, shape) { // as the page sets it, or from where the limb is seen best
    const out = new OrbitCamera.Camera(page.span.figure.room.up, page.ahead);
    const bones = page.span.figure.bones.filter((_, k) => page.strong.includes(k));
    let points = bones.flatMap((bone) => [
      solid.positions[bone.parent],
      S.plus(solid.positions[bone.parent], S.rotate(solid.rotations[bone.parent], bone.tip)),
    ]);
    if (shape) points = shape.parts.filter((p) => p.kind !== "face").flatMap((p) => p.points);
    if (!points.length) points = solid.positions;
    const [wide, high] = view.size;
    if (page.camera) {
      out.azimuth = page.camera.azimuth;
      out.elevation = page.camera.elevation;
      out.orbit(0, 0);
    } else {
      const { parent, child } = page.chain || page.limb || { parent: 0, child: 0 };
      const middle = S.scaled(solid.positions.reduce((s, p) => S.plus(s, p)), 1 / solid.positions.length);
      const outward = S.minus(solid.positions[child], middle);
      const along = S.direction(S.minus(solid.positions[child], solid.positions[parent]));
      const normal = shown.d ? S.rotate(S.multiply(
        solid.rotations[parent], S.conjugate(shown.d.q)), shown.d.n) : page.ahead;
      out.lookFrom(OrbitCamera.bestDirection(out, along, normal, outward));
    }
    out.frame(points, wide / Math.max(high, 1), 1.3);
    out.zoom(page.camera ? page.camera.zoom : 1);
    return out;
  }

  // -- numbers, sliders, words ------------------------------------------------------------------

  function showNumbers(d) {
    all("#equations .row").forEach((row) => {
      const symbol = row.dataset.symbol;
      row.hidden = !d || (page.show.length > 0 && !page.show.includes(symbol));
      row.querySelector(".value").textContent = d ? Labels.row(symbol, shown.of) : "";
      row.querySelector("button").setAttribute("aria-pressed", String(state.lit === symbol));
    });
    all("#equations section").forEach((section) => {
      const head = section.querySelector("h3");
      head.textContent = head.dataset.title.replace(/\{(.)\}/g, (_, joint) => page.joints[joint]);
      section.hidden = !Array.from(section.querySelectorAll(".row")).some((row) => !row.hidden);
    });
    one("#equations").hidden = !d;
    one("#frame-number").textContent = tr("Frame {frame}", { frame: state.frame });
    one("#frame").value = state.frame;
  }

  function showSliders(d) {
    one("#what-if").hidden = !d;
    if (!d) return;
    const { whatIf } = state;
    const angles = {
      twist: whatIf.twist, swing: whatIf.swing === null ? d.alpha : whatIf.swing,
      bend: whatIf.bend === null ? d.bend : whatIf.bend, nudge: whatIf.nudge,
    };
    Object.keys(angles).forEach((name) => setSlider(
      name, Labels.inDegrees(angles[name]), `${SLIDERS[name](Labels.inDegrees(angles[name]), 1)}°`));
    setSlider("applied", 100 * whatIf.applied, `${Math.round(100 * whatIf.applied)} %`);
    const stage = state.stage === null ? 2 : state.stage;
    setSlider("stage", stage, Labels.plain(stage, 2));
    const { whole } = shown.of.correction;
    one("#applied").disabled = Math.abs(whole) < 1e-9 && whatIf.applied === 0;
    one("#offset").textContent = `offset(t) = ${Labels.degrees(whole)}`;
    one("#along").setAttribute("aria-pressed", String(!whatIf.counter));
    one("#counter").setAttribute("aria-pressed", String(whatIf.counter));
    one("#reset").disabled = !altered();
    const said = Words.say(shown.of, whatIf, state.stage);
    one("#words").textContent = said.text;
    one("#words").className = said.role;
  }

  function setSlider(name, value, text) {
    const slider = one(`#${name}`);
    if (document.activeElement !== slider || Math.abs(slider.value - value) > slider.step) {
      slider.value = value;
    }
    slider.setAttribute("aria-valuetext", text);
    one(`output[for=${name}]`).textContent = text;
  }

  // -- the task ---------------------------------------------------------------------------------

  const CONDITIONS = {
    moved: (c) => Math.abs(state.frame - page.frame) >= c.amount,
    seen: (c) => c.words.includes(state.look),
    lit: (c) => c.words.includes(state.lit),
    swing: (c, d) => (state.whatIf.swing !== null || state.whatIf.toward !== null)
      && d !== null && d.alpha >= radians(c.amount - 0.05),
    twist: (c) => Math.abs(state.whatIf.twist) >= radians(c.amount - 0.05),
    along: () => !state.whatIf.counter,
    counter: (c, d) => state.whatIf.counter && d !== null // before any offset is removed
      && shown.of.correction.before.strength >= page.chain.tau,
    nudged: (c) => c.words.every((word) => state.met.has(word)),
    applied: (c) => state.whatIf.applied >= c.amount - 1e-9,
    accepted: () => false, // a page records no decisions and has no threshold to drag
    tau: () => false,
    listed: () => false,
  };

  function check(d) {
    const { whatIf } = state;
    if (d && Math.abs(whatIf.nudge) >= radians(0.5)) {
      if (whatIf.swing !== null && whatIf.swing >= radians(178)) state.met.add("swing");
      if (whatIf.bend !== null && whatIf.bend <= radians(2)) state.met.add("bend");
    }
    if (page.done.length && page.done.every((c) => CONDITIONS[c.name](c, d))) {
      all("article")[state.at].classList.add("done");
    }
  }

  // -- input -------------------------------------------------------------------------------

  function turnTo(at) {
    playback.stop();
    state.at = at;
    page = lesson.pages[at];
    Object.assign(state, {
      frame: page.frame, whatIf: Object.assign({}, page.whatIf), stage: page.stage,
      lit: page.lit, look: page.look, met: new Set(),
    });
    camera = null;
    all("article").forEach((article, k) => { article.hidden = k !== at; });
    all("article")[at].classList.remove("done");
    one("#text").scrollTop = 0;
    one("#back").disabled = at === 0;
    one("#next").disabled = at + 1 === lesson.pages.length;
    one("#page-number").textContent = `${at + 1} / ${lesson.pages.length}`;
    one("#staged").hidden = page.stage === null;
    one("#looks").hidden = !page.after;
    legend();
    const slider = one("#frame");
    slider.min = page.first;
    slider.max = page.last;
    one("#curves").classList.toggle("empty", !page.chain);
    dress();
    try {
      history.replaceState(null, "", `#${at + 1}`);
    } catch (error) { /* a page inside another one may not */ }
  }

  function legend() {
    const words = { name: page.label };
    if (page.taught) Object.assign(words, { before: `□ ${tr("as captured")}`, after: `■ ${tr("what if")}` });
    else if (page.after && state.look === "both") {
      Object.assign(words, { before: `□ ${tr("before")}`, after: `■ ${tr("after")}` });
    } else if (page.after) words.name += ` · ${state.look === "before" ? tr("before") : tr("after")}`;
    one("#legend").replaceChildren(...Object.keys(words).map((role) => {
      const item = document.createElement("span");
      item.className = role;
      item.textContent = words[role];
      return item;
    }));
    all("#looks button").forEach(
      (button) => button.setAttribute("aria-pressed", String(button.value === state.look)));
  }

  function dress() { // sizes and colours, and a picture
    view.resize();
    view.enter(page.span.figure, theme(), page.skin);
    plot.resize();
    plot.show(page);
    draw();
  }

  function alter(change) {
    Object.assign(state.whatIf, change);
    redraw();
  }

  function goTo(frame) {
    state.frame = Math.min(Math.max(frame, page.first), page.last);
    redraw();
  }

  function reset() {
    state.whatIf = Object.assign({}, S.AS_CAPTURED);
    state.stage = page.stage === null ? null : 2;
    redraw();
  }

  function lookAt(look) {
    state.look = look;
    legend();
    redraw();
  }

  function light(symbol) {
    state.lit = state.lit === symbol ? "" : symbol;
    redraw();
  }

  Object.keys(SLIDERS).forEach((name) => {
    one(`#${name}`).addEventListener("input", (event) => alter({ [name]: radians(+event.target.value) }));
  });
  one("#applied").addEventListener("input", (event) => alter({ applied: event.target.value / 100 }));
  one("#stage").addEventListener("input", (event) => {
    state.stage = +event.target.value;
    redraw();
  });
  one("#frame").addEventListener("input", (event) => {
    playback.stop();
    goTo(+event.target.value);
  });
  one("#along").addEventListener("click", () => alter({ counter: false }));
  one("#counter").addEventListener("click", () => alter({ counter: true }));
  one("#reset").addEventListener("click", reset);
  one("#back").addEventListener("click", () => turnTo(state.at - 1));
  one("#next").addEventListener("click", () => turnTo(state.at + 1));
  one("#home").addEventListener("click", () => {
    camera = null;
    redraw();
  });
  all("#looks button").forEach(
    (button) => button.addEventListener("click", () => lookAt(button.value)));
  all("#equations button").forEach((button) => button.addEventListener(
    "click", () => light(button.closest(".row").dataset.symbol)));
  const KEYS = { // as in the program; sliders, the figure and buttons have their own keys
    Escape: () => state.lit && light(state.lit),
    ArrowLeft: () => goTo(state.frame - 1),
    ArrowRight: () => goTo(state.frame + 1),
    " ": () => playback.toggle(),
    b: () => page.after && lookAt(LOOKS[(LOOKS.indexOf(state.look) + 1) % LOOKS.length]),
  };
  document.addEventListener("keydown", (event) => {
    const plain = !event.ctrlKey && !event.altKey && !event.metaKey;
    const free = event.target === document.body
      || (event.key.length === 1 && event.key !== " ") || event.key === "Escape";
    if (!plain || !free || !KEYS[event.key]) return;
    if (event.key !== "Escape") event.preventDefault();
    KEYS[event.key]();
  });
  Hand.orbits(one("#scene"), () => camera, redraw, () => {
    camera = null;
    redraw();
  });
  window.addEventListener("resize", () => dress());
  dark.addEventListener("change", dress);

  const asked = () => { // the page in the address, or the first
    const at = Number(location.hash.slice(1));
    return lesson.pages[at - 1] ? at - 1 : 0;
  };
  window.addEventListener("hashchange", () => turnTo(asked()));
  turnTo(asked());
})();
