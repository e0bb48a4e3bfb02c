// Turns the camera with mouse, touch and keys.
var Hand = (function () {
  "use strict";

  const TURN = 0.008; // radians per pixel
  const STEP = Math.PI / 24; // radians per key press
  const KEYS = {
    ArrowLeft: (camera) => camera.orbit(-STEP, 0),
    ArrowRight: (camera) => camera.orbit(STEP, 0),
    ArrowUp: (camera) => camera.orbit(0, STEP),
    ArrowDown: (camera) => camera.orbit(0, -STEP),
    "+": (camera) => camera.zoom(1.15),
    "=": (camera) => camera.zoom(1.15),
    "-": (camera) => camera.zoom(1 / 1.15),
  };

  function orbits(element, cameraNow, redraw, home) {
    const down = new Map(); // pointer → its position

    element.addEventListener("pointerdown", (event) => {
      if (event.target.closest("button")) return;
      element.setPointerCapture(event.pointerId);
      down.set(event.pointerId, [event.clientX, event.clientY]);
    });
    element.addEventListener("pointermove", (event) => {
      const was = down.get(event.pointerId), camera = cameraNow();
      if (!was || !camera) return;
      const now = [event.clientX, event.clientY], x = now[0] - was[0], y = now[1] - was[1];
      if (down.size === 2) pinch(camera, event.pointerId, was, now);
      else if (event.buttons & 2 || event.buttons & 4 || event.shiftKey) {
        camera.pan(x, -y, element.clientHeight);
      } else camera.orbit(-TURN * x, TURN * y);
      down.set(event.pointerId, now);
      redraw();
    });
    const up = (event) => down.delete(event.pointerId);
    element.addEventListener("pointerup", up);
    element.addEventListener("pointercancel", up);
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      cameraNow().zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)));
      redraw();
    }, { passive: false });
    element.addEventListener("keydown", (event) => {
      if (event.target !== element || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key === "Home") home();
      else if (KEYS[event.key]) KEYS[event.key](cameraNow());
      else return;
      event.preventDefault();
      redraw();
    });

    function pinch(camera, moved, was, now) {
      const other = Array.from(down).find(([id]) => id !== moved)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      camera.zoom(Math.max(apart(now), 1) / Math.max(apart(was), 1));
      camera.pan((now[0] - was[0]) / 2, -(now[1] - was[1]) / 2, element.clientHeight);
    }
  }

  return { orbits: orbits };
})();
