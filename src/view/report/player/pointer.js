/**
 * Turns, moves and zooms a camera, and calls `changed` after each change. One finger scrolls the page, unless the
 * picture fills the screen. Two fingers turn and zoom. Three fingers move the target.
 */
function steer(canvas, camera, changed) {
  const pointers = new Map();
  const spread = () => {
    const places = [...pointers.values()];
    const middle = [0, 1].map((k) => places.reduce((sum, place) => sum + place[k], 0) / places.length);
    return { middle, distance: places.reduce((sum, [x, y]) => sum + Math.hypot(x - middle[0], y - middle[1]), 0) };
  };
  const isScroll = (event) => event.pointerType === "touch" && pointers.size < 2 && !document.fullscreenElement;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.focus({ preventScroll: true });
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) {
      return;
    }
    const height = canvas.clientHeight || 1;
    const before = spread();
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (isScroll(event)) {
      return;
    }
    const now = spread();
    const [across, down] = [0, 1].map((k) => (now.middle[k] - before.middle[k]) / height);
    if (pointers.size > 2 || event.shiftKey || (event.buttons & 6) !== 0) {
      camera.move(across, down);
    } else {
      camera.turn(across * Math.PI, down * Math.PI);
    }
    if (pointers.size > 1) {
      camera.zoom(before.distance / Math.max(now.distance, 1));
    }
    changed();
  });
  // Keeps the browser from handling gestures.
  for (const kind of ["touchstart", "touchmove"]) {
    canvas.addEventListener(kind, (event) => {
      if (event.touches.length > 1 && event.cancelable) {
        event.preventDefault();
      }
    }, { passive: false });
  }
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  // The wheel zooms if the picture has the focus or Ctrl is pressed. Otherwise, it scrolls the page.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement === canvas || event.ctrlKey) {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      camera.zoom(Math.exp(Math.min(Math.max(event.deltaY * lines, -300), 300) * 0.0015));
      changed();
    }
  }, { passive: false });
}

/** Returns whether the key has a function. */
function steerByKey(event, camera) {
  const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
  if (turn && (event.shiftKey || turn[0] === 0)) {
    camera.turn(...turn);
  } else if (event.key === "+" || event.key === "=") {
    camera.zoom(0.85);
  } else if (event.key === "-") {
    camera.zoom(1 / 0.85);
  } else {
    return false;
  }
  return true;
}
