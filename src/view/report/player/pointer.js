/** Turns, moves and zooms a camera by mouse, pen, fingers and keys; tells when it did. */
function steer(canvas, camera, changed) {
  const pointers = new Map();
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], distance: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.focus({ preventScroll: true });
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before || pointers.size > 2) {
      return;
    }
    const height = canvas.clientHeight || 1;
    const pinch = pointers.size === 2 ? spread() : undefined;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const [across, down] = [(event.clientX - before[0]) / height, (event.clientY - before[1]) / height];
    if (pinch) {
      const now = spread();
      camera.move((now.middle[0] - pinch.middle[0]) / height, (now.middle[1] - pinch.middle[1]) / height);
      camera.zoom(pinch.distance / Math.max(now.distance, 1));
    } else if (event.shiftKey || (event.buttons & 6) !== 0) {
      camera.move(across, down);
    } else {
      camera.turn(across * Math.PI, down * Math.PI);
    }
    changed();
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  // Unless the picture was clicked, the wheel scrolls the page.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement === canvas || event.ctrlKey) {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      camera.zoom(Math.exp(Math.min(Math.max(event.deltaY * lines, -300), 300) * 0.0015));
      changed();
    }
  }, { passive: false });
}

/** What the keys do to a camera; returns whether the key means anything. */
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
