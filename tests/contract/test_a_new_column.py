"""A new column costs as many files as docs/explanation/architecture.md says, tried in a copy of the package.

Moving targets have a ninth column there, the bodies that prey sees too, and rivals in teams a tenth, which is more than
one copy takes. All others are as they were.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import catch_arena

PACKAGE = Path(catch_arena.__file__).parent
ADDED = [
    ("layout.py", "class TargetFeatures", "    active", ["twice_age: Annotated[float, _Said('s', _any_part, 'new')]"]),
    ("core/features.py", "def target_seen", "        active", ["    twice_age=2.0 * target.age,"]),
    ("policy.py", "class SeenTarget", "    active", ["twice_age: float"]),
    (
        "layout.py",
        "class RivalFeatures",
        "    score_difference",
        [f"{name}: Annotated[float, _Said('1', _any_part, 'new')]" for name in ("half_velocity", "lead")],
    ),
    (
        "core/features.py",
        "def rival_seen",
        "        score_difference",
        ["    half_velocity=0.5 * rival.speed,", "    lead=me.score - rival.score,"],
    ),
    ("policy.py", "class SeenHunter", "    score_difference", ["half_velocity: float", "lead: float"]),
    (
        "layout.py",
        "class BodyFeatures",
        "    heading_cos",
        [f"{name}: Annotated[float, _Said('1', _any_part, 'new')]" for name in ("half_velocity", "nearness", "right")],
    ),
    (
        "core/features.py",
        "def body_seen",
        "        heading_cos=",
        ["    half_velocity=0.5 * body.speed,", "    nearness=-0.5 * forward,", "    right=-left,"],
    ),
    ("policy.py", "class SeenBody", "    heading_cos", ["half_velocity: float", "nearness: float", "right: float"]),
]
"""File, class or function, before which of its lines, and what is written there: all that columns take."""
MADE_OF = {
    "twice_age": ("age", 2.0),
    "half_velocity": ("linear_velocity", 0.5),
    "lead": ("score_difference", -1.0),
    "nearness": ("forward", -0.5),
    "right": ("left", -1.0),
}
"""Each of them is another column, so many times."""
PLAY = """
import sys
import numpy as np
import catch_arena
from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.layout import columns, prey_columns
from catch_arena.policy import player_limits

arenas = int(sys.argv[2])
common = dict(hunters=5, control="velocity", side_m=4.0, reach_m=0.6, target_motion="wander", initial_targets=5)
told = {"package": catch_arena.__file__}
for name, config in {
    "teams": ArenaConfig(**common, observed_hunters=3, teams=((0, 2), (1, 3, 4)), prey=3),
    "few": ArenaConfig(**common, observed_hunters=1, view_noise_m=0.1),
    "few_in_teams": ArenaConfig(**common, observed_hunters=1, teams=((0, 2), (1, 3, 4))),
    "alone": ArenaConfig(**common, observed_hunters=0),
}.items():
    engine = Engine(config, arenas)
    engine.reset(range(arenas))
    source, seen, seen_by_prey = np.random.default_rng(7), [], []
    for _ in range(20):
        commands = [source.uniform(-1.0, 1.0, (arenas, n, 2)).astype(np.float32) for n in (5, config.prey)]
        engine.step(np.zeros((arenas, 5), np.int64), np.concatenate(commands, axis=1))
        seen.append(engine.observations[:, :5, :len(columns(config))].copy())
        seen_by_prey.append(engine.observations[:, 5:, :len(prey_columns(config))].copy())
    for side, numbers, table in (("hunter", seen, columns(config)), ("prey", seen_by_prey, prey_columns(config))):
        names = [column.name for column in table]
        told |= {f"{name} {side}": np.array(numbers), f"{name} {side} names": np.array(names)}
        for seat, own in enumerate(numbers[-1][-1].tolist()):
            view = player_limits(config, seat + 5 * (side == "prey")).view(own, [])
            for kind in ("targets", "rivals", "hunters", "others"):
                for one in getattr(view, kind, ()):
                    before = f"{kind.removesuffix('s').replace('other', 'prey')}_{one.rank}."
                    columns_of_it = [number for column, number in zip(names, own) if column.startswith(before)]
                    assert columns_of_it.pop(2) == 1.0
                    assert list(one)[1 : 1 + len(columns_of_it)] == columns_of_it, one
np.savez(sys.argv[1], **told)
"""


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """Where the copy is."""
    folder = tmp_path_factory.mktemp("copied")
    copy = folder / PACKAGE.name
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for name, owner, before, lines in ADDED:
        text = (copy / name).read_text(encoding="utf-8")
        added = "".join(f"    {line}\n" for line in lines)
        text, found = re.subn(
            rf"(?ms)^({owner}\b.*?\n)(?={before})", lambda m, added=added: m[1] + added, text, count=1
        )
        assert found == 1, f"{name} has changed, and this test has to follow"
        (copy / name).write_text(text, encoding="utf-8")
    return folder


def played(sources, folder, arenas, *, compiled):
    """What hunters and prey see in arenas that are played by the package that lies there."""
    told = folder / "told.npz"
    environment = os.environ | {"PYTHONPATH": str(sources), "NUMBA_DISABLE_JIT": str(int(not compiled))}
    subprocess.run([sys.executable, "-c", PLAY, told, str(arenas)], env=environment, check=True, cwd=folder)
    with np.load(told) as file:
        found = dict(file)
    assert Path(str(found.pop("package"))).is_relative_to(sources)
    return found


@pytest.mark.parametrize(
    ("arenas", "compiled"),
    [
        pytest.param(1, False, id="one_interpreted"),
        pytest.param(9, False, id="nine_interpreted"),
        pytest.param(9, True, id="nine_compiled"),
    ],
)
def test_a_ninth_and_a_tenth_column_take_an_entry_a_value_and_a_name(copied, tmp_path, monkeypatch, arenas, compiled):
    before = played(PACKAGE.parent, tmp_path, arenas, compiled=compiled)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    after = played(copied, tmp_path, arenas, compiled=compiled)
    for match in ("teams hunter", "teams prey", "few hunter", "few_in_teams hunter", "alone hunter"):
        names, numbers = after[f"{match} names"].tolist(), after[match]
        old = [place for place, name in enumerate(names) if name.partition(".")[2] not in MADE_OF]
        assert [names[place] for place in old] == before[f"{match} names"].tolist()
        assert (numbers[..., old] == before[match]).all()
        assert len(old) < len(names)
        written = set()
        for place, name in enumerate(names):
            rank, _, column = name.partition(".")
            if place not in old:
                source, times = MADE_OF[column]
                assert (numbers[..., place] == times * numbers[..., names.index(f"{rank}.{source}")]).all(), name
                written |= {column} if numbers[..., place].any() else set()
        assert written == {names[place].partition(".")[2] for place in range(len(names)) if place not in old}
