"""Run the tests of real ROS 2 nodes: rclpy with its default middleware, and interface packages built here.

Each Python gets an environment in .venv-ros, which is kept: ROS 2 Kilted's wheels, this checkout, and the packages of
tests/ros_nodes/interfaces. The default is one Python; `--all` takes each that has wheels.
"""

import argparse
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pythons

ROOT = Path(__file__).parents[1]
ENVIRONMENTS = ROOT / ".venv-ros"
INTERFACES = ROOT / "tests" / "ros_nodes" / "interfaces"
UV = Path(sys.executable).with_name("uv")
VERSIONS = ("3.11", "3.12", "3.13")
"""Python versions for which ROS 2 Kilted has wheels."""
WHEELS = (
    "ros-kilted-rclpy",
    "ros-kilted-rmw-fastrtps-cpp",
    "ros-kilted-geometry-msgs",
    "ros-kilted-std-srvs",
    "ros-kilted-rosgraph-msgs",
    # tools that build interface packages
    "ros-kilted-ament-cmake",
    "ros-kilted-rosidl-default-generators",
    "ros-ament-cmake-include-directories",
    "ros-ament-cmake-ros-core",
    "ros-ament-package",
    "ros-rosidl-core-generators",
    "catkin-pkg",
    "cmake<4",
    "empy==3.3.4",
    "lark",
    "numpy>=2",
    "setuptools",
)
PACKAGE_XML = """<package format="3"><name>{name}</name><version>1.0.0</version><description>For a test</description>
<maintainer email="test@example.com">test</maintainer><license>MIT</license>
<buildtool_depend>ament_cmake</buildtool_depend><member_of_group>rosidl_interface_packages</member_of_group></package>
"""
CMAKE = """cmake_minimum_required(VERSION 3.10)
project({name})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces({name} {files})
ament_package()
"""


def environment_of(python: Path) -> Path:
    """Return the folder of a Python's environment, which is made unless it exists.

    Raises:
        SystemExit: something that it needs is missing; the message is one line.
    """
    version = output(python, "-c", "import sys; print(*sys.version_info[:2], sep='.')")
    folder = ENVIRONMENTS / version
    if platform.system() != "Linux" or platform.machine() != "x86_64" or version not in VERSIONS:
        raise SystemExit(
            f"real ROS 2 nodes are not tested: wheels need Linux on x86-64 and Python {', '.join(VERSIONS)}, "
            f"got {platform.system()} on {platform.machine()} and Python {version}"
        )
    if missing := [one for one in ("c++", "make") if shutil.which(one) is None]:
        raise SystemExit(
            f"real ROS 2 nodes are not tested: {' and '.join(missing)} missing; apt-get install build-essential"
        )
    files = [path for path in sorted(INTERFACES.rglob("*")) if path.is_file()]
    state = hashlib.sha256(b"".join(path.read_bytes() for path in (Path(__file__), *files))).hexdigest()
    ready = folder / "ready"
    if not ready.exists() or ready.read_text() != state:
        print(f"making {folder.relative_to(ROOT)} (takes a few minutes)", flush=True)
        shutil.rmtree(folder, ignore_errors=True)
        folder.parent.mkdir(exist_ok=True)
        make(folder, python, version)
        ready.write_text(state)
    return folder


def make(folder: Path, python: Path, version: str) -> None:
    """Install the wheels and this checkout, and build each package of INTERFACES in a folder of its own."""
    own = folder / "bin" / "python"
    run(folder, UV, "venv", "--python", python, folder)
    index = output(sys.executable, "-m", "pip", "config", "get", "global.index-url") or os.environ.get("PIP_INDEX_URL")
    chosen = ("--default-index", index) if index else ()
    run(folder, UV, "pip", "install", *chosen, "--python", own, *WHEELS, "--editable", f"{ROOT}[render]")
    include = output(own, "-c", "import numpy, sysconfig; print(sysconfig.get_path('include'), numpy.get_include())")
    built_with = f"/opt/python/cp{version.replace('.', '')}-cp{version.replace('.', '')}/"
    for file in (folder / "share").rglob("*.cmake"):
        if built_with in (text := file.read_text()):  # two paths of the machine that built the wheels
            headers, arrays = include.split()
            text = re.sub(rf"{built_with}[^;\" ]*/numpy/_core/include", arrays, text)
            file.unlink()  # the file may be a link to uv's cache
            file.write_text(re.sub(rf"{built_with}include/python[0-9.]+", headers, text))
    for package in sorted(one for one in INTERFACES.iterdir() if one.is_dir()):
        source, build = folder / "src" / package.name, folder / "build" / package.name
        shutil.copytree(package, source)
        files = sorted(str(one.relative_to(source)) for one in source.glob("*/*.*"))
        (source / "package.xml").write_text(PACKAGE_XML.format(name=package.name))
        (source / "CMakeLists.txt").write_text(CMAKE.format(name=package.name, files=" ".join(files)))
        prefix = f"-DCMAKE_INSTALL_PREFIX={folder / 'packages' / package.name}"
        run(folder, "cmake", "-S", source, "-B", build, prefix, "-DBUILD_TESTING=OFF")
        run(folder, "cmake", "--build", build, "--target", "install", "-j", "2")


def run(folder: Path, *command: str | Path) -> None:
    """Run a command in an environment, with a log next to it; end the script if it fails."""
    environment = {
        "AMENT_PREFIX_PATH": str(folder),
        "CMAKE_PREFIX_PATH": str(folder),
        "LD_LIBRARY_PATH": str(folder / "lib"),
        "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }
    if not pythons.run(folder.parent / f"{folder.name}.log", ROOT, *command, **environment):
        raise SystemExit(f"real ROS 2 nodes are not tested: {Path(command[0]).name} failed")


def output(*command: str | Path) -> str:
    """Return the first line that a command prints; empty if it fails."""
    lines = subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()
    return lines[0] if lines else ""


def main() -> int:
    """Test one Python, or all of VERSIONS that are found; return 1 if a test fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="test each installed Python that has wheels")
    parser.add_argument(
        "--if-possible", action="store_true", help="without wheels or a compiler, print the reason and exit with 0"
    )
    given, rest = parser.parse_known_args()
    own = sysconfig.get_python_version()
    found = {
        one: python for one in VERSIONS if (python := Path(sys.executable) if one == own else pythons.find_python(one))
    }
    wanted = list(found) if given.all else [own if own in found else next(iter(found), own)]
    codes = []
    for version in wanted:
        try:
            folder = environment_of(found.get(version, Path(sys.executable)))
        except SystemExit as missing:
            if not given.if_possible:
                raise
            print(missing)
            continue
        print(f"Python {version}", flush=True)
        pytest = [Path(sys.executable).with_name("pytest"), "-m", "rclpy", *(rest or ["tests/ros_nodes"])]
        codes.append(subprocess.run(pytest, cwd=ROOT, env={**os.environ, "ROS_NODES": str(folder)}, check=False))
    return int(any(code.returncode for code in codes))


if __name__ == "__main__":
    sys.exit(main())
