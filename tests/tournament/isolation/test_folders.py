"""A folder that strangers wrote to is emptied, whatever they made of it."""

import os
from pathlib import Path

from catch_arena.tournament.isolation.folders import empty


def test_nothing_is_left_however_deep_and_whatever_its_permissions(tmp_path):
    folder = tmp_path / "play"
    folder.mkdir()
    here = Path.cwd()
    os.chdir(folder)
    for _ in range(3000):  # a path longer than any that the system takes
        Path("deep").mkdir()
        os.chdir("deep")
    os.chdir(here)
    closed = folder / "closed" / "inner"
    closed.mkdir(parents=True)
    (closed / "file").touch()
    closed.chmod(0)
    closed.parent.chmod(0)
    (folder / "removed.0").mkdir()
    (folder / "removed.1").touch()
    (folder / ("x" * 255)).mkdir()
    (folder / "\udcff\n").touch()
    os.mkfifo(folder / "fifo")
    empty(folder)
    assert not list(folder.iterdir())


def test_links_are_not_followed(tmp_path):
    other = tmp_path / "other"
    other.mkdir(mode=0o500)
    (tmp_path / "play").mkdir()
    (tmp_path / "play" / "link").symlink_to(other)
    (tmp_path / "play" / "inner").mkdir()
    (tmp_path / "play" / "inner" / "link").symlink_to(other)
    empty(tmp_path / "play")
    assert other.stat().st_mode & 0o777 == 0o500


def test_what_is_to_be_kept_stays_without_what_was_put_there(tmp_path):
    (tmp_path / "way" / "to").mkdir(parents=True)
    (tmp_path / "way" / "new").touch()
    (tmp_path / "way" / "to" / "new").mkdir()
    empty(tmp_path, [tmp_path / "way", tmp_path / "way" / "to"])
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["to", "way"]
