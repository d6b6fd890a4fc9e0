"""What is added to viser's page before its own program starts: see `page.js`."""

from __future__ import annotations

import importlib.resources

from websockets.http11 import Response

SCRIPT = importlib.resources.files(__package__).joinpath("page.js").read_text(encoding="utf-8")
HEAD = b"<head>"


def extended(found: Response) -> Response:
    """A page with the script at its beginning; other answers as they are."""
    if not found.headers.get("Content-Type", "").startswith("text/html") or HEAD not in found.body:
        return found
    body = found.body.replace(HEAD, HEAD + f"<script>{SCRIPT}</script>".encode(), 1)
    del found.headers["Content-Length"]
    found.headers["Content-Length"] = str(len(body))
    return Response(found.status_code, found.reason_phrase, found.headers, body)
