"""An X server without a screen, with keys from xdotool and pictures of its contents; `make window` runs these tests."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

WIDTH, HEIGHT = 1400, 900
_WAIT_S = 180.0


class Desk:
    """The server's screen: what is on it, and hands on its keyboard."""

    def __init__(self, display: str, screen: Path) -> None:
        self.screen = screen
        self.environment = {**os.environ, "DISPLAY": display, "SDL_VIDEODRIVER": "x11"}

    def keys(self, *words: str) -> None:
        """Xdotool's words, as in `key p` and `keydown Up`."""
        subprocess.run(["xdotool", *words], env=self.environment, check=True)

    def picture(self) -> np.ndarray:
        """The whole screen, (height, width, 3), red first, from the server's memory; its form is XWD."""
        dump = self.screen.read_bytes()
        header = np.frombuffer(dump[:100], ">u4").astype(int)
        start, width, height, bits, line, colors = header[[0, 4, 5, 11, 12, 19]]
        rows = np.frombuffer(dump, np.uint8, line * height, start + 12 * colors).reshape(height, line)
        deep = bits // 8
        return rows[:, : width * deep].reshape(height, width, deep)[..., 2::-1]

    def window(self) -> tuple[str, tuple[int, int, int, int]]:
        """The only window's id, and its left, top, width and height."""
        words = ["xdotool", "search", "--onlyvisible", "--class", "."]
        found = subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False).stdout.split()
        if not found:
            return "", (0, 0, 0, 0)
        words = ["xdotool", "getwindowgeometry", "--shell", found[-1]]
        shown = subprocess.run(words, env=self.environment, capture_output=True, text=True, check=True).stdout
        parts = dict(line.split("=") for line in shown.split())
        return found[-1], (int(parts["X"]), int(parts["Y"]), int(parts["WIDTH"]), int(parts["HEIGHT"]))

    def seen(self) -> np.ndarray:
        """The window's part of the screen."""
        _, (left, top, width, height) = self.window()
        return self.picture()[top : top + height, left : left + width]

    def wait(self, until: Callable[[], bool]) -> None:
        """Fails if it takes too long."""
        deadline = time.monotonic() + _WAIT_S
        while not until():
            assert time.monotonic() < deadline
            time.sleep(0.1)


@pytest.fixture(scope="session")
def desk(tmp_path_factory) -> Iterator[Desk]:
    read, write = os.pipe()
    memory = tmp_path_factory.mktemp("screen")
    words = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-nolisten", "tcp", "-noreset"]
    words += ["-fbdir", str(memory)]
    with subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL) as server:
        os.close(write)
        with os.fdopen(read) as numbers:
            display = f":{numbers.readline().strip()}"
        yield Desk(display, memory / "Xvfb_screen0")
        server.terminate()


@pytest.fixture
def started(desk, tmp_path) -> Iterator[Callable[..., subprocess.Popen]]:
    """Starts Python with some code in a folder of its own."""
    running = []

    def start(code: str, *words: str) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", code, *words],
            cwd=tmp_path,
            env=desk.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        running.append(process)
        return process

    yield start
    for process in running:
        process.kill()
        process.communicate()


@pytest.fixture
def keep() -> Callable[[str, np.ndarray], None]:
    """Keeps a picture for people, under out/window."""
    folder = Path(__file__).parents[2] / "out" / "window"
    folder.mkdir(parents=True, exist_ok=True)

    def write(name: str, picture: np.ndarray) -> None:
        cv2.imwrite(str(folder / f"{name}.png"), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))

    return write
