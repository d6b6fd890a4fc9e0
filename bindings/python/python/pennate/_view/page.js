// What is added to viser's page before its own program starts.

// Without a GPU edges are not smoothed: viser asks for four samples of each pixel, which it has no argument for, and a processor
// that draws in the place of a GPU needs two to four times as long for each frame.
(() => {
  const probe = document.createElement('canvas').getContext('webgl2');
  const names = probe && probe.getExtension('WEBGL_debug_renderer_info');
  const renderer = names ? String(probe.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
  if (probe) probe.getExtension('WEBGL_lose_context')?.loseContext();
  if (!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer)) return;
  const real = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return real.call(this, kind, kind === 'webgl2' ? { ...options, antialias: false } : options);
  };
})();

// viser turns the picture by arrow keys wherever they are pressed; on a slider they move the slider alone.
addEventListener('DOMContentLoaded', () => document.body.addEventListener('keydown', (event) => {
  if (event.target.closest && event.target.closest('[role=slider], input')) event.stopPropagation();
}));

// The name of what the pointer is on. Places of names are in an element of the panel, which is empty while the network moves;
// the camera is what viser shows to its own tests. Where a version of viser shows it no longer, there are no names.
addEventListener('DOMContentLoaded', () => {
  const label = document.body.appendChild(document.createElement('div'));
  label.id = 'pn-name';
  label.style.cssText = 'position:fixed;z-index:50;display:none;pointer-events:none;padding:1px 7px;border-radius:4px;' +
    'background:#1a1d21e0;color:#fff;font:12px/1.5 system-ui,sans-serif;white-space:nowrap';
  let text = null, things = [];

  function known() {
    const now = document.querySelector('[data-pn-places]')?.dataset.pnPlaces ?? '[]';
    if (now !== text) things = JSON.parse(text = now);
    return things;
  }

  const times = (m, [x, y, z, w]) => [0, 1, 2, 3].map((row) => m[row] * x + m[row + 4] * y + m[row + 8] * z + m[row + 12] * w);

  // How far a point of the screen is from a line, and how deep the nearest point of the line lies.
  function near([x, y], a, b) {
    const dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    const part = square ? Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / square)) : 0;
    return [Math.hypot(x - a[0] - part * dx, y - a[1] - part * dy), a[2] + part * (b[2] - a[2])];
  }

  function under(event, viewer, world) {
    const box = viewer.canvas.getBoundingClientRect(), { projectionMatrix, matrixWorldInverse } = viewer.camera;
    const place = [event.clientX - box.left, event.clientY - box.top];
    const seen = (point) => {
      const [x, y, , depth] = times(projectionMatrix.elements, times(matrixWorldInverse.elements, times(world, [...point, 1])));
      return [(x / depth + 1) / 2 * box.width, (1 - y / depth) / 2 * box.height, depth];
    };
    let best = null, front = Infinity;
    for (const { name, radius, points } of known()) {
      const line = points.map(seen);
      for (let i = 0; i < line.length; i++) {
        const [far, depth] = near(place, line[i], line[Math.min(i + 1, line.length - 1)]);
        const reach = Math.max(4, radius * projectionMatrix.elements[5] * box.height / 2 / depth);
        // What lies behind is hidden; a ball stands out of the tubes that it joins.
        if (depth > 0 && far <= reach && depth - radius < front) { front = depth - radius; best = name; }
      }
    }
    return best;
  }

  let waiting = null;
  addEventListener('pointermove', (event) => {
    if (waiting === null) requestAnimationFrame(() => {
      const last = waiting, viewer = window.__viserMutable;
      waiting = null;
      const world = viewer?.nodeRefFromName?.['/network/0']?.matrixWorld?.elements;
      const name = world && viewer.camera && last.target === viewer.canvas && !last.buttons ? under(last, viewer, world) : null;
      label.style.display = name ? 'block' : 'none';
      if (name) {
        label.textContent = name;
        label.style.left = `${last.clientX + 14}px`;
        label.style.top = `${last.clientY + 10}px`;
      }
    });
    waiting = event;
  }, { passive: true });
});
