"""Builds the wheel of a release for Linux on x86-64: the ordinary one, with machine code of the core in it.

`make wheel` builds from the last commit, into dist/. `python scripts/wheel --verify WHEEL` builds once more, and names
each file of WHEEL that does not come out the same; the versions with which it was made stand in its manifest.
"""

import argparse
import base64
import hashlib
import io
import os
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TAG = "py3-none-manylinux_2_17_x86_64"
"""Any Python: the code knows none. Any Linux: of the C library it asks at most for memcpy and its kin."""
PLACE = "catch_arena/engine/machine_code"
DATE = (1980, 1, 1, 0, 0, 0)
"""Of each file, so that two builds are equal."""


def main() -> None:
    """Build, or build and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", default="HEAD", help="what is built (default: HEAD)")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="the folder for the wheel (default: dist)")
    parser.add_argument("--verify", type=Path, metavar="WHEEL", help="compare this one, and write nothing")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        name, files = built(given.commit, Path(folder))
    if given.verify:
        compare(given.verify, files)
    else:
        given.out.mkdir(parents=True, exist_ok=True)
        write(given.out / name, files)
        print(f"{given.out / name}: {(given.out / name).stat().st_size / 1e6:.1f} MB")


def built(commit: str, folder: Path) -> tuple[str, dict[str, bytes]]:
    """The wheel's name, and all its files but RECORD, made in that folder from that commit alone."""
    source, pure, code = folder / "source", folder / "pure", folder / "code"
    archive = subprocess.run(["git", "-C", ROOT, "archive", commit], check=True, stdout=subprocess.PIPE).stdout  # noqa: S607
    with tarfile.open(fileobj=io.BytesIO(archive)) as sources:
        sources.extractall(source, filter="data")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", pure, source], check=True)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "PYTHON"))}
    # -P: not the sources beside this script, but those of the commit
    program = [sys.executable, "-P", source / "scripts/wheel/object_files.py", code]
    environment |= {"PYTHONPATH": str(source), "PYTHONHASHSEED": "0", "NUMBA_CACHE_DIR": str(folder / "cache")}
    subprocess.run(program, check=True, cwd=source, env=environment)
    (wheel,) = pure.iterdir()
    files = contents(wheel)
    about = next(name for name in files if name.endswith(".dist-info/WHEEL"))
    files[about] = (
        files[about].replace(b"Root-Is-Purelib: true", b"Root-Is-Purelib: false").replace(b"py3-none-any", TAG.encode())
    )
    files |= {f"{PLACE}/{made.name}": made.read_bytes() for made in code.iterdir()}
    return wheel.name.replace("py3-none-any", TAG), files


def contents(wheel: Path) -> dict[str, bytes]:
    """A wheel's files, without the list of them."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith(".dist-info/RECORD")}


def write(wheel: Path, files: dict[str, bytes]) -> None:
    """The files in one order, what describes them last, as the format recommends."""
    ordered = sorted(files, key=lambda name: (".dist-info/" in name, name))
    record = next(name for name in files if name.endswith(".dist-info/WHEEL")).replace("WHEEL", "RECORD")
    lines = []
    for name in ordered:
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={digest},{len(files[name])}\n")
    everything = {**files, record: "".join([*lines, f"{record},,\n"]).encode()}
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in [*ordered, record]:
            entry = zipfile.ZipInfo(name, DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, everything[name], zipfile.ZIP_DEFLATED)


def compare(wheel: Path, files: dict[str, bytes]) -> None:
    """End with the names of the files that differ, if any do."""
    given = contents(wheel)
    different = [name for name in sorted({*files, *given}) if files.get(name) != given.get(name)]
    if different:
        sys.exit(f"{wheel} is not what these sources make here: {', '.join(different)}")
    with tempfile.TemporaryDirectory() as folder:
        again = Path(folder) / wheel.name
        write(again, files)
        packed = "byte for byte" if again.read_bytes() == wheel.read_bytes() else "compressed by another zlib"
    print(f"{wheel}: all {len(files)} files are what these sources make, {packed}")


if __name__ == "__main__":
    main()
