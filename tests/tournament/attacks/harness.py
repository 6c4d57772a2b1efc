"""One attack: an agent that tries it, in a real tournament against one that knows a secret.

Attackers know all that could be guessed, such as where the rival's files and the store are.
"""

import inspect
import json
import os
import re
import secrets
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from tournament.attacks import kit
from tournament.attacks.world import Outcome, World

import catch_arena
from catch_arena.descendants import family, kill_all

LONG_SEED: Final = "12345678901234567890"
"""One that nobody guesses."""
_PATIENCE_S: Final = 120.0
"""How long a tournament may take that plays two matches of four steps."""
_END_S: Final = 10.0
"""How long processes may take to end that a tournament has left."""
_USUAL: Final = {"init_s": 60, "step_ms": 60_000, "log_kib": 1024}
"""A busy machine must not make anybody late, and one that tries much has much to say."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Attack:
    """What is tried, and what each level of isolation makes of it."""

    run: Callable[[Any], None]
    """The attacker's second move of each match; its name says what it tries."""
    succeeded: Callable[[Outcome], bool]
    processes: str
    namespaces: str
    accomplice: Callable[[Any], None] | None = None
    """What the rival does, where it is in league with the attacker."""
    at_import: Callable[[], None] | None = None
    """What the attacker's module does when it is imported."""
    limits: Mapping[str, float] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    """More of the command line."""
    rounds: int = 1
    file: str = "attacker/attacker.py"
    """The attacker's, among the hand-ins; the rival's is rival/rival.py."""
    spec: str = ""
    """How the attacker is named on the command line; else by its file."""
    together: str = ""
    """Attacks with the same word here leave each other alone: one agent tries them all, move by move."""
    graded: bool = False
    """Whether it plays by a spec, and not against the rival."""
    links: Mapping[str, str] = field(default_factory=dict)
    """In the attacker's folder: names, and where they lead to, from the folder of all."""
    alone: bool = False
    """Whether the command is started anew, so that its command line is its own."""
    counted: bytes = b""
    """Part of the command lines of processes that are counted while it plays."""

    @property
    def name(self) -> str:
        """A sentence."""
        return self.run.__name__.replace("_", " ")


class Host:
    """A process that runs tournaments (host.py). Use it as a context manager."""

    def __init__(self) -> None:
        self.secret = f"SECRET-{secrets.token_hex(16)}"
        """In the environment of the tournaments."""
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("host.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PASSWORD": self.secret, "PYTHONPATH": str(Path(catch_arena.__file__).parents[1])},
        )
        assert self._process.stdout.readline() == "ready\n"

    def __enter__(self) -> "Host":
        return self

    def __exit__(self, *_: object) -> None:
        kill_all(lambda: family(self._process.pid))
        with self._process:
            self._process.stdin.close()

    def attempt(self, attack: Attack, level: str, folder: Path, *, also: Sequence[Attack] = ()) -> Outcome:
        """Play a tournament of the attacker and its rival at that level.

        Args:
            attack: what is tried.
            level: of isolation.
            folder: for all files, made here.
            also: what is tried besides, by the same agent, in later moves, under the options of `attack`.
        """
        world = World(folder)
        with socket.create_server(("127.0.0.1", 0)) as outside:
            facts = {
                "tests": self._process.pid,
                "process tree": os.readlink("/proc/self/ns/pid"),
                "port": outside.getsockname()[1],
                "free port": _free_port(),
                "token": secrets.token_hex(8),
                "number": secrets.randbits(30) + 1,
                "real home": str(Path.home()),
                **{name: str(getattr(world, name)) for name in ("folder", "out", "rival", "home", "packages", "spec")},
            }
            attacker = world.rival.parent / attack.file
            attacker.parent.mkdir(exist_ok=True)
            all_of_them = [attack, *also]
            tried = [one.run for one in all_of_them]
            attacker.write_text(_source(tried, facts, [one.at_import for one in all_of_them if one.at_import]))
            for name, place in attack.links.items():
                (attacker.parent / name).symlink_to(world.folder / place)
            if attack.accomplice is not None:
                accomplices = [one.accomplice for one in all_of_them]
                (world.rival / "rival.py").write_text(_source(accomplices, facts))
            before = world.files()
            code, most = self._run(_words(attack, level, attacker, world, moves=2 + len(tried)), world, attack)
            left = self._clear()
            received = _received(outside)
        _clear_places(facts)
        after = world.files()
        outcome = Outcome(
            world=world,
            code=code,
            secrets=[world.secret, self.secret, *(word for word in attack.words if word == LONG_SEED)],
            changes=[path for path in before.keys() | after.keys() if before.get(path) != after.get(path)],
            left=left,
            most=most,
            received=received,
            matches=0 if attack.graded else 2 * attack.rounds,
        )
        outcome.left += _clear_scratch(outcome.said)
        return outcome

    def _run(self, words: list[str], world: World, attack: Attack) -> tuple[int, int]:
        """The exit code, and the most processes that were counted at once."""
        folders = {name: str(getattr(world, name)) for name in ("folder", "printed", "packages")}
        self._process.stdin.write(json.dumps({"words": words, "alone": attack.alone, **folders}) + "\n")
        self._process.stdin.flush()
        patience, most = time.monotonic() + _PATIENCE_S, 0
        while not select.select([self._process.stdout], [], [], 0.02)[0]:
            if attack.counted:
                most = max(most, sum(attack.counted in _command_line(pid) for pid in family(self._process.pid)))
            if time.monotonic() > patience:
                kill_all(lambda: family(self._process.pid))
        return int(self._process.stdout.readline()), most

    def _clear(self) -> list[str]:
        """Wait for all processes to end, and end what does not: their command lines."""
        patience = time.monotonic() + _END_S
        while (left := family(self._process.pid)) and time.monotonic() < patience:
            time.sleep(0.005)
        lines = [_command_line(pid).decode(errors="replace") for pid in left]
        kill_all(lambda: family(self._process.pid))
        return lines


