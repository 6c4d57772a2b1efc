"""Set-up where something is missing: each failure says what to do, leaves nothing half made, and can be tried again."""

import ensurepip
import fcntl
import http.server
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SET_UP = ROOT / "scripts" / "set_up"
PYTHON = Path(sys.base_prefix) / "bin" / "python3"
WHEELS = Path(sysconfig.get_config_var("WHEEL_PKG_DIR") or Path(ensurepip.__file__).parent / "_bundled")
"""pip's own wheel, which Python carries, and Debian's in another place: an index of one package."""

ABSENT = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name in {modules!r}:
            raise {error}

sys.meta_path.insert(0, Absent())
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A folder with a project that needs a package which is nowhere."""
    (tmp_path / "pyproject.toml").write_text(
        '[project]\nname = "little"\nversion = "1"\ndependencies = ["numpy>=9999"]\n'
        '[dependency-groups]\nself = ["pip"]\nnone = ["there-is-no-such-package"]\n'
    )
    monkeypatch.chdir(tmp_path)
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(WHEELS))
    return tmp_path


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """One that was made before."""
    folder = tmp_path_factory.mktemp("made") / ".venv"
    subprocess.run([PYTHON, "-m", "venv", folder], check=True)
    return folder


def python_without(folder, *modules, error="ModuleNotFoundError(f'No module named {name!r}', name=name)"):
    """A Python that lacks some modules of its library, as Debian's does before python3-venv is installed."""
    (folder / "absent").mkdir()
    (folder / "absent" / "sitecustomize.py").write_text(ABSENT.format(modules=modules, error=error))
    stub = folder / "python-without"
    stub.write_text(f'#!/bin/sh\nPYTHONPATH={folder}/absent exec {PYTHON} "$@"\n')
    stub.chmod(0o755)
    return stub


def set_up(*words, python=PYTHON, environment=".venv"):
    return subprocess.run([python, SET_UP, environment, *words], capture_output=True, text=True, check=False)


def has_pip(environment):
    asked = subprocess.run([environment / "bin/python", "-m", "pip", "--version"], capture_output=True, check=False)
    return asked.returncode == 0


def test_a_debian_without_python3_venv_says_so_leaves_nothing_and_goes_on_when_it_is_there(project):
    stub = python_without(project, "ensurepip", "pip")
    for _ in range(2):  # the second run finds what the first one left: nothing
        failed = set_up("--group", "self", python=stub)
        assert failed.returncode == 1
        assert "cannot make a virtual environment: it lacks ensurepip" in failed.stderr
        assert "apt-get install python3-venv" in failed.stderr
        assert "Traceback" not in failed.stderr + failed.stdout
        assert not (project / ".venv").exists()
    assert set_up("--group", "self").returncode == 0  # python3-venv has been installed
    assert has_pip(project / ".venv")


