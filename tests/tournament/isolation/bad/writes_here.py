"""Writes into its working folder, tells where that is, and makes it hard to remove."""

from pathlib import Path


class Agent:
    def reset(self, seed):
        Path("results.jsonl").write_text("I won\n")
        print("folder", Path.cwd())
        hidden = Path("a", "b")
        hidden.mkdir(parents=True)
        (hidden / "c").touch()
        hidden.chmod(0)
        Path("out").symlink_to("/")

    def act(self, view):
        return 0
