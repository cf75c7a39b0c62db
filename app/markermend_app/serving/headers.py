"""What every answer of the server says about itself, so that a browser holds it to that.

The content policy is as strict as BokehJS and Panel allow: nothing but this server's own scripts
runs, no text is ever compiled (no ``unsafe-eval``), and no attribute of an element is a script.
Panel makes the modules of its components from text, as ``blob:``; Bokeh writes styles into
elements, so that styles alone are allowed inline.
"""

import re
import secrets

from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.web import OutputTransform

SCRIPT_TAG = re.compile(rb"<script(?=[\s>])")
POLICY = {
    "default-src": "'none'",
    "script-src": "'self' blob:",
    "style-src": "'self' 'unsafe-inline'",
    "img-src": "'self' data: blob:",
    "font-src": "'self' data:",
    "connect-src": "'self' blob:",
    "base-uri": "'none'",
    "form-action": "'self'",
    "frame-ancestors": "'none'",
    "object-src": "'none'",
}
ALWAYS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": ", ".join(
        f"{name}=()"
        for name in (
            "camera", "display-capture", "geolocation", "hid", "microphone", "midi", "payment",
            "serial", "usb",
        )
    ),
}  # fmt: skip
KEPT = ("text/css", "text/javascript", "application/javascript", "font/", "image/")
"""Content that a browser may keep; all else may tell of somebody's takes."""
HTTPS_ONLY = "max-age=31536000"


class Guarded(OutputTransform):
    """Adds the headers to every answer, and lets the page's own scripts run."""

    https = False

    def __init__(self, request: HTTPServerRequest) -> None:
        del request

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """Add the headers; see `tornado.web.OutputTransform`."""
        del finishing
        content = headers.get("Content-Type", "")
        policy = dict(POLICY)
        if content.startswith("text/html"):
            # No page holds text of a take or a person: every script in it is the server's own.
            nonce = secrets.token_urlsafe(16)
            chunk = SCRIPT_TAG.sub(f'<script nonce="{nonce}"'.encode(), chunk)
            policy["script-src"] += f" 'nonce-{nonce}'"
            if "Content-Length" in headers:
                headers["Content-Length"] = str(len(chunk))
        headers["Content-Security-Policy"] = "; ".join(f"{k} {v}" for k, v in policy.items())
        for name, value in ALWAYS.items():
            headers[name] = value
        if not content.startswith(KEPT) or status_code >= 400:
            headers["Cache-Control"] = "no-store"
        if self.https:
            headers["Strict-Transport-Security"] = HTTPS_ONLY
        headers.pop("Server", None)
        return status_code, headers, chunk


class GuardedByTls(Guarded):
    """The same, of a server that is reached by https alone."""

    https = True