def test_make_says_so_too_where_python_has_neither_venv_nor_pip(project):
    stub = python_without(project, "venv", "ensurepip", "pip")
    environment = project / "env"
    failed = subprocess.run(
        ["make", "-C", ROOT, "demo", f"PYTHON={stub}", f"VENV={environment}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert failed.returncode == 2
    assert "apt-get install python3-venv" in failed.stderr
    assert not environment.exists()


def test_where_python_has_a_pip_but_no_ensurepip_that_pip_fills_the_environment(project):
    done = set_up("--group", "self", python=python_without(project, "ensurepip"))
    assert done.returncode == 0, done.stderr
    assert has_pip(project / ".venv")


@pytest.fixture
def hasty(project):
    """A Python with an ensurepip that puts down a name and no pip: for what is not about pip."""
    (project / "hasty").mkdir()
    (project / "hasty" / "ensurepip.py").write_text(
        "import pathlib, sysconfig\n(pathlib.Path(sysconfig.get_path('purelib')) / 'pip.py').touch()\n"
    )
    stub = project / "python-hasty"
    stub.write_text(f'#!/bin/sh\nPYTHONPATH={project}/hasty exec {PYTHON} "$@"\n')
    stub.chmod(0o755)
    return stub


def test_it_says_that_an_environment_is_being_made_for_long(project, monkeypatch, capsys, parts):
    import environment

    del parts
    monkeypatch.setattr(environment, "TOLD_EVERY_S", 0.05)
    slow = project / "slow"
    slow.write_text("#!/bin/sh\nsleep 0.2\n")
    slow.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(slow))
    (project / ".venv").mkdir()
    with environment.alone_in(Path(".venv")) as made:
        made.make()
    told = capsys.readouterr().out
    assert "    0 s  making the folder\n" in told


@pytest.mark.parametrize("module", ["venv", "ensurepip"])
def test_a_full_disk_is_told_with_the_space_that_is_left_and_no_package_to_install(project, module):
    failed = set_up(python=python_without(project, module, "pip", error="OSError(28, 'No space left on device')"))
    assert failed.returncode == 1
    assert re.search(r"\.venv cannot be made: the disk is full: \.venv has \d+ MB left\n", failed.stderr)
    assert "apt-get" not in failed.stderr
    assert not (project / ".venv").exists()


def empty_environment(folder):
    """One without pip: what is there while pip is put into it, and what `uv venv` makes."""
    subprocess.run([PYTHON, "-m", "venv", "--without-pip", folder], check=True)
    return folder


def test_what_was_half_made_is_made_anew_and_left_alone_then(project, hasty):
    environment = empty_environment(project / ".venv")
    (environment / "set_up.began").touch()
    (environment / "bin" / "activate").unlink()
    made = set_up(python=hasty)
    assert ".venv is only half made; it is made anew" in made.stdout
    assert made.returncode == 0, made.stderr
    assert (environment / "bin" / "activate").exists()
    again = set_up(python=hasty)
    assert (again.returncode, again.stdout) == (0, "")


def test_what_was_moved_or_copied_is_made_anew(project, hasty, monkeypatch):
    (project / "one").mkdir()
    monkeypatch.chdir(project / "one")
    assert set_up(python=hasty).returncode == 0
    shutil.copytree(project / "one", project / "two", symlinks=True)
    monkeypatch.chdir(project / "two")
    anew = set_up(python=hasty)
    made = project / "one" / ".venv"
    assert f".venv was made as {made} for {made.parent}; it is made anew" in anew.stdout
    assert anew.returncode == 0, anew.stderr
    assert str(project / "two" / ".venv") in (project / "two" / ".venv" / "bin" / "activate").read_text()
    monkeypatch.chdir(project / "one")
    assert set_up(python=hasty).stdout == ""


def test_an_environment_whose_python_is_gone_is_made_anew(project, hasty):
    assert set_up(python=hasty).returncode == 0
    python = project / ".venv" / "bin" / "python"
    python.unlink()
    python.symlink_to(project / "nowhere")
    anew = set_up(python=hasty)
    assert ".venv has no Python with a pip that works" in anew.stdout
    assert anew.returncode == 0, anew.stderr
    assert python.exists()


@pytest.mark.parametrize("content", ["a file", "an environment without pip"])
def test_what_somebody_else_made_stays_as_it_is(project, content):
    environment = project / ".venv"
    environment.mkdir()
    if content == "an environment without pip":
        empty_environment(environment)
    (environment / "precious").write_text("mine")
    failed = set_up("--group", "self")
    assert failed.returncode == 1
    assert "It was not made by `make`, and is left as it is.\nMove it away, or name another folder:" in failed.stderr
    assert (environment / "precious").read_text() == "mine"


def test_an_environment_of_ones_own_is_used_until_it_is_moved(project, environment):
    own = project / "own"
    shutil.copytree(environment, own, symlinks=True)
    for mark in ("set_up.whole", "set_up.began"):
        (own / mark).unlink(missing_ok=True)
    used = set_up("--group", "self", environment="own")
    assert used.returncode == 0, used.stderr
    assert "making" not in used.stdout
    own.rename("elsewhere")
    moved = set_up("--group", "self", environment="elsewhere")
    assert moved.returncode == 1
    assert f"elsewhere was made as {own} for {project}. It was not made by `make`" in moved.stderr


def test_a_file_in_place_of_the_environment_is_named_as_one(project):
    (project / ".venv").write_text("mine")
    failed = set_up()
    assert failed.stderr.startswith(".venv is not a folder.\nMove it away")
    assert (project / ".venv").read_text() == "mine"


@pytest.fixture
def counted_make(tmp_path):
    """Runs `make setup` in a folder, with a set-up that only notes what it is asked: what that was."""
    environment, calls = tmp_path / "env", tmp_path / "calls"
    stub = tmp_path / "python"
    stub.write_text(
        f'#!/bin/sh\ncase "$1" in scripts/set_up) shift 2; echo "$@" >>{calls};; esac\n'
        f"mkdir -p {environment}; test -e {environment}/set_up.whole || echo >{environment}/set_up.whole\n"
    )
    stub.chmod(0o755)

    def make(folder=ROOT):
        calls.write_text("")
        subprocess.run(
            ["make", "-C", folder, "setup", f"PYTHON={stub}", f"VENV={environment}"], check=True, capture_output=True
        )
        return [line.partition(" --download")[0] for line in calls.read_text().splitlines()]

    return make


EVERYTHING = ["", "--extra video --compile", "--group test --group check"]


def test_make_installs_again_all_that_was_in_an_environment_that_was_made_anew(counted_make, tmp_path):
    assert counted_make() == EVERYTHING
    assert counted_make() == [""]
    (tmp_path / "env" / "set_up.whole").unlink()
    assert counted_make() == EVERYTHING


def test_files_that_are_dated_in_the_future_are_told_and_installed_once(counted_make, project, hasty):
    tomorrow = time.time() + 86400
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, project)
        os.utime(project / name, (tomorrow, tomorrow))
    assert counted_make(project) == EVERYTHING
    assert counted_make(project) == [""]
    (project / "pyproject.toml").write_text("changed when the clock was right again")
    os.utime(project / "pyproject.toml", (tomorrow + 1, tomorrow + 1))
    assert counted_make(project) == EVERYTHING
    told = set_up(python=hasty).stdout
    assert "Makefile is dated in the future. Is this machine's clock right?" in told


