"""Files appear whole or not at all, with the permissions that a user asks for."""

import os
import stat

import pytest

from catch_arena.errors import OutputError
from catch_arena.files import unfinished_file, write_whole


@pytest.fixture(params=[0o022, 0o077, 0o002])
def umask(request):
    before = os.umask(request.param)
    yield request.param
    os.umask(before)


def test_a_new_file_has_the_permissions_that_the_umask_leaves(tmp_path, umask):
    write_whole(tmp_path / "new", b"new")
    write_whole(tmp_path / "own", b"own", private=True)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes == {"new": 0o666 & ~umask, "own": 0o600}


@pytest.mark.usefixtures("umask")
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666, 0o444])
def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path, mode):
    for name in ("file", "own"):
        (tmp_path / name).touch()
        (tmp_path / name).chmod(mode)
        write_whole(tmp_path / name, b"new", private=name == "own")
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes == {"file": mode, "own": 0o600}


def test_a_name_may_be_as_long_as_the_disk_allows(tmp_path):
    path = tmp_path / (255 * "x")
    write_whole(path, b"content")
    assert path.read_bytes() == b"content"
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        write_whole(tmp_path / (256 * "x"), b"content")
    assert list(tmp_path.iterdir()) == [path]


def test_ctrl_c_while_the_unfinished_file_is_made_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(_file):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("catch_arena.files.os.close", interrupted)
        with pytest.raises(KeyboardInterrupt), unfinished_file(tmp_path / "out.gif"):
            pytest.fail("it was not made")
    assert list(tmp_path.iterdir()) == []
