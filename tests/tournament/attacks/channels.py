"""Attacks that carry something somewhere: out of this machine, to another agent, or from one match to the next.

Two agents in league are an attacker and an accomplice, who knows the secret and sends it.
"""

import ctypes
import fcntl
import mmap
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

from tournament.attacks.kit import FACTS, secret_of_mine, secrets_in, tell

_PATIENCE_S = 2.0


def sends_something_out_by_network(own):
    with socket.create_connection(("127.0.0.1", FACTS["port"]), 5) as world:
        world.sendall(b"hello, world")


def finds_an_interface_of_the_network(own):
    for _, name in socket.if_nameindex():
        if name != "lo":
            tell(name)


def listens_for_an_accomplice(listener):
    with listener:
        listener.listen()
        listener.settimeout(_PATIENCE_S)
        connection, _ = listener.accept()
        tell(secrets_in(connection.recv(100)))


def speaks_to(family, address):
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline:
        with socket.socket(family) as accomplice:
            if accomplice.connect_ex(address) == 0:
                accomplice.sendall(secret_of_mine())
                return
        time.sleep(0.05)


def hears_an_accomplice_by_tcp(own):
    listens_for_an_accomplice(socket.create_server(("127.0.0.1", FACTS["free port"])))


def sends_the_secret_by_tcp(own):
    speaks_to(socket.AF_INET, ("127.0.0.1", FACTS["free port"]))


def hears_an_accomplice_by_an_abstract_socket(own):
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(f"\0{FACTS['folder']}")
    listens_for_an_accomplice(listener)


def sends_the_secret_by_an_abstract_socket(own):
    speaks_to(socket.AF_UNIX, f"\0{FACTS['folder']}")


def hears_an_accomplice_by_a_socket_among_the_temporary_files(own):
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(f"/tmp/{FACTS['token']}")
    listens_for_an_accomplice(listener)
    os.unlink(f"/tmp/{FACTS['token']}")


def sends_the_secret_by_a_socket_among_the_temporary_files(own):
    speaks_to(socket.AF_UNIX, f"/tmp/{FACTS['token']}")


def reads_until_an_accomplice_has_written(path):
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline:
        if path.exists() and (found := secrets_in(path.read_bytes())):
            tell(found)
            path.unlink()
            return
        time.sleep(0.05)


def hears_an_accomplice_by_shared_memory(own):
    reads_until_an_accomplice_has_written(Path("/dev/shm", FACTS["token"]))


def sends_the_secret_by_shared_memory(own):
    Path("/dev/shm", FACTS["token"]).write_bytes(secret_of_mine())


def hears_an_accomplice_by_a_temporary_file(own):
    reads_until_an_accomplice_has_written(Path("/tmp", FACTS["token"]))


def sends_the_secret_by_a_temporary_file(own):
    Path("/tmp", FACTS["token"]).write_bytes(secret_of_mine())


def attached(size_if_new):
    """System V's shared memory with a number that both know."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.shmat.restype = ctypes.c_void_p
    number = libc.shmget(FACTS["number"], 4096, 0o1600 if size_if_new else 0o600)
    return None if number < 0 else (ctypes.c_char * 4096).from_address(libc.shmat(number, None, 0))


def removes_shared_memory():
    libc = ctypes.CDLL(None, use_errno=True)
    libc.shmctl(libc.shmget(FACTS["number"], 4096, 0o600), 0, None)


def hears_an_accomplice_by_system_v_shared_memory(own):
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline:
        if (shared := attached(False)) is not None and (found := secrets_in(shared.raw)):
            tell(found)
            removes_shared_memory()
            return
        time.sleep(0.05)


def sends_the_secret_by_system_v_shared_memory(own):
    attached(True).value = secret_of_mine()


def shared_files():
    """Of Python's own library: 32 for bits, and one that says that they are there."""
    library = sorted(Path(os.__file__).parent.glob("*.py"))
    first = FACTS["number"] % (len(library) - 33)
    return library[first : first + 33]