@pytest.mark.usefixtures("project")
def test_a_package_that_cannot_be_had_is_named_and_the_environment_stays(environment):
    failed = set_up("--group", "none", environment=environment)
    assert failed.returncode == 1
    assert "what `none` needs could not be installed" in failed.stderr
    assert "there-is-no-such-package" in failed.stderr
    assert "set_up.log" in failed.stderr
    again = set_up("--group", "self", environment=environment)
    assert again.returncode == 0, again.stderr
    assert "making" not in again.stdout


@pytest.mark.usefixtures("project")
def test_without_a_network_it_is_said_that_there_is_none(environment, monkeypatch):
    monkeypatch.delenv("PIP_NO_INDEX")
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))  # a port at which nobody listens
        monkeypatch.setenv("PIP_INDEX_URL", f"http://127.0.0.1:{nobody.getsockname()[1]}/simple")
        monkeypatch.setenv("PIP_RETRIES", "0")
        failed = set_up("--group", "none", environment=environment)
    assert failed.returncode == 1
    assert "the package index cannot be reached" in failed.stderr
    assert "goes on from here" in failed.stderr


class Index(http.server.BaseHTTPRequestHandler):
    """Answers of indexes that are none, by the first part of the path."""

    def do_GET(self):
        answer, *_, last = self.path.strip("/").split("/")
        if answer == "busy":
            self.send_error(503)
        elif answer == "login":
            self.answer("text/html", b"<!DOCTYPE html><html><body>Welcome! Your room number?</body></html>")
        elif last.endswith(".whl"):  # the line is cut
            self.answer("application/zip", b"PK", length=100_000)
        else:
            link = (
                b'<a href="there_is_no_such_package-1-py3-none-any.whl">there_is_no_such_package-1-py3-none-any.whl</a>'
            )
            self.answer("text/html", b"<!DOCTYPE html><html><body>" + link + b"</body></html>")

    def answer(self, kind, content, length=None):
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(length or len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *args):
        pass


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("busy", "the package index listed no there-is-no-such-package for this Python; "),
        (
            "login",
            "the package index listed no there-is-no-such-package for this Python; is a login page before it",
        ),
        ("cut", "what was downloaded .*is damaged; did the connection break off?"),
    ],
)
def test_an_index_that_answers_something_else_is_named(environment, monkeypatch, answer, words):
    monkeypatch.delenv("PIP_NO_INDEX")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Index) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        index = f"http://127.0.0.1:{server.server_port}/{answer}/simple"
        monkeypatch.setenv("PIP_INDEX_URL", index)
        failed = set_up("--group", "none", environment=environment)
        server.shutdown()
    assert failed.returncode == 1
    assert re.search(f"could not be installed: {words}", failed.stderr), failed.stderr
    if answer != "cut":
        assert f"Asked: {index}" in failed.stderr


