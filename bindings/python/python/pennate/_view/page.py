"""What is added to viser's page before its own program starts.

viser asks for four samples of each pixel, which it has no argument for. A GPU does not notice; a processor that draws in the place
of one needs two to four times as long for each frame.
"""

from __future__ import annotations

from websockets.http11 import Response

SCRIPT = """
// Without a GPU edges are not smoothed.
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
  if (event.target.closest && event.target.closest('[role=slider], input')) event.stopPropagation(); }));
"""
HEAD = b"<head>"


def extended(found: Response) -> Response:
    """A page with the script at its beginning; other answers as they are."""
    if not found.headers.get("Content-Type", "").startswith("text/html") or HEAD not in found.body:
        return found
    body = found.body.replace(HEAD, HEAD + f"<script>{SCRIPT}</script>".encode(), 1)
    del found.headers["Content-Length"]
    found.headers["Content-Length"] = str(len(body))
    return Response(found.status_code, found.reason_phrase, found.headers, body)
