"""Started by an icon, without a terminal: what there is to say is said in the browser.

`mikas-dashboard` is `mikas dash --desktop` without a console, where a system makes a difference
(Windows). An error that keeps the dashboard from starting is shown as a page too: served once, as a
browser in a sandbox can't read the files of this program.
"""

from __future__ import annotations

from typing import Final

from mikas.cli.language import tr

FLAG: Final = "--desktop"
_PATIENCE: Final = 60.0  # s for a browser to start
_SILENCE: Final = 2.0  # s of a connection that a browser opens ahead and does not use
_PAGE: Final = """\
<!doctype html>
<html><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>mikas</title>
<style>body {{ font: 1.125rem/1.5 sans-serif; max-width: 40rem; margin: 10vh auto; padding: 0 1rem;
color-scheme: light dark }} pre {{ font-size: 0.8rem; overflow: auto }}</style></head>
<body><h1>{title}</h1><p>{text}</p><pre>{details}</pre></body></html>
"""


def open_page(url: str) -> bool:
    """Open `url` in the user's browser; return whether there is one."""
    import webbrowser

    return webbrowser.open(url)


def show_failure(text: str, details: str = "") -> None:
    """Show in the browser why the program did not start; return once the browser has it."""
    from html import escape
    from http.server import BaseHTTPRequestHandler, HTTPServer

    title = tr("mikas did not start", "mikas не запустился")
    page = _PAGE.format(title=title, text=escape(text), details=escape(details))

    class DesktopServer(HTTPServer):
        """Waits until a browser has the page, or none comes."""

        timeout = _PATIENCE
        waiting = True

        def handle_timeout(self) -> None:
            self.waiting = False

    class Page(BaseHTTPRequestHandler):
        """The page at every address."""

        timeout = _SILENCE

        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(page.encode())
            server.waiting = False

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with DesktopServer(("127.0.0.1", 0), Page) as server:
        if open_page(f"http://127.0.0.1:{server.server_port}/"):
            while server.waiting:
                server.handle_request()
