// Plays the intervals of a clip: two figures, before and after, with one camera and one playhead.
(function () {
  "use strict";

  const S = SwingTwist;
  const data = ClipData.read(JSON.parse(document.getElementById("play-data").textContent));
  const one = (selector) => document.querySelector(selector);
  const all = (selector) => Array.from(document.querySelectorAll(selector));
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const scenes = all(".scene"), links = all("#list a"), abouts = all(".about");
  const views = scenes.map((scene) => new FigureView.View(scene, data));
  const ROLES = [2, 3]; // of the wrong limb before and after, as in bone_colours.Role
  let page = null, at = -1, frame = 0, camera = null, followed = null, waiting = false;

  const playback = Playback.onButton(one("#play"), ["Play", "Pause"],
    () => ({ first: page.first, last: page.last, frame, fps: page.span.fps }),
    () => Number(one("#speed").value), goTo);

  document.documentElement.classList.add("live");
  one("#no-3d").hidden = views[0].renderer !== null;

  // -- what is shown ------------------------------------------------------------------------------

  const offsetNow = () => {
    const k = frame - page.start;
    return (page.after && page.offset[k]) || 0;
  };
  const degrees = (angle) => `${Math.abs(angle).toFixed(0)}°`;

  function middleOf(pose) { // of the person, which the camera follows
    const sum = page.body.map((j) => pose.positions[j]).reduce((s, p) => S.plus(s, p));
    return S.scaled(sum, 1 / page.body.length);
  }

  function draw() {
    waiting = false;
    const { span } = page, { figure } = span;
    const poses = [null, page.after].map((after) => span.pose(frame, span.rotations(frame, after)));
    const differs = FigureView.differing(figure, poses[0], poses[1]);
    const strong = figure.bones.map((_, k) => page.strong.includes(k));
    const none = figure.bones.map(() => false), middle = middleOf(poses[0]);
    if (followed) camera.target = S.plus(camera.target, S.minus(middle, followed));
    followed = middle;
    views.forEach((view, k) => view.draw(
      camera, { solid: poses[k], ghost: poses[k], strong, differs, left: none, role: ROLES[k] },
      (context, project) => mark(context, project, poses[k], k)));
    tell();
  }

  function mark(context, project, pose, side) { // the angle next to the wrong bone
    const offset = offsetNow(), bone = page.span.figure.bones[page.strong[0]];
    if (!offset || !bone || side) return;
    const start = pose.positions[bone.parent];
    const half = S.rotate(pose.rotations[bone.parent], S.scaled(bone.tip, 0.5));
    const [x, y] = project(S.plus(start, half));
    const { roles } = views[side].colours, text = degrees(offset);
    context.font = "600 17px system-ui, sans-serif";
    context.lineWidth = 5;
    context.lineJoin = "round";
    context.strokeStyle = roles.surface;
    context.fillStyle = roles.before;
    context.strokeText(text, x + 18, y - 18);
    context.fillText(text, x + 18, y - 18);
  }

  function tell() {
    const offset = offsetNow(), turned = offset ? `: turned by ${degrees(offset)}` : "";
    one(".before .tag").textContent = `Before${turned}`;
    one(".after .tag").textContent = !page.after ? "No correction"
      : page.accepted ? "After" : "If accepted";
    one("#at").textContent = `Frame ${frame} · ${(frame / page.span.fps).toFixed(2)} s`;
    one("#frame").value = frame;
    one("#frame").setAttribute("aria-valuetext", `Frame ${frame}${turned}`);
    const [start, stop] = page.curve;
    abouts[at].style.setProperty("--at", (frame + 0.5 - start) / (stop - start));
  }

  function redraw() { // once per screen refresh
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(draw);
  }

  function aim() { // the view that shows this interval best
    camera = new OrbitCamera.Camera(page.span.figure.room.up, page.ahead);
    const [wide, high] = views[0].size;
    Object.assign(camera, {
      target: page.target, azimuth: page.azimuth, elevation: page.elevation,
      distance: page.distance / Math.sqrt(Math.min(wide / Math.max(high, 1), 1)),
    });
    followed = middleOf(page.span.pose(page.frame, page.span.rotations(page.frame, null)));
  }

  function dress() { // sizes and colours
    views.forEach((view) => {
      view.resize();
      view.enter(page.span.figure, dark.matches ? "dark" : "light", true);
    });
    draw();
  }

  // -- input --------------------------------------------------------------------------------------

  function choose(k, focus) {
    const first = page === null, next = Math.min(Math.max(k, 0), links.length - 1);
    if (focus) links[next].focus();
    if (next === at) return;
    playback.stop();
    at = next;
    page = data.pages[at];
    frame = page.frame;
    links.forEach((link, n) => {
      link.tabIndex = n === at ? 0 : -1;
      link.setAttribute("aria-current", String(n === at));
      abouts[n].hidden = n !== at;
    });
    one("#frame").min = page.first;
    one("#frame").max = page.last;
    const [head, text] = abouts[at].querySelectorAll("h3, p");
    one("#said").textContent = `${head.innerText}: ${text.innerText}`;
    aim();
    if (first) dress();
    else redraw();
  }

  function jump(k) { // from a link or the address
    choose(k, true);
    one("#player").scrollIntoView({ block: "nearest" });
    try {
      history.replaceState(null, "", links[k].hash);
    } catch (error) { /* a page inside another one may not */ }
  }

  function goTo(to) {
    frame = Math.min(Math.max(to, page.first), page.last);
    redraw();
  }

  function step(count) {
    playback.stop();
    goTo(frame + count);
  }

  const home = () => {
    aim();
    goTo(page.frame);
  };
  const KEYS = {
    ArrowUp: () => choose(at - 1, true),
    ArrowDown: () => choose(at + 1, true),
    Home: () => choose(0, true),
    End: () => choose(links.length - 1, true),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    " ": playback.toggle,
  };
  one("#list").addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
    event.preventDefault();
    KEYS[event.key]();
  });
  const found = (hash) => links.findIndex((link) => link.hash === hash);
  document.addEventListener("click", (event) => { // also from the table
    const link = event.target.closest && event.target.closest("a[href^='#find-']");
    if (!link || found(link.hash) < 0) return;
    event.preventDefault();
    jump(found(link.hash));
  });
  one("#back").addEventListener("click", () => step(-1));
  one("#on").addEventListener("click", () => step(1));
  one("#home").addEventListener("click", home);
  one("#frame").addEventListener("input", (event) => step(event.target.value - frame));
  scenes.forEach((scene) => Hand.orbits(scene, () => camera, redraw, home));
  window.addEventListener("resize", dress);
  dark.addEventListener("change", dress);
  window.addEventListener("hashchange", () => found(location.hash) >= 0 && jump(found(location.hash)));
  choose(Math.max(found(location.hash), 0), false);
  if (found(location.hash) >= 0) one("#player").scrollIntoView();
})();