def _source(
    tried: Sequence[Callable[[Any], None]], facts: Mapping[str, Any], at_import: Sequence[Callable[[], None]] = ()
) -> str:
    """The text of an agent's file: what all have, the attacks of these kinds, and which of them it tries."""
    texts = dict.fromkeys(inspect.getsource(inspect.getmodule(one)) for one in tried)
    return "\n\n".join(
        [
            inspect.getsource(kit),
            *(re.sub(r"^from tournament.* import .*\n", "", text, flags=re.MULTILINE) for text in texts),
            f"FACTS.update({dict(facts)!r})",
            f"ATTACKS += [{', '.join(one.__name__ for one in tried)}]",
            *(f"{one.__name__}()" for one in at_import),
        ]
    )


def _words(attack: Attack, level: str, attacker: Path, world: World, moves: int) -> list[str]:
    limits = [word for name, value in (_USUAL | attack.limits).items() for word in ("--limit", f"{name}={value}")]
    named = attack.spec or str(attacker)
    if attack.graded:
        return ["grade", named, "--spec", str(world.spec), "--isolation", level, *limits]
    return [
        *("tournament", named, str(world.rival / "rival.py"), "--scenario", "duel", "--jobs", "1"),
        *("--set", f"time_limit_s={moves / 10}", "--rounds", str(attack.rounds), "--record", "--out", str(world.out)),
        *("--isolation", level, *limits, *attack.words),
    ]


def _command_line(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:  # it has just ended
        return b""


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def _received(outside: socket.socket) -> bytes:
    """What somebody has sent to the world."""
    outside.setblocking(False)
    try:
        connection, _ = outside.accept()
    except BlockingIOError:
        return b""
    with connection:
        connection.settimeout(5)
        return connection.recv(4096)


def _clear_places(facts: Mapping[str, Any]) -> None:
    """Remove what attackers may have left where everybody may write."""
    for place in ("/tmp", "/dev/shm", Path.home()):
        Path(place, facts["token"]).unlink(missing_ok=True)
    subprocess.run(["ipcrm", "-M", str(facts["number"])], check=False, capture_output=True)


def _clear_scratch(said: str) -> list[str]:
    """The folders that agents worked in and that are still there; they are removed."""
    left = []
    for place in sorted(set(re.findall(r"^works in (/tmp/catch-arena-agents-\w+)/", said, re.MULTILINE))):
        if Path(place).exists():
            left.append(place)
            subprocess.run(["chattr", "-R", "-i", place], check=False, capture_output=True)
            subprocess.run(["rm", "-rf", "--one-file-system", place], check=True)
    return left
