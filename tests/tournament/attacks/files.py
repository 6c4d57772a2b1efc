"""Attacks on files: the rival's, the tournament's, the user's, and its own where somebody else will meet them."""

import os
import shutil
import sqlite3
import stat
import threading
import time
from contextlib import suppress
from pathlib import Path

from tournament.attacks.kit import FACTS, ancestors, relatives, secrets_in, tell


def reads_the_rivals_files(own):
    for path in Path(FACTS["rival"]).iterdir():
        tell(secrets_in(path.read_bytes()))


def changes_the_rivals_source(own):
    with open(Path(FACTS["rival"], "rival.py"), "a") as source:
        source.write("\n# changed\n")


def reads_the_files_of_a_rival_that_lies_in_the_same_folder(own):
    for path in Path(__file__).parent.glob("rival*"):
        tell(secrets_in(path.read_bytes()))


def reads_a_file_in_the_same_folder_whose_name_is_nobodys(own):
    """It may be a rival's, or belong to all."""
    tell(secrets_in(Path(__file__).with_name("notes_of_nobody.txt").read_bytes()))


def follows_links_that_were_handed_in(own):
    for place in ("data", "home/key"):
        try:
            tell(secrets_in((Path(__file__).parent / place).read_bytes()))
        except OSError:
            continue


def names_a_file_that_is_not_its_own_as_its_source(own):
    """The tournament reads what an agent of `package.module:Class` says that it comes from, for its digest."""


def says_that_its_source_is_its_memory():
    from catch_arena.tournament.isolation import fork_server

    fork_server.sources_of = lambda spec: ["/proc/self/mem"]  # a file that cannot be read from its beginning


def names_a_source_that_no_file_can_have(own):
    """Longer than a path may be: whoever looks for it is told so by the system."""


def says_that_its_source_is_very_long():
    from catch_arena.tournament.isolation import fork_server

    fork_server.sources_of = lambda spec: ["x" * 9999]


class Told(BaseException):
    """What it has found: a grade shows why an agent forfeited."""


def reads_the_spec_that_it_is_graded_by(own):
    found = []
    for path in (Path(FACTS["spec"]), Path(FACTS["spec"]).with_name("hidden_seeds.txt")):
        try:
            found.append(path.read_text())
        except OSError:
            continue
    raise Told(found)


def reads_the_rivals_working_folder(own):
    for path in Path.cwd().parent.glob("*/*.txt"):
        tell(secrets_in(path.read_bytes()))


def changes_what_the_rival_has_written(own):
    for path in Path.cwd().parent.glob("*/notes.txt"):
        path.write_text("nothing")


def finds_the_rivals_working_folder_through_proc(own):
    for pid in relatives():
        try:
            tell(secrets_in(Path(f"/proc/{pid}/cwd/notes.txt").read_bytes()))
        except OSError:
            continue


def reads_a_file_in_the_users_home(own):
    tell(secrets_in(Path(FACTS["home"], "key").read_bytes()))


def lists_the_users_home(own):
    tell(f"{len(os.listdir(FACTS['real home']))} entries")


def finds_a_way_out_through_proc(own):
    for pid in ["self", *relatives()]:
        for way in ("root", "cwd/..", "cwd/../.."):
            try:
                tell(secrets_in(Path(f"/proc/{pid}/{way}/{FACTS['home']}/key").read_bytes()))
            except OSError:
                continue


def writes_into_the_store(own):
    with sqlite3.connect(Path(FACTS["out"], "tournament.sqlite")) as store:
        store.execute("CREATE TABLE IF NOT EXISTS mine (x)")


def reads_the_replay_of_a_match_with_the_same_targets(own):
    """In a block's second match, that of its first: all targets appear alike. Only one block is played."""
    for path in Path(FACTS["out"], "replays").glob("*.replay"):
        tell(f"replay of {len(path.read_bytes())} bytes")


def changes_a_replay(own):
    for path in Path(FACTS["out"], "replays").glob("*.replay"):
        path.write_bytes(b"changed")


def reads_the_rivals_log(own):
    tell(secrets_in(Path(FACTS["out"], "logs", "rival.log").read_bytes()))


def removes_its_own_source_while_it_plays(own):
    Path(__file__).unlink()


