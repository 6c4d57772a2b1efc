"""The files of one attempt, and what came of it. What an attacker must find out or do is held here."""

import hashlib
import re
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from catch_arena.errors import StoreError
from catch_arena.tournament.store import Store

_DIGEST_BYTES: Final = 16
_SECRET_DIGITS: Final = 16
"""A seed of so many characters was not guessed."""
_SPEC: Final = """
title = "All that is asked"
seed_file = "hidden_seeds.txt"

[[test]]
name = "plays"
scenario = "duel"
settings = {time_limit_s = 0.4}
opponents = ["idle"]
"""
_RIVAL: Final = '''"""Plays for the nearest target, and knows a secret."""

from pathlib import Path


class Agent:
    def reset(self, seed):
        self.secret = (Path(__file__).parent / "rival_weights.txt").read_text()
        Path("notes.txt").write_text(self.secret)
        print("thinks of", self.secret, flush=True)

    def act(self, view):
        if Path("notes.txt").read_text() != self.secret:
            raise RuntimeError("somebody changed my notes")
        return 1
'''


@dataclass(slots=True)
class World:
    """The files of one attempt."""

    folder: Path
    secret: str = field(default_factory=lambda: f"SECRET-{secrets.token_hex(16)}")

    def __post_init__(self) -> None:
        for path in (self.rival, self.home, self.packages):
            path.mkdir(parents=True)
        (self.rival / "rival.py").write_text(_RIVAL)
        (self.rival / "rival_weights.txt").write_text(self.secret)
        (self.rival / "notes_of_nobody.txt").write_text(self.secret)
        self.spec.write_text(f"# {self.secret}\n{_SPEC}")
        self.spec.with_name("hidden_seeds.txt").write_text("1234567890123456789\n")
        (self.home / "key").write_text(self.secret)
        (self.home / "key").chmod(0o600)

    @property
    def out(self) -> Path:
        """The tournament's folder."""
        return self.folder / "out"

    @property
    def printed(self) -> Path:
        """What the command prints."""
        return self.folder / "printed"

    @property
    def rival(self) -> Path:
        """Where the rival's files are."""
        return self.folder / "hand_ins" / "rival"

    @property
    def spec(self) -> Path:
        """By which attackers are graded, where they are; it lies beside theirs."""
        return self.folder / "hand_ins" / "exercise.toml"

    @property
    def home(self) -> Path:
        """Stands for the user's own files."""
        return self.folder / "home"

    @property
    def packages(self) -> Path:
        """Stands for a folder that Python imports from."""
        return self.folder / "packages"

    def files(self) -> dict[Path, tuple[bytes, int]]:
        """What stands in all files that are not the tournament's, and who may read them."""
        paths = [path for room in (self.rival.parent, self.home, self.packages) for path in room.rglob("*")]
        return {path: (path.read_bytes(), path.stat().st_mode) for path in paths if path.is_file()}


@dataclass(slots=True)
class Outcome:
    """What came of a tournament with an attacker in it."""

    world: World
    code: int
    """The command's exit code."""
    secrets: list[str]
    """What nobody may find out."""
    changes: list[Path]
    """Files that are not what they were, but for the tournament's own."""
    left: list[str]
    """What outlived the tournament: command lines of processes, and folders."""
    most: int
    """How many processes lived at once that were to be counted."""
    received: bytes
    """What came to the world outside, by network."""
    matches: int
    """How many there should be."""
    played: Mapping[str, Sequence[str | None]] = field(default_factory=dict)
    """By name: the code of its forfeit in each match that was kept, or None."""
    tried: str = ""
    """The attack that is asked about, where several were tried."""

    def __post_init__(self) -> None:
        """Read the store, if it can be read."""
        out = self.world.out
        try:
            with Store.read(out) as store:
                names = [entrant.name for entrant in store.tournament.entrants]
                played = list(store.played())
        except StoreError:
            return
        self.secrets += [str(one.match.seed) for one in played]
        if self.code == 0:
            seeds = re.findall(r'"seed": "?(\w+)', (out / "standings.json").read_text())
            self.secrets += [seed for seed in seeds if len(seed) >= _SECRET_DIGITS]  # others can be guessed
        self.played = {name: [] for name in names}
        for one in played:
            for index, code in zip(one.match.seating, one.result.forfeits, strict=True):
                self.played[names[index]].append(code)
            replay = out / "replays" / f"{one.match.id}.replay"
            if hashlib.blake2b(replay.read_bytes(), digest_size=_DIGEST_BYTES).hexdigest() != one.replay:
                self.changes.append(replay)

    @property
    def printed(self) -> str:
        """What came to the terminal."""
        return self.world.printed.read_bytes().decode(errors="replace")

    @property
    def said(self) -> str:
        """The attacker's log; where it was graded, what the teacher is shown."""
        log = self._log("attacker") if self.matches else self.printed
        if not self.tried:
            return log
        parts = re.findall(rf"^tries {self.tried}\n(.*?)(?=^tries |^== |\Z)", log, re.MULTILINE | re.DOTALL)
        return "".join(parts)

    @property
    def rival_said(self) -> str:
        """The rival's."""
        return self._log("rival")

    @property
    def broken(self) -> bool:
        """Whether the tournament did not end as it should have for everybody but the attacker."""
        rival = self.played.get("rival", ())
        failed = self.code not in ({0} if self.matches else {0, 1})  # a grade may be bad
        return failed or len(rival) != self.matches or any(rival) or bool(self.left)

    def __str__(self) -> str:
        """For whoever reads why a test failed."""
        return (
            f"exit code {self.code}, {self.played}, changes {self.changes}, left {self.left}, most {self.most}\n"
            f"-- the attacker said\n{self.said[:4000]}\n-- the command said\n{self.printed[-4000:]}"
        )

    def _log(self, name: str) -> str:
        paths = (self.world.out / "logs").glob(f"*{name}.log")
        return "".join(path.read_bytes().decode(errors="replace") for path in paths)
