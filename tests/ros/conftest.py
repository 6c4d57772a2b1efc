"""What can be tested where."""

import platform
import sys

collect_ignore = []
if sys.version_info >= (3, 14) or (sys.platform == "linux" and platform.machine() != "x86_64"):
    collect_ignore += [
        "test_dds_types.py",
        "test_dds_bus.py",
        "test_matches.py",
        "test_nodes.py",
    ]  # cyclonedds has no wheels there
