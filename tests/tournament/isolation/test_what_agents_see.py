"""An agent in namespaces sees only its own files, processes and network; docs/howto/isolation.md says so."""

import json
import os
import re
import secrets
import shutil
import socket
import sys
from pathlib import Path

import pytest
from isolation_levels import LEVELS, NAMESPACES

from catch_arena import scenario
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter

DOCS = Path(__file__).parents[3] / "docs" / "howto" / "isolation.md"
SHORT = scenario("duel", time_limit_s=1)
FREE = {"init_s": 60, "step_ms": 60_000}
ASKS = """
import ctypes, json, os, resource, socket
from pathlib import Path

HERE = Path(__file__).parent

def answer(question):
    try:
        return eval(question)
    except Exception as error:
        return f"{type(error).__name__}: {error}"

class Agent:
    def reset(self, seed):
        questions = json.loads((HERE / f"{Path(__file__).stem}.json").read_text())
        print(json.dumps([answer(one) for one in questions], default=str))

    def act(self, view):
        return 0
"""


@pytest.fixture(params=LEVELS)
def sandbox(request):
    with Sandbox(Quotas(isolation=request.param, **FREE)) as made:
        yield made


@pytest.fixture
def evaluate(tmp_path):
    """Function that evaluates Python expressions in an agent's process; the agent's file is alone in a folder."""

    def found(sandbox, *questions, matches=1):
        folder = tmp_path / "its_folder"
        folder.mkdir(exist_ok=True)
        (folder / "asks.py").write_text(ASKS)
        (folder / "asks.json").write_text(json.dumps(questions))
        entrants = enter([str(folder / "asks.py"), "idle"], sandbox)
        for _ in range(matches):
            result = play_entrants(SHORT, 1, entrants, sandbox)
            assert result.forfeit_codes == (None, None), result.forfeits
        return json.loads(result.logs[0])

    return found


def in_namespaces(sandbox):
    return sandbox.quotas.isolation == "namespaces"


def test_it_sees_its_own_processes_only(sandbox, evaluate):
    numbers, parents = evaluate(sandbox, "[int(n) for n in os.listdir('/proc') if n.isdigit()]", "os.getppid()")
    if in_namespaces(sandbox):
        assert (len(numbers), parents) == (3, 2)
    else:
        assert os.getpid() in numbers


@pytest.mark.parametrize("place", ["/tmp", "/var/tmp", str(Path.home()), sys.prefix, "Zoë Müller", "a link"])  # noqa: S108
@pytest.mark.parametrize("form", ["file", "folder"])
def test_an_agent_plays_from_any_place_with_what_is_its_own(sandbox, tmp_path, place, form):
    folder = Path(place) if place.startswith("/") else tmp_path / place
    folder.mkdir(exist_ok=True)
    name = f"catch_arena_test_{secrets.token_hex(8)}"
    own = folder / name if form == "folder" else folder / f"{name}.py"
    weights = own / "weights.npz" if form == "folder" else folder / f"{name}.npz"
    target = tmp_path / "target" if place == "a link" else own
    try:
        if form == "folder":
            target.mkdir()
        (target / "agent.py" if form == "folder" else target).write_text(
            "from pathlib import Path\nclass Agent:\n    def reset(self, seed): pass\n"
            f"    def act(self, view): return len(Path({str(weights)!r}).read_bytes())\n"
        )
        if place == "a link":
            own.symlink_to(target)
        weights.write_bytes(b"1")
        entrants = enter([str(own), "idle"], sandbox)
        assert (entrants[0].name, entrants[0].fault) == (name, None)
        assert play_entrants(SHORT, 1, entrants, sandbox).forfeit_codes == (None, None)
    finally:
        shutil.rmtree(own, ignore_errors=True) if form == "folder" and place != "a link" else own.unlink()
        if form == "file":
            weights.unlink()


def test_other_files_in_the_folder_of_the_virtual_environment_are_hidden(sandbox, evaluate, tmp_path, monkeypatch):
    """As after `python -m venv .` in the folder with the agents."""
    (tmp_path / "pyvenv.cfg").write_text("")
    (tmp_path / "lib").mkdir()
    (tmp_path / "other.py").write_text("secret")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    (seen,) = evaluate(sandbox, f"sorted(os.listdir({str(tmp_path)!r}))")
    if in_namespaces(sandbox):
        assert "other.py" not in seen
        assert {"lib", "pyvenv.cfg"} <= set(seen)
    else:
        assert "other.py" in seen


