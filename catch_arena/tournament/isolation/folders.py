"""Empties folders that strangers wrote to."""

import os
from collections.abc import Collection
from itertools import count
from pathlib import Path


def empty(folder: Path, keep: Collection[Path] = ()) -> None:
    """Remove all that is in a folder, however deep it lies and whatever its permissions are; links are not followed.

    Args:
        folder: nobody else writes to it any more.
        keep: folders in it that stay, with what others mounted there.

    Raises:
        OSError: for what cannot be removed.
    """
    places = [folder]
    while places:
        place = places.pop()
        for entry in list(os.scandir(place)):
            path = Path(entry.path)
            if path not in keep:
                _remove(path)
            elif not path.is_symlink() and not os.path.ismount(path):
                places.append(path)


def _remove(path: Path) -> None:
    """A folder's folders are moved up beside it first, so that no path becomes too long and nothing recurses."""
    if path.is_symlink() or not path.is_dir():
        path.unlink()
        return
    names = (path.with_name(f"removed.{number}") for number in count())
    free = (name for name in names if not os.path.lexists(name))
    folders = [path]
    while folders:
        path = folders.pop()
        path.chmod(0o700)
        for entry in list(os.scandir(path)):
            inner = Path(entry.path)
            if entry.is_dir(follow_symlinks=False):
                inner.chmod(0o700)  # else it cannot be moved
                folders.append(inner.rename(next(free)))
            else:
                inner.unlink()
        path.rmdir()
