"""Server for the report of a tournament that is under way, on this machine alone: http://127.0.0.1."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

from catch_arena.errors import CatchArenaError, ReplayError
from catch_arena.explanation import Explanation, explain
from catch_arena.player.bundle import bundle_text
from catch_arena.report.data import ReportData
from catch_arena.report.page import content_policy, page
from catch_arena.text import printable, without_folders
from catch_arena.tournament.store import Store

HOST: Final = "127.0.0.1"
PORT: Final = 8765
"""Number of the port; if it is taken, any free one is used."""
_PAUSE_S: Final = 2.0
_PAUSE_FACTOR: Final = 10.0
"""Pause between two refreshes, in durations of the last one: they take at most a tenth of one core's time."""
_LOOKED_AT: Final = 4
"""Number of recorded matches in which a refresh looks for the best moment."""
_PATIENCE_S: Final = 5.0
"""Time within which a request must arrive [s]."""


class LiveReport:
    """Report of a folder, made again when there are more matches; any number of threads may use it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()
        self._page = ""
        self._data: ReportData | None = None
        self._explanations: dict[str, Explanation] = {}
        self._shown = ""
        self._next = 0.0

    def state(self) -> str:
        """Return a text that changes when the page does; refresh the page if the pause is over."""
        with self._lock:
            if (begin := time.monotonic()) >= self._next:
                self._refresh()
                end = time.monotonic()
                self._next = end + max(_PAUSE_S, _PAUSE_FACTOR * (end - begin))
            return self._shown

    def page(self) -> str:
        """Return the current page, which requests the replays that it shows."""
        self.state()
        return self._page

    def bundle(self, match: str) -> str:
        """Return the replay bundle of any recorded match; raise CatchArenaError for another one."""
        if self._data is None:
            raise ReplayError("no match has been played yet; reload the page later")
        return bundle_text(self._data.replay(match))

    def _refresh(self) -> None:
        with Store.read(self._folder) as store:
            count = store.count_played()
            state = f"{count} ended" if store.ended else str(count)
        if state == self._shown:
            return
        if not count:
            self._page = _WAITING
        else:
            self._data = ReportData.of(self._folder)
            self._look_at(self._data)
            self._page = page(self._data, {}, self._explanations, watched=True)
        self._shown = state

    def _look_at(self, data: ReportData) -> None:
        """Explain the newest recorded matches, a few for each refresh."""
        for match in sorted(data.recorded - self._explanations.keys(), reverse=True)[:_LOOKED_AT]:
            with suppress(ReplayError):  # it was moved away, or has another ruleset
                self._explanations[match] = explain(data.replay(match))


_WAITING: Final = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="color-scheme" content="light dark">'
    '<meta http-equiv="refresh" content="2"><title>Catch Arena</title><p>No match has been played yet.</p></html>'
)


class _Handler(BaseHTTPRequestHandler):
    server: "_Server"
    timeout = _PATIENCE_S

    def do_GET(self) -> None:
        """Answer with the page, its state, or a replay bundle."""
        name, port = self.headers.get("Host", ""), self.server.server_port
        if name not in (f"{HOST}:{port}", f"localhost:{port}"):  # a stranger's page, under a name that leads here
            self._answer(403, "text/plain", "use the address http://127.0.0.1")
            return
        path = self.path.partition("?")[0]
        try:
            if path == "/":
                self._answer(200, "text/html", self.server.report.page())
            elif path == "/state":
                self._answer(200, "text/plain", self.server.report.state())
            elif path.startswith("/bundles/"):
                self._answer(200, "text/plain", self.server.report.bundle(unquote(path.removeprefix("/bundles/"))))
            else:
                self._answer(404, "text/plain", "there is no page at this address")
        except CatchArenaError as error:
            self._answer(404, "text/plain", without_folders(printable(str(error))))

    def _answer(self, status: int, kind: str, text: str) -> None:
        content = text.encode()
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Content-Security-Policy", f"{content_policy(watched=True)}; frame-ancestors 'none'")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: Any) -> None:
        """Print nothing, since the terminal belongs to the tournament."""


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = False  # a port that another process uses must look taken, on Windows too

    def __init__(self, port: int, report: LiveReport) -> None:
        self.report = report
        super().__init__((HOST, port), _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print errors of a request, except a lost connection to a reader."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


@contextmanager
def serve(report: LiveReport) -> Iterator[str]:
    """Serve a report inside the `with` block, and yield its address."""
    try:
        server = _Server(PORT, report)
    except OSError:
        server = _Server(0, report)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
