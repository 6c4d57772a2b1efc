"""Files that appear whole or not at all."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from catch_arena.errors import OutputError


def regular_file(path: Path) -> Path:
    """Where a file of that name is or would be, links followed. Raises: OutputError for a device or a folder."""
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise OutputError(f"{path}: cannot be written: is not a regular file")
    return target


def write_whole(path: Path, content: bytes) -> None:
    """Write a file of this content: whoever looks finds it whole or not at all. Raises: OutputError."""
    with whole_file(path) as file:
        file.write(content)


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """A file under a temporary name, which is renamed when all has been written. Raises: OutputError."""
    target = regular_file(path)
    try:
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}.", delete=False) as file:
            try:
                yield file
                file.flush()
                Path(file.name).chmod(0o644)
                Path(file.name).replace(target)
            except BaseException:
                Path(file.name).unlink(missing_ok=True)
                raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
