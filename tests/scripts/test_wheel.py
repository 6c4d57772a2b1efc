"""The wheel of a release: built from the last commit, installed into an environment of its own, and played with: its
machine code gives the bits that the compiler gives, on each level that this processor has, and nothing is compiled.
"""

import importlib.util
import json
import os
import platform
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FIRST_STEPS = """
import numpy as np
from numba.core import event

class Heard(event.Listener):
    def on_start(self, event):
        compiled.append(event.data["dispatcher"].py_func.__name__)
    def on_end(self, event):
        pass

compiled = []
with event.install_listener("numba:compile", Heard()):
    import catch_arena
    for scenario in (catch_arena.scenario("standard"), catch_arena.scenario("fog", control="target")):
        env = catch_arena.parallel_env(scenario)
        env.reset(seed=1)
        env.step(dict.fromkeys(env.agents, 1))
        arena = catch_arena.VectorArena(scenario, 64)
        arena.reset(range(64))
        arena.step(np.ones((64, arena.num_hunters), dtype=np.int64))
assert not compiled, compiled
print(catch_arena.__file__)
"""
LEVELS = """
import json, sys
import numpy as np
from catch_arena import scenario
from catch_arena.core.vectors import PLAYED
from catch_arena.engine import engine, prebuilt
from catch_arena.scenarios import SCENARIOS

def played(config, num_arenas, code):
    engine.prebuilt_code = lambda lanes, *, options: code
    arenas = engine.Engine(config, num_arenas, auto_reset=True)
    assert isinstance(arenas._run, prebuilt.PrebuiltRun) == (code is not None)
    arenas.reset(np.arange(num_arenas, dtype=np.uint64))
    rng = np.random.default_rng(1)
    hunters = num_arenas, config.hunters
    for _ in range(150):
        arenas.step(
            rng.integers(0, config.targets_seen + 1, hunters),
            rng.uniform(-1, 1, (*hunters, 2)).astype(np.float32),
            rng.uniform(-1, 1, (num_arenas, config.prey, 2)).astype(np.float32) if config.prey else None,
        )
    return arenas.save().tobytes()

configs = [scenario(name, time_limit_s=10) for name in SCENARIOS]
configs += [scenario("standard", control=control, time_limit_s=10) for control in ("velocity", "full")]
settings = [engine.settings_of(config, with_parts=True, any_control=False) for config in configs]
options = [engine.state.options_of(numbers) for numbers in settings]
compared = {}
for code in json.loads((prebuilt.FOLDER / prebuilt.MANIFEST).read_text())["code"]:
    if prebuilt.runs_here(code):
        compared[code["file"]] = 0
        function = prebuilt.load(code)
        for config, asked in zip(configs, options):
            if bool(asked) == code["options"]:
                num_arenas = 1 if code["lanes"] == 1 else 40
                wanted = played(config, num_arenas, None)
                assert played(config, num_arenas, function) == wanted, (code["file"], config)
                compared[code["file"]] += 1
print(json.dumps(compared))
"""
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "PYTHON"))}
"""Without the sources here, which pip would call installed."""
pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(sysconfig.get_platform() != "linux-x86_64", reason="it is built for Linux on x86-64"),
]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built as for a release."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([sys.executable, "scripts/wheel", "--out", folder], cwd=ROOT, check=True)
    (built,) = folder.iterdir()
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Runs Python with the wheel, and not with the sources here, and an empty cache; what it prints, and that cache."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", python]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", wheel], env=ENVIRONMENT, check=True)
    own = Path(sysconfig.get_path("purelib", vars={"base": folder}))
    (own / "dependencies.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")

    def run(cache, *arguments, **settings):
        environment = {**ENVIRONMENT, "NUMBA_CACHE_DIR": str(cache), "PYTHONSAFEPATH": "1", **settings}
        command = [python, *arguments]
        finished = subprocess.run(command, cwd=ROOT, env=environment, check=False, capture_output=True, text=True)
        assert finished.returncode == 0, finished.stdout + finished.stderr
        return finished

    run.folder = folder
    return run


def test_pip_gives_it_to_linux_on_x86_64_alone(wheel):
    """Its metadata say so too, and it has no other code than what the manifest lists."""
    assert wheel.name.endswith("-py3-none-manylinux_2_17_x86_64.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        about = archive.read(next(name for name in names if name.endswith("WHEEL"))).decode()
        assert "Tag: py3-none-manylinux_2_17_x86_64\n" in about
        assert "Root-Is-Purelib: false\n" in about
        manifest = json.loads(archive.read("catch_arena/engine/machine_code/manifest.json"))
        assert manifest["made_with"]["python"] == platform.python_version()
        code = {f"catch_arena/engine/machine_code/{code['file']}" for code in manifest["code"]}
        assert code == {name for name in names if name.endswith((".o", ".so"))}
        assert len(code) == 12


def test_the_first_steps_compile_nothing(installed, tmp_path):
    """Of one arena and of a batch, with the common rules and with all; the cache is empty, and stays so."""
    finished = installed(tmp_path, "-c", FIRST_STEPS)
    assert Path(finished.stdout.strip()).is_relative_to(installed.folder)
    assert not finished.stderr
    assert not list(tmp_path.rglob("*.nb*"))


def test_the_compiler_is_used_where_it_is_asked_for(installed, tmp_path):
    installed(tmp_path, "-c", "import catch_arena as c; c.Engine(c.scenario('duel'))", CATCH_ARENA_COMPILE="1")
    assert list(tmp_path.rglob("tick.run-*.nbi"))


def test_every_level_of_this_processor_plays_the_bits_that_the_compiler_plays(installed, tmp_path):
    """All scenarios, and all ways of control, with random actions: states, views, rewards and figures."""
    compared = json.loads(installed(tmp_path, "-c", LEVELS).stdout)
    assert len(compared) in {4, 8, 12}
    assert all(compared.values())


def test_the_golden_matches_and_the_oracle_are_played_by_the_wheel(installed, tmp_path):
    """By what the wheel has installed, and without compiling a step."""
    tests = ["tests/golden", "tests/properties/test_engine_equals_oracle.py", "tests/properties/test_batch.py"]
    finished = installed(tmp_path, "-m", "pytest", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", *tests)
    assert " passed" in finished.stdout
    assert not list(tmp_path.rglob("tick.run-*"))


def test_it_can_be_made_again_byte_for_byte(wheel):
    """By anybody who has the same versions of what it is made with."""
    command = [sys.executable, "scripts/wheel", "--verify", wheel]
    said = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert said.splitlines()[-1].endswith(" files are what these sources make, byte for byte")


def test_a_wheel_with_another_file_is_told(wheel, tmp_path):
    """In the program's own function: building once more would take a minute."""
    spec = importlib.util.spec_from_file_location("wheel_script", ROOT / "scripts" / "wheel" / "__main__.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    files = script.contents(wheel)
    name = "catch_arena/engine/machine_code/x86-64-v2-1-all.o"
    script.write(tmp_path / wheel.name, {**files, name: files[name][:-1] + b"?", "catch_arena/more.py": b""})
    with pytest.raises(SystemExit, match=f"is not what these sources make here: {name}, catch_arena/more.py"):
        script.compare(tmp_path / wheel.name, files)