def test_it_reaches_nobody_over_a_network(sandbox, evaluate):
    with socket.create_server(("127.0.0.1", 0)) as tcp, socket.socket(socket.AF_UNIX) as named:
        name = f"\0catch-arena-test-{os.getpid()}"
        named.bind(name)
        named.listen()
        port = tcp.getsockname()[1]
        reached = evaluate(
            sandbox,
            f"socket.create_connection(('127.0.0.1', {port})) and 'reached'",
            f"socket.socket(socket.AF_UNIX).connect({name!r}) or 'reached'",
            "[name for _, name in socket.if_nameindex()]",
        )
    if in_namespaces(sandbox):
        assert "Connection refused" in reached[0]
        assert "Connection refused" in reached[1]
        assert reached[2] == ["lo"]
    else:  # docs/howto/isolation.md says so
        assert reached[:2] == ["reached", "reached"]


def test_its_files_can_be_read_and_in_namespaces_not_be_written(sandbox, evaluate, tmp_path):
    (tmp_path / "exam.toml").write_text("secret")
    own, write, above, system = evaluate(
        sandbox,
        "sorted(os.listdir(HERE))",
        "Path(__file__).write_text('x')",
        "(HERE.parent / 'exam.toml').read_text()",
        "Path('/etc/passwd').exists()",
    )
    assert own == ["asks.json", "asks.py"]
    if in_namespaces(sandbox):
        assert "Read-only file system" in write or "Permission denied" in write
        assert "No such file" in above
        assert system is False
    else:
        assert (write, above, system) == (1, "secret", True)


def test_its_environment_holds_nothing_of_ours(sandbox, evaluate, monkeypatch):
    """But which instructions NumPy uses: by others a sum has other last bits, and a network would play otherwise."""
    monkeypatch.setenv("SECRET", "1")
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Haswell")
    names, core, parents = evaluate(
        sandbox,
        "sorted(os.environ)",
        "os.environ['OPENBLAS_CORETYPE']",
        "'SECRET' in Path('/proc/1/environ').read_text()",
    )
    assert "SECRET" not in names
    assert core == "Haswell"
    assert set(names) >= {"HOME", "PATH", "TMPDIR"}
    if in_namespaces(sandbox) and os.getuid():
        assert "Permission denied" in parents


@pytest.mark.parametrize("level", NAMESPACES)
def test_it_has_no_privileges(level, evaluate):
    with Sandbox(Quotas(isolation=level, **FREE)) as sandbox:
        privileges, new_user = evaluate(
            sandbox,
            "ctypes.CDLL(None).prctl(39, 0, 0, 0, 0)",  # PR_GET_NO_NEW_PRIVS
            "ctypes.CDLL(None).unshare(0x10000000)",  # CLONE_NEWUSER
        )
    assert (privileges, new_user) == (1, -1)


@pytest.mark.parametrize("level", NAMESPACES)
def test_what_it_writes_is_bounded_and_gone_with_the_match(level, evaluate):
    """In both of its folders, whatever it makes there; at the next match, nothing is found."""
    with Sandbox(Quotas(isolation=level, file_mib=2, **FREE)) as sandbox:
        before, *full, _ = evaluate(
            sandbox,
            "[[str(path) for path in Path(place).rglob('*')] for place in ('/tmp/.match', '/dev/shm')]",
            "[Path(f'/tmp/.match/{n}').write_bytes(bytes(1 << 20)) for n in range(3)]",
            "[Path(f'/dev/shm/{n}').write_bytes(bytes(1 << 20)) for n in range(3)]",
            "(os.makedirs('/tmp/.match/a/b'), os.chmod('/tmp/.match/a', 0), Path('/tmp/x').touch())",
            matches=2,
        )
    assert before == [[], []]
    assert all("No space left on device" in one for one in full)


@pytest.mark.parametrize("level", NAMESPACES)
def test_a_hand_in_that_vanishes_forfeits_and_the_other_plays_on(level, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 0\n")
    with Sandbox(Quotas(isolation=level, **FREE)) as sandbox:
        entrants = enter([str(path), "idle"], sandbox)
        path.unlink()
        result = play_entrants(SHORT, 1, entrants, sandbox)
    assert result.forfeit_codes == ("FORFEIT_INIT", None)
    assert "No such file or directory" in result.forfeits[0].reason


def test_a_command_in_another_language_plays_as_pythons_nearest_does(sandbox, tmp_path):
    """The example in POSIX shell of docs/howto/other_languages.md."""
    (script,) = re.findall(
        r"```sh file=bot.sh\n(while .*?)```", (DOCS.parent / "other_languages.md").read_text(), re.DOTALL
    )
    (tmp_path / "bot.sh").write_text(script)
    config = scenario("duel", time_limit_s=10)
    results = []
    for spec in (f"cmd:sh {tmp_path}/bot.sh", "nearest"):
        entrants = enter([spec, "idle"], sandbox)
        results.append(play_entrants(config, 1, entrants, sandbox))
    assert results[0] == results[1]
    assert results[0].scores[0] > 0
