// Plays frames in a loop, and shows on its button what a click does.
var Playback = (function () {
  "use strict";

  // words: of the button while nothing plays, and while it plays; range() → { first, last, frame,
  // fps }; speed() → 1 is real time.
  function onButton(button, words, range, speed, goTo) {
    let playing = 0;

    function stop() {
      cancelAnimationFrame(playing);
      playing = 0;
      button.textContent = words[0];
    }

    function toggle() {
      if (playing) return stop();
      button.textContent = words[1];
      const { first, last, frame, fps } = range();
      let exact = frame - first, was = performance.now();
      const next = (now) => {
        exact += (Math.max(now - was, 0) / 1000) * fps * speed();
        was = now;
        goTo(first + (Math.floor(exact) % (last - first + 1)));
        playing = requestAnimationFrame(next);
      };
      playing = requestAnimationFrame(next);
      return undefined;
    }

    button.addEventListener("click", toggle);
    return { stop: stop, toggle: toggle };
  }

  return { onButton: onButton };
})();
