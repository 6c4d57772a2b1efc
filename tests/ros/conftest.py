"""Test files left out on systems without wheels of cyclonedds, and stand-ins for packages of ROS."""

import platform
import sys
from types import ModuleType, SimpleNamespace

import pytest

collect_ignore = []
if sys.version_info >= (3, 14) or (sys.platform == "linux" and platform.machine() != "x86_64"):
    collect_ignore += [
        "test_dds_types.py",
        "test_dds_bus.py",
        "test_matches.py",
        "test_nodes.py",
    ]  # cyclonedds has no wheels there


def message_class(fields, others):
    class Message(SimpleNamespace):
        def __init__(self):
            super().__init__(
                **{
                    name: others[word.partition("/")[2]]() if "/" in word and not word.startswith("sequence<") else None
                    for name, word in fields.items()
                }
            )

        get_fields_and_field_types = staticmethod(lambda: dict(fields))

    return Message


@pytest.fixture
def package(monkeypatch):
    """Makes a package with these messages and services importable."""

    def make(name, msg, srv):
        folders = {"msg": ModuleType(f"{name}.msg"), "srv": ModuleType(f"{name}.srv")}
        for word, fields in msg.items():
            setattr(folders["msg"], word, message_class(fields, vars(folders["msg"])))
        for word, (request, response) in srv.items():
            halves = (message_class(half, vars(folders["msg"])) for half in (request, response))
            service = SimpleNamespace(**dict(zip(("Request", "Response"), halves, strict=True)))
            setattr(folders["srv"], word, service)
            setattr(folders["srv"], f"{word}_Event", SimpleNamespace())
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
        for folder, module in folders.items():
            monkeypatch.setitem(sys.modules, f"{name}.{folder}", module)

    return make