def changes_its_own_source_between_matches(own):
    with open(__file__, "a") as source:
        source.write("\n# changed\n")


def writes_a_module_that_python_imports_at_every_start(own):
    Path(FACTS["packages"], "sitecustomize.py").write_text("print('mine')")


def opens_a_module_of_the_package_for_writing(own):
    import catch_arena

    os.close(os.open(catch_arena.__file__, os.O_WRONLY))  # and writes nothing
    tell("opened")


def links_from_its_folder_to_somebody_elses(own):
    """Who clears up may follow."""
    os.symlink(FACTS["home"], "link")
    os.symlink(Path(FACTS["home"], "key"), "linked")
    os.mkdir("folder")
    os.symlink(FACTS["home"], "folder/link")


def swaps_a_folder_and_a_link_while_they_are_cleared_up(own):
    """A thread of its fork server does, which lives on."""


def swaps_for_ever():
    def swap():
        while True:
            for make in (os.mkdir, lambda name: os.symlink(FACTS["home"], name)):
                for name in ("swapped", "swapped2"):
                    try:
                        make(name)
                    except OSError:
                        continue
                for name in ("swapped", "swapped2"):
                    try:
                        os.rmdir(name)
                    except OSError:
                        try:
                            os.unlink(name)
                        except OSError:
                            continue

    threading.Thread(target=swap, daemon=True).start()


def puts_a_link_in_the_place_of_its_folder(own):
    here = Path.cwd()
    here.rename(f"{here}.old")
    here.symlink_to(FACTS["home"])


def takes_the_folder_of_the_next_seat(own):
    """A thread of its fork server makes it anew whenever it is gone."""


def takes_all_seats():
    def take():
        while True:
            for seat in range(4):
                try:
                    os.mkdir(Path.cwd().parent / f"seat_{seat}")
                except OSError:
                    time.sleep(0.001)

    threading.Thread(target=take, daemon=True).start()


def removes_the_folder_that_all_work_in(own):
    shutil.rmtree(Path.cwd().parent)


def digs_folders_too_deep_to_be_removed(own):
    for _ in range(1500):
        os.mkdir("d" * 40)
        os.chdir("d" * 40)


def forbids_its_own_folder(own):
    os.mkdir("closed")
    Path("closed", "file").write_text("")
    os.chmod("closed", 0)
    os.chmod(".", 0)


def makes_its_folder_immutable(own):
    import array
    import fcntl

    Path("file").write_text("")
    for name in ("file", "."):
        there = os.open(name, os.O_RDONLY)
        fcntl.ioctl(there, 0x40086602, array.array("l", [0x10]))  # FS_IOC_SETFLAGS, FS_IMMUTABLE_FL
    tell("immutable")


def leaves_a_pipe_and_a_socket_in_its_folder(own):
    import socket

    os.mkfifo("pipe")
    socket.socket(socket.AF_UNIX).bind("socket")


def makes_a_device(own):
    os.mknod("null", stat.S_IFCHR | 0o666, os.makedev(1, 3))
    os.close(os.open("null", os.O_RDWR))
    tell("device")


def opens_a_disk_of_this_machine(own):
    for line in Path("/proc/partitions").read_text().splitlines()[2:]:
        try:
            os.close(os.open(f"/dev/{line.split()[3]}", os.O_RDONLY))
        except OSError:
            continue
        tell("disk")


def writes_a_file_of_100_gb_with_holes(own):
    os.close(os.open("holes", os.O_WRONLY | os.O_CREAT))
    os.truncate("holes", 100 << 30)
    tell("100 GB")


def writes_many_files(own):
    """Each is small enough."""
    for number in range(4000):
        Path(f"{number}").write_bytes(bytes(32 << 10))
    tell("128 MB")


def finds_a_control_group_that_it_may_change(own):
    for place, _, names in os.walk("/sys/fs/cgroup"):
        if "cgroup.procs" in names and os.access(f"{place}/cgroup.procs", os.W_OK):
            tell(place)
            return


def finds_the_tournaments_folders_through_its_descriptors(own):
    for pid in ancestors():
        with suppress(OSError):
            for file in Path(f"/proc/{pid}/fd").iterdir():
                tell(os.readlink(file))