@pytest.fixture
def silent(monkeypatch):
    """An index that takes a question, and never answers."""
    monkeypatch.delenv("PIP_NO_INDEX")
    with socket.create_server(("127.0.0.1", 0)) as index:
        index.settimeout(30)
        monkeypatch.setenv("PIP_INDEX_URL", f"http://127.0.0.1:{index.getsockname()[1]}/simple")
        yield index


def begin(environment, *words, python=PYTHON):
    return subprocess.Popen(
        [python, SET_UP, environment, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


@pytest.mark.parametrize(
    ("number", "send", "word"),
    [
        (signal.SIGINT, os.killpg, "interrupted"),
        (signal.SIGTERM, os.kill, "terminated"),
        (signal.SIGHUP, os.kill, "hung up"),
    ],
)
def test_a_signal_in_the_middle_of_pip_ends_with_one_line_and_pip_with_it(
    project, environment, silent, monkeypatch, number, send, word
):
    """Ctrl-C is for the whole process group, what `kill` sends for set-up alone. Where we are deaf to a signal
    ourselves, as under nohup, set-up would be, too.
    """
    scratch = project / "scratch"
    scratch.mkdir()
    monkeypatch.setenv("TMPDIR", str(scratch))
    former = signal.signal(number, signal.SIG_DFL)
    try:
        begun = begin(environment, "--group", "none")
    finally:
        signal.signal(number, former)
    asked, _ = silent.accept()
    with asked:
        send(begun.pid, number)
        _, said = begun.communicate(timeout=30)
    assert begun.returncode == 128 + number
    assert said == f"catch-arena: {word}: the same command goes on from here\n"
    assert list(scratch.iterdir()) == []
    assert ends(begun.pid)


def test_what_pip_runs_ends_with_it(project):
    """As what builds a package."""
    python = project / "env" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text('#!/bin/sh\ncase "$*" in *install*) sleep 300 & touch begun; wait;; esac\n')
    python.chmod(0o755)
    begun = begin("env", "--group", "none")
    while not (project / "begun").exists():
        time.sleep(0.01)
    begun.terminate()
    begun.communicate(timeout=30)
    assert ends(begun.pid)


def test_little_is_imported_before_set_up_hears_ctrl_c():
    asked = [PYTHON, "-S", "-X", "importtime", SET_UP, "--help"]  # without what this Python's packages import
    told = subprocess.run(asked, check=True, capture_output=True, text=True).stderr
    imported = re.findall(r"\| +(\S+)$", told, re.MULTILINE)
    heard = imported.index("catch_arena.interrupts")
    assert {"argparse", "pathlib", "subprocess", "tempfile"}.isdisjoint(imported[:heard])
    assert "argparse" in imported[heard:]


@pytest.mark.usefixtures("project")
def test_a_second_set_up_waits_for_the_first_and_for_a_pip_that_outlived_it(environment, silent):
    first = begin(environment, "--group", "none")
    asked, _ = silent.accept()
    with asked:
        first.kill()
        first.wait()
        second = begin(environment)
        try:
            assert "waiting: another set-up is at work in" in second.stdout.readline()
            assert second.poll() is None
        finally:
            os.killpg(first.pid, signal.SIGKILL)  # the pip
        second.communicate(timeout=30)
        first.communicate()
    assert second.returncode == 0


def test_a_set_up_whose_folder_the_first_removed_in_the_end_makes_it_anew(project, hasty):
    folder = project / ".venv"
    folder.mkdir()
    lock = os.open(folder, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    waiting = begin(".venv", python=hasty)
    assert "waiting" in waiting.stdout.readline()
    folder.rmdir()
    os.close(lock)
    waiting.communicate(timeout=60)
    assert waiting.returncode == 0
    assert (folder / "set_up.whole").exists()


def ends(group):
    """Whether no process of the group lives on."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.fixture
def parts(monkeypatch):
    """The modules of the set-up can be imported."""
    monkeypatch.syspath_prepend(str(SET_UP))
    yield
    for name in ("environment", "packages", "words"):
        sys.modules.pop(name, None)


@pytest.mark.usefixtures("parts")
def test_what_pip_says_of_a_full_disk_becomes_the_folder_and_the_space_that_is_left(tmp_path):
    from words import cause

    told = cause("ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device\n", tmp_path)
    free = shutil.disk_usage(tmp_path).free / 1e6
    assert told.startswith(f"the disk is full: {tmp_path} has ")
    assert abs(float(told.split(" has ")[1].split()[0]) - free) < 1000


@pytest.mark.usefixtures("parts")
def test_an_index_whose_versions_do_not_fit_is_not_taken_for_one_that_is_out_of_order():
    from words import cause

    told = cause(
        "ERROR: Could not find a version that satisfies the requirement numpy>=9999 (from versions: 2.1.0, 2.2.0)\n"
        "ERROR: No matching distribution found for numpy>=9999\n"
    )
    assert told == "the package index has no numpy>=9999 for this Python. Asked: PyPI"


@pytest.mark.usefixtures("parts")
def test_progress_counts_what_has_arrived_and_what_is_unpacked(tmp_path):
    from packages import Progress

    progress = Progress(tmp_path / "env", tmp_path)
    assert progress.words("") == "asking for packages"
    progress.hear("  Downloading numba-0.68.1-cp311-cp311-manylinux_2_28_x86_64.whl.metadata (2.7 kB)")
    assert progress.words("") == "asking for packages"  # newer pips fetch what it needs before the package itself
    progress.hear("  Downloading numba-0.68.1-cp311-cp311-manylinux_2_28_x86_64.whl (3.9 MB)")
    assert progress.words(", 2 of some 200 MB") == "1 package so far, 2 of some 200 MB; now numba (3.9 MB)"
    progress.hear("Processing /wheels/numpy-2.4.6-cp311-cp311-linux_x86_64.whl (from numba>=0.68)")
    assert progress.words("") == "2 packages so far; now numpy"
    (tmp_path / "pip-unpack-x1").mkdir()
    (tmp_path / "pip-unpack-x1" / "numba.whl").write_bytes(bytes(2_500_000))
    assert progress.received_mb() == 2.5
    progress.hear("Installing collected packages: numpy, numba")
    (tmp_path / "env/lib/python3.11/site-packages/numpy-2.4.6.dist-info").mkdir(parents=True)
    assert progress.words("") == "unpacking: 1 of 2 packages"


@pytest.mark.usefixtures("parts")
def test_an_older_pips_command_loses_its_import_of_re_and_a_newer_ones_is_left(tmp_path):
    from packages import quicken

    command = tmp_path / "catch-arena"
    newer = "#!/bin/python\nimport sys\nfrom it import main\nif __name__ == '__main__':\n{}    sys.exit(main())\n"
    older = newer.format("    sys.argv[0] = re.sub(r'(-script\\.pyw|\\.exe)?$', '', sys.argv[0])\n")
    command.write_text(older.replace("import sys", "import re\nimport sys"))
    quicken(command)
    assert command.read_text() == newer.format("")
    quicken(command)
    assert command.read_text() == newer.format("")


def test_little_is_imported_before_the_command_hears_ctrl_c():
    """Nothing of setuptools' finder nor of pip's command: a Ctrl-C meanwhile is a traceback."""
    plain = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
    command = Path(sys.executable).with_name("catch-arena")
    asked = [sys.executable, "-X", "importtime", command, "--version"]
    told = subprocess.run(asked, check=True, capture_output=True, text=True, env=plain).stderr
    imported = re.findall(r"\| +(\S+)$", told, re.MULTILINE)
    before = imported[: imported.index("catch_arena.interrupts")]
    assert "site" in before
    assert {"pathlib", "re"}.isdisjoint(before)


def test_git_ignores_what_the_examples_write(tmp_path):
    shutil.copy(ROOT / ".gitignore", tmp_path)
    subprocess.run(["git", "init", "--quiet", tmp_path], check=True)
    text = "\n".join(page.read_text() for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")))
    written = set(re.findall(r"^catch-arena .* (?:-o|--out) ([a-z]\S*)", text, re.MULTILINE))
    assert {"match.mp4", "results", "best.mp4"} <= written
    written.add("first.replay")
    for name in written:
        made = tmp_path / name if "." in name else tmp_path / name / "made"
        made.parent.mkdir(parents=True, exist_ok=True)
        made.touch()
    asked = ["git", "-C", tmp_path, "status", "--porcelain", "--untracked-files=all"]
    assert subprocess.run(asked, check=True, capture_output=True, text=True).stdout == "?? .gitignore\n"