def is_locked(path):
    with open(path) as shared:
        try:
            fcntl.flock(shared, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False


def hears_an_accomplice_by_locks_on_files_that_all_may_read(own):
    """A file for each bit: one that is locked is a one. Nobody can hide Python's own library."""
    *bits, ready = shared_files()
    deadline = time.monotonic() + _PATIENCE_S
    while not is_locked(ready) and time.monotonic() < deadline:
        time.sleep(0.02)
    heard = sum(is_locked(path) << place for place, path in enumerate(bits))
    tell(f"bits {heard:08x}")


def sends_the_secret_by_locks_on_files_that_all_may_read(own):
    *bits, ready = shared_files()
    said = int(secret_of_mine()[7:15], 16)
    locked = [open(path) for place, path in enumerate(bits) if said >> place & 1]
    for shared in (*locked, open(ready)):
        fcntl.flock(shared, fcntl.LOCK_EX)
    time.sleep(1)


def remembers(recall, keep):
    """Tell what a match before has kept, or keep something for the next."""
    if content := recall():
        tell(f"carried {content}")
    else:
        keep(b"all that I saw")


def remembers_a_match_by_a_file(path):
    def recall():
        if path.exists():
            content = path.read_bytes()
            path.unlink()
            return content
        return b""

    remembers(recall, path.write_bytes)


def remembers_a_match_by_a_temporary_file(own):
    remembers_a_match_by_a_file(Path("/tmp", FACTS["token"]))


def remembers_a_match_by_a_file_in_its_home(own):
    remembers_a_match_by_a_file(Path.home() / FACTS["token"])


def remembers_a_match_by_a_file_beside_its_source(own):
    remembers_a_match_by_a_file(Path(__file__).with_name("memory"))


def remembers_a_match_by_shared_memory(own):
    remembers_a_match_by_a_file(Path("/dev/shm", FACTS["token"]))


def remembers_a_match_by_system_v_shared_memory(own):
    shared = attached(False)
    if shared is not None:
        tell(f"carried {shared.value}")
        removes_shared_memory()
    else:
        attached(True).value = b"all that I saw"


def remembers_a_match_by_a_posix_message_queue(own):
    """It lasts as long as the namespaces, or the machine."""
    libc = ctypes.CDLL(None)
    name = f"/{FACTS['token']}".encode()
    queue = libc.mq_open(name, os.O_RDWR | os.O_CREAT | os.O_NONBLOCK, 0o600, None)
    if queue < 0:
        return
    content = ctypes.create_string_buffer(8192)
    if libc.mq_receive(queue, content, 8192, None) > 0:
        tell(f"carried {content.value}")
        libc.mq_unlink(name)
    else:
        libc.mq_send(queue, b"all that I saw", 14, 0)


def remembers_a_match_by_memory_that_its_fork_server_shares(own):
    """Mapped when its module is imported, once for all its matches."""
    remembers(lambda: shared[:14].strip(b"\0"), shared.write)


def maps_memory_to_share():
    global shared
    shared = mmap.mmap(-1, 4096)


def remembers_a_match_by_a_key_that_the_kernel_keeps(own):
    """In the keyring of its user."""
    libc = ctypes.CDLL(None, use_errno=True)
    ring, name = -4, FACTS["token"].encode()
    key = libc.syscall(250, 10, ring, b"user", name, 0)  # keyctl, search
    if key >= 0:
        tell(f"carried the key {key}")
        libc.syscall(250, 9, key, ring)  # unlink
    else:
        libc.syscall(248, b"user", name, b"all that I saw", 14, ring)  # add_key


def remembers_a_match_by_a_thread_of_its_fork_server(own):
    """It listens on a socket, and answers whoever speaks to it."""
    with socket.socket(socket.AF_UNIX) as speaker:
        speaker.connect(f"\0{FACTS['token']}")
        speaker.settimeout(_PATIENCE_S)
        speaker.sendall(b"all that I saw")
        if content := speaker.recv(100).strip():
            tell(f"carried {content}")


def starts_a_thread_that_listens():
    def listen():
        heard = b" "
        with socket.socket(socket.AF_UNIX) as listener:
            while listener.bind(f"\0{FACTS['token']}"):
                pass
            listener.listen()
            while True:
                connection, _ = listener.accept()
                with connection:
                    connection.sendall(heard)
                    heard = connection.recv(100)

    threading.Thread(target=listen, daemon=True).start()


def works_on_between_its_matches(own):
    """A thread of its fork server counts in memory that it shares with its forks: nobody's time is limited there."""
    count = int.from_bytes(counted[:8], "little")
    time.sleep(0.2)
    if int.from_bytes(counted[:8], "little") > count:
        tell("it works on")


def counts_for_ever():
    global counted
    counted = mmap.mmap(-1, 8)

    def count():
        number = 0
        while True:
            number += 1
            counted[:8] = number.to_bytes(8, "little")
            time.sleep(0.001)  # this machine is others' too

    threading.Thread(target=count, daemon=True).start()


def finds_descriptors_that_are_not_its_own(own):
    """Its own are the standard three, its lines and its answers."""
    for name in os.listdir("/proc/self/fd"):
        if int(name) > 4 and os.path.exists(there := f"/proc/self/fd/{name}"):
            tell(f"{name}: {os.readlink(there)}")
            with suppress(OSError):
                os.write(int(name), b'{"error":"mine"}\n')
